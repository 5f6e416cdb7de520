"""The half-space in elements: axisymmetric elasticity, Lagrange-multiplier contact, Boussinesq far field."""
