# Clean pictures of ordinary light, without bias.
import bpy

settings = bpy.context.scene.vernier
settings.reset_quality()
settings.samples = 512
