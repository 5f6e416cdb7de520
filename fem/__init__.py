"""The half-space in elements: axisymmetric elasticity, multipliers, Boussinesq's far field."""
