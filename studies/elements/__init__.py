"""Which pair of displacement and pressure spaces is stable."""
