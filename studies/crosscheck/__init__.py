"""Run a scene by every method, estimate errors, and compare."""
