"""What is asked: the sections of a scene, and the non-dimensional problem that they pose."""
