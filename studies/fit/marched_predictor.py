"""x."""
def marched_predictor(*a): raise NotImplementedError
