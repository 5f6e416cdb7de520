"""The study of speed against accuracy."""
