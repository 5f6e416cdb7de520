"""Versions of ringwear and of what it computes with: results carry them."""

from functools import cache
from importlib.metadata import PackageNotFoundError, version


@cache
def versions() -> dict[str, str]:
    """Versions of ringwear and of what it computes with."""
    names = ("ringwear", "numpy", "scipy", "scikit-fem", "gmsh", "kvxopt", "meshio", "xarray")
    installed = {}
    for name in names:
        try:
            installed[name] = version(name)
        except PackageNotFoundError:
            installed[name] = "not installed"
    return installed
