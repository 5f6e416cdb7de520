"""The half-space in theory: dimensionality reduction, direct integration, the paper's algorithm.

The names below are loaded when they are first used. The compliance of a pressure space is
`energy.compliance` by dimensionality reduction, `ring_kernel.compliance` by boundary elements.
"""

from ..meshes import load_later

__getattr__, __all__ = load_later(
    __name__,
    {
        "direct": "displacement greatest_displacement limiting_profile rms_slope steady_pressures",
        "transforms": "line_density panel_quadrature pressure_transform profile_transform",
        "uniform_grid": "UniformGrid",
    },
)
