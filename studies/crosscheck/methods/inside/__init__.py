"""Fields inside the half-space: displacements and stresses below the punch."""
