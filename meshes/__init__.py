"""Discretisation: ring edges, the radial pressure space, and meshes of the truncated half-space."""
