"""What is discretised: ring edges, the radial pressure space, the truncated half-space."""
