"""The half-space in theory: dimensionality reduction, direct integration, and the paper's grid algorithm."""
