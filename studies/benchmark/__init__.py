"""Seconds and errors against the paper's algorithm and plain finite elements."""
