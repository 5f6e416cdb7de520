"""Wear of punches whose contact opens, closes and spreads."""
