"""What people read of a run: on the terminal, and as a page."""
