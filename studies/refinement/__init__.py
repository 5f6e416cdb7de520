"""The refinement study: ways to refine a mesh, from uniform to adaptive, and the user's meshes."""
