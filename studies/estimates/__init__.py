"""Are stated errors honest? Scenes drawn at random, an independent reference, and the study that
compares.
"""
