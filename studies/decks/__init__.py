"""Write input files (decks) for other finite-element programs, and read their results."""
