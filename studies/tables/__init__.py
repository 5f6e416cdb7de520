"""Tables: read them as other programs write them, and write them as CSV, LaTeX and text."""
