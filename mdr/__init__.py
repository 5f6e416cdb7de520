"""The half-space in theory.

Dimensionality reduction, direct integration, and the paper's grid algorithm.
"""
