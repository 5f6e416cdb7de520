"""Refine solutions to the requested tolerance, compare methods, and judge whether they agree."""
