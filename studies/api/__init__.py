"""Wear of a ringed punch on an elastic half-space, by finite elements, dimensionality reduction and direct integration."""

from importlib import import_module
from typing import TYPE_CHECKING

from ringwear.studies.problem.scene import Scene

if TYPE_CHECKING:
    from ringwear.studies.crosscheck.run import run
    from ringwear.studies.crosscheck.scope import plan
    from ringwear.studies.sweep.run import sweep

__all__ = ["Scene", "plan", "run", "sweep"]

# a scene alone does not need the numerics that these bring in
LATER = {
    "run": "ringwear.studies.crosscheck.run",
    "plan": "ringwear.studies.crosscheck.scope",
    "sweep": "ringwear.studies.sweep.run",
}


def __getattr__(name: str) -> object:
    if name in LATER:
        return getattr(import_module(LATER[name]), name)
    raise AttributeError(f"module 'ringwear' has no attribute {name!r}")
