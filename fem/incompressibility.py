"""Poisson's ratio 1/2 in finite elements: what stands for it, and what removes the error.

The stiffness of an incompressible solid against a change of volume is infinite. Finite elements
therefore take Poisson's ratio `HIGHEST_RATIO` for every ratio between it and 1/2. Contact pressures
and displacements on a homogeneous half-space depend on its plane strain modulus alone, so that they
have no error. What depends on the ratio, which is the contact on layers and all fields inside, is
computed for a second solid that differs twice as much from the nominal one, and is extrapolated
linearly from both.
"""

HIGHEST_RATIO = 0.49999
"""Poisson's ratio that replaces all values between it and 1/2.

Roundoff grows as 1 / (1 - 2 nu) or faster, and the error that the extrapolation leaves decreases as
the square of it (physics/test_thin_layers.py::test_incompressible_layers).
"""


def confined_compliance(poisson_ratio: float) -> float:
    """Return ``(1 - 2 nu) / (1 - nu)``: 2 G times strain over stress if no strain is lateral."""
    return (1 - 2 * poisson_ratio) / (1 - poisson_ratio)


def more_compressible_ratio(modelled: float, nominal: float) -> float:
    """Return the Poisson's ratio of the second solid of an extrapolation to a nominal ratio.

    Parameters
    ----------
    modelled, nominal : Poisson's ratios of the first solid and of the solid that is wanted

    Notes
    -----
    The `confined_compliance` of the result differs from the nominal one by twice as much as that of
    the first solid. A thin layer of thickness h and shear modulus G that is bonded to a stiff base
    is displaced by the confined compliance times ``h / 2 G`` under a uniform pressure, in addition
    to what an incompressible one is displaced. The linear extrapolation in this variable is
    therefore equally accurate at every thickness. In Poisson's ratio itself, it would leave a
    relative error of ``4 (a / h)^2 (1/2 - HIGHEST_RATIO)^2``.
    """
    compliance = 2 * confined_compliance(modelled) - confined_compliance(nominal)
    return (1 - compliance) / (2 - compliance)
