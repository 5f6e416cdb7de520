"""Read scenes from files and tables, validate them, and explain errors in them."""
