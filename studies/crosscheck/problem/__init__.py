"""The tables of a scene, and the non-dimensional problem that they define."""
