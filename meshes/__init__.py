"""What is discretised.

Ring edges, the radial pressure space, and the truncated half-space as plain arrays.
"""
