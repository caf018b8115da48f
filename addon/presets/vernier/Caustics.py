# Light through glass and off mirrors: paths from both ends, where there is that method.
import bpy

settings = bpy.context.scene.vernier
kept = {"rna_type", "name", "seed", "threads", "preview_samples", "preview_pause"}
kept |= {"checkpoint", "resume"}
film = {"pixel_filter", "filter_width", "film_exposure"}
for setting in set(settings.bl_rna.properties.keys()) - kept - film:
    settings.property_unset(setting)
settings.samples = 1024
methods = settings.bl_rna.properties["integrator"].enum_items.keys()
settings.integrator = next(name for name in ("BDPT", "PATH") if name in methods)
