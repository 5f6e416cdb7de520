"""Sweeps: scenes over axes of scene keys, in one labelled dataset."""
