"""What is discretised: ring edges, the radial pressure space, the truncated half-space.

The names below are loaded when they are first used: runs without finite elements load no
scikit-fem. The meshers are `quads.graded`, `triangles.mesh` (both by gmsh) and `bisection.mesh`.
"""

from collections.abc import Callable, Mapping
from importlib import import_module
from typing import Any


def load_later(package: str, files: Mapping[str, str]) -> tuple[Callable[[str], Any], list[str]]:
    """Return `__getattr__` and `__all__` of a package.

    Parameters
    ----------
    package : its name
    files : its files, each with the names that it gives, separated by spaces
    """
    places = {name: file for file, names in files.items() for name in names.split()}

    def load(name: str) -> Any:
        if name in places:
            return getattr(import_module(f"{package}.{places[name]}"), name)
        raise AttributeError(f"module {package!r} has no attribute {name!r}")

    return load, list(places)


__getattr__, __all__ = load_later(
    __name__,
    {
        "compliance": "Compliance",
        "contact_cells": "ContactCells fitted_space",
        "errors": "MeshError RingwearError SceneError SolverError",
        "half_space": "areas as_half_space contact_radii quality segments truncation turned",
        "pressure_space": "PressureSpace shape_slopes shapes",
        "radial": "Array Indices alternating_edges graded_breakpoints layer_degrees ring_areas "
        "ring_of",
        "sizes": "SizeField",
    },
)
