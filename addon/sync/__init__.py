"""From Blender's evaluated depsgraph to a scene description, one kind of datablock per module."""
