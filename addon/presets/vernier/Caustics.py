import bpy

settings = bpy.context.scene.vernier

# Light through glass and off mirrors: paths from both ends, where there is that method.
methods = settings.bl_rna.properties["integrator"].enum_items.keys()
settings.integrator = next(name for name in ("BDPT", "PATH") if name in methods)
settings.samples = 1024
settings.time_limit = 0.0
settings.direct_light = "MIS"
settings.roulette_threshold = 0.25
settings.roulette_start = 0
settings.max_bounces = -1
settings.diffuse_bounces = -1
settings.glossy_bounces = -1
settings.transmission_bounces = -1
settings.transparent_bounces = -1
settings.clamp_direct = 0.0
settings.clamp_indirect = 0.0
