"""The half-space in theory: dimensionality reduction, direct integration, the paper's algorithm."""
