"""The half-space in finite elements: axisymmetric elasticity, Lagrange multipliers, far field."""
