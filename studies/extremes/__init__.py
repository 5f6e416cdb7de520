"""A map of the limits."""
