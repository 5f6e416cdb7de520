"""The half-space in elements: axisymmetric elasticity, multipliers, Boussinesq's far field.

The names below are loaded when they are first used.
"""

from ..meshes import load_later

__getattr__, __all__ = load_later(
    __name__,
    {
        "condensation": "fill_reducing_order trailing_factor",
        "contact_meshes": "even_half_space fitted_half_space",
        "elasticity": "AxisymmetricElasticity",
        "far_field": "enough_poles exterior_stiffness poles",
        "half_space": "HalfSpace pressure_space",
        "stresses": "displacements sampled stresses von_mises",
        "weak_form": "element_of_degree moduli stiffness",
    },
)
