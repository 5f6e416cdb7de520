"""Numerical studies of a single part of the method: time steps, and the outer boundary."""
