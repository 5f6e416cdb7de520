"""Quantities sampled from a wear history, their norms, and the numbers of the answer."""
