# A quick look: few samples, and what is bright by chance is clamped (which darkens).
import bpy

settings = bpy.context.scene.vernier
settings.reset_quality()
settings.samples = 32
settings.max_bounces = 8
settings.clamp_indirect = 10.0
