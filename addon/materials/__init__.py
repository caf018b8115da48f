"""From Blender's shader node trees to the flat graphs of the scene description."""
