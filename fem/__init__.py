"""The half-space in elements.

Axisymmetric elasticity, Lagrange-multiplier contact, Boussinesq far field.
"""
