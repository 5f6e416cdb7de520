"""Methods on punches whose contact opens, closes and spreads."""
