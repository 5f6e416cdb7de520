"""How to refine a mesh: each way, from uniform to adaptive, and meshes of the user's own."""
