"""Mesh refinement, and meshes of one's own."""
