"""What is asked: the scene file, and the non-dimensional problem that it poses."""
