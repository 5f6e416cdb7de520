"""Results of other programs, held against ours."""
