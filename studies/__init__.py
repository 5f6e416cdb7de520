"""What people do with it: scenes, contact and wear on any compliance, runs, studies, figures, the command line."""

from .scene import Scene

__all__ = ["Scene", "run"]


def __getattr__(name: str) -> object:
    # `run` brings in the numerics; a scene alone does not need them
    if name == "run":
        from .runs import run

        return run
    raise AttributeError(name)
