"""Versions of ringwear and of what it computes with: results carry them."""

from importlib.metadata import PackageNotFoundError, version


def versions() -> dict[str, str]:
    """Versions of ringwear and of what it computes with."""
    known = {}
    for name in ("ringwear", "numpy", "scipy", "scikit-fem", "gmsh", "meshio", "xarray"):
        try:
            known[name] = version(name)
        except PackageNotFoundError:
            known[name] = "not installed"
    return known
