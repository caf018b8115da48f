# Light through glass and off mirrors, seen directly or through them again.
import bpy

settings = bpy.context.scene.vernier
settings.reset_quality()
settings.samples = 1024
settings.integrator = "VCM"
