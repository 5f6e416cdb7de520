"""The methods, each from a problem to its results."""
