"""The half-space in elements: axisymmetric elasticity, multipliers, Boussinesq's far field.

The names below are loaded when they are first used.
"""

from importlib import import_module
from typing import Any

_FILES = {
    "condensation": "fill_reducing_order trailing_factor",
    "contact_meshes": "even_half_space fitted_half_space",
    "elasticity": "AxisymmetricElasticity",
    "far_field": "enough_poles exterior_stiffness poles",
    "half_space": "HalfSpace pressure_space",
    "stresses": "displacements sampled stresses von_mises",
    "weak_form": "element_of_degree moduli stiffness",
}
_PLACES = {name: file for file, names in _FILES.items() for name in names.split()}
__all__ = list(_PLACES)


def __getattr__(name: str) -> Any:
    if name in _PLACES:
        return getattr(import_module(f"{__name__}.{_PLACES[name]}"), name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
