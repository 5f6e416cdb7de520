"""The errors of ringwear: raised at the door, with a message that names the remedy."""


class RingwearError(Exception):
    """Base of every error that ringwear raises on purpose."""


class SceneError(RingwearError):
    """The scene cannot be understood or modelled: names the key, the value and the remedy."""


class MeshError(RingwearError):
    """A mesh is missing, broken, or not what was asked for."""


class SolverError(RingwearError):
    """A system could not be solved to a meaningful answer."""
