"""Contact and Archard wear for any compliance of the half-space."""
