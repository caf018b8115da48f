# Clean pictures of ordinary light, without bias.
import bpy

settings = bpy.context.scene.vernier
kept = {"rna_type", "name", "seed", "threads", "preview_samples", "preview_pause"}
kept |= {"checkpoint", "resume"}
film = {"pixel_filter", "filter_width", "film_exposure"}
for setting in set(settings.bl_rna.properties.keys()) - kept - film:
    settings.property_unset(setting)
settings.samples = 512
