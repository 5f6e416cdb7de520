"""Flags of the scenes of a sweep: not computed yet, computed, or without a solution."""

PENDING, DONE, FAILED = 0, 1, 2
# what to do after a sweep has stopped
RESUME_HINT = "finished blocks are stored: continue with --resume"
