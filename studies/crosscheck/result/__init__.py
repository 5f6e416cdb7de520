"""Run a scene, and hold, describe, save and load its result."""
