"""The half-space in theory: dimensionality reduction, direct integration, the paper's algorithm.

The names below are loaded when they are first used. The compliance of a pressure space is
`energy.compliance` by dimensionality reduction, `ring_kernel.compliance` by boundary elements.
"""

from importlib import import_module
from typing import Any

_FILES = {
    "direct": "displacement greatest_displacement limiting_profile rms_slope steady_pressures",
    "transforms": "line_density panel_quadrature pressure_transform profile_transform",
    "uniform_grid": "UniformGrid",
}
_PLACES = {name: file for file, names in _FILES.items() for name in names.split()}
__all__ = list(_PLACES)


def __getattr__(name: str) -> Any:
    if name in _PLACES:
        return getattr(import_module(f"{__name__}.{_PLACES[name]}"), name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
