"""Orders of convergence."""
