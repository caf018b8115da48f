import bpy

settings = bpy.context.scene.vernier

# Clean pictures of ordinary light, without bias.
settings.integrator = "PATH"
settings.samples = 512
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
