# To compare with: very many samples of a method without bias that misses little light.
import bpy

settings = bpy.context.scene.vernier
settings.reset_quality()
settings.samples = 16384
settings.integrator = "BDPT"
