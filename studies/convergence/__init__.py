"""The study of convergence: every quantity on every way to refine, with orders of theory."""
