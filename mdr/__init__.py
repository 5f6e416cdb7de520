"""The half-space without a mesh: dimensionality reduction, ring kernel, and closed forms."""
