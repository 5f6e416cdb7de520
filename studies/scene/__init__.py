"""Scenes: what users write, read from files and tables, with what is told where they are wrong."""
