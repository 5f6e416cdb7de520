"""Studies of the numerics: orders, steps, boundaries, meshes, costs and limits."""
