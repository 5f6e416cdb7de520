"""Contact that opens, closes and spreads while the punch wears."""
