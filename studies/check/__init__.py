"""Compare results of other programs with ours, and diagnose their errors."""
