"""Fit wear coefficients and other parameters to measurements, with their uncertainty."""
