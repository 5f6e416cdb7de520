"""Seconds and memory that a run will need, predicted before it starts."""
