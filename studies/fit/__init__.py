"""Wear coefficients from measurements, with their uncertainty."""
