"""The tools behind the commands in `scripts/`: rendering, comparing and measuring.

Modules that import bpy (`blend_file`, `engines`, `outputs`, `render`, `worker`) run in processes of
their own; the others compare and report, and need no Blender.
"""
