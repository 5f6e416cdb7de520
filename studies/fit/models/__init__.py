"""Models of the punch that predict measurements."""
