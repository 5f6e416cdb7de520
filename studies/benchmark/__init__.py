"""Seconds and errors against the paper's algorithm and a bare factorisation."""
