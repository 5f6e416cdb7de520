"""The errors that ringwear raises, each with a message that names the remedy."""


class RingwearError(Exception):
    """Base of every error that ringwear raises on purpose."""


class SceneError(RingwearError):
    """The scene cannot be understood or modelled; the message names key, value and remedy."""


class MeshError(RingwearError):
    """A mesh is missing, broken, or does not meet the requirements."""


class SolverError(RingwearError):
    """A system of equations has no meaningful numerical solution."""
