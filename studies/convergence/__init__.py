"""The convergence study: orders of every quantity for every way to refine, and their theory."""
