"""The scripts that author the scenes of this folder; `python -m blend_scenes.authoring` runs them.

Every scene has one module with one function, `build(path)`, which starts from an empty file, builds
the scene with Blender's Python API and saves it. Nothing is read from disk, all randomness is
seeded, and so two runs give scenes of equal content.
"""
