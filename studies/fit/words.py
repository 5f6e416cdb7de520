"""x."""
def conclusions(fit): return ()
