"""Extreme parameters: true errors relative to promised ones, also of a naive solver."""
