# A quick look: few samples, and what is bright by chance is clamped (which darkens).
import bpy

settings = bpy.context.scene.vernier
kept = {"rna_type", "name", "seed", "threads", "preview_samples", "preview_pause"}
kept |= {"checkpoint", "resume"}
film = {"pixel_filter", "filter_width", "film_exposure"}
for setting in set(settings.bl_rna.properties.keys()) - kept - film:
    settings.property_unset(setting)
settings.samples = 32
settings.max_bounces = 8
settings.clamp_indirect = 10.0
