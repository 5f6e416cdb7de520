"""Check what a method reports against closed forms, conservation laws and reciprocity."""
