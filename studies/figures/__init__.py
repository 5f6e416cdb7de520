"""Draw the figures of a run, of a comparison and of a mesh."""
