"""Sweeps: many scenes over axes of scene keys, with their results in one labelled dataset."""
