"""Input files for finite-element programs of others, and readers of what these programs write."""
