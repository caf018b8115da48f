"""The 3D view's rendered mode: a progressive picture that follows edits and the view."""
