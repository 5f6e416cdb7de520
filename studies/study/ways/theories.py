"""Theoretical order of each measure, with its reason and source, or why there is none.

Sources:

- Babuška & Suri, The p and h-p versions of the finite element method, SIAM Review 36 (1994).
- Grisvard, Elliptic Problems in Nonsmooth Domains (1985): singular exponents where boundary
  conditions change.
- Gui & Babuška, The h, p and h-p versions of the finite element method in one dimension, Numer.
  Math. 49 (1986).
- Hairer, Nørsett & Wanner, Solving Ordinary Differential Equations I (1993).
- Sauter & Schwab, Boundary Element Methods (2011), chapter 4: Galerkin's method for operators of
  order -1.
- Stevenson, Optimality of a standard adaptive finite element method, Found. Comput. Math. 7 (2007),
  doi 10.1007/s10208-005-0183-0.
- Strang & Fix, An Analysis of the Finite Element Method (1973), chapter 8: singular functions.
"""

from ..way import LATER, OTHERS, START, Part, Theories, Theory, without_order

ROOT_AT_RIM = (
    "The displacement behaves like the square root of the distance from the rim (Grisvard 1985). "
    "Elements of one size h approximate it with an error of order h^(1/2) in the energy norm. The "
    "indentation is an energy, so that its error is the square of this (Strang & Fix 1973)."
)
ROOT_OF_PRESSURE = (
    "The pressure is infinite like the inverse square root of the distance from the rim. In a norm "
    "whose weight vanishes there, the error on the element at the rim is of order h^(1/2)."
)
ENERGY_OF_ELEMENTS = (
    "On meshes graded to every edge, displacements of degree k have errors of order h^k in the "
    "energy norm (Babuška & Suri 1994), and the error of an energy is the square of this."
)
ENERGY_OF_PRESSURES = (
    "Pressures of degree q have errors of order h^(q+3/2) in the energy norm, a Sobolev norm of "
    "order -1/2 (Sauter & Schwab 2011), and the error of the indentation is the square of this."
)
HISTORY_OF_PRESSURES = (
    "Wear involves the mean square of the pressure, in which pressures of degree q have errors of "
    "order h^(q+1) (Sauter & Schwab 2011). The errors of eigenvalues and histories are the squares "
    "of this."
)
GRADIENT = (
    "A gradient converges one order of h more slowly than the displacement, so that its mean "
    "square is of order 2q if histories are of order 2q+2 (Sauter & Schwab 2011, by an inverse "
    "inequality)."
)
MEAN_SQUARE_OF_PRESSURES = (
    "On meshes graded to every edge, pressures of degree q have errors of order h^(q+1) in the "
    "mean square (Sauter & Schwab 2011)."
)
ANALYTIC = (
    "On geometric layers the error of an energy decreases by a factor of 9 with each degree, "
    "because the function is analytic in the Bernstein ellipse up to the singular point, which is "
    "one layer away (Gui & Babuška 1986)."
)
LAYERS = (
    "No order is expected: inner layers have lower degrees, and the smallest layer shrinks with "
    "each degree, so that several kinds of error decrease together."
)
STEP = "The Euler methods have order one in the step (Hairer, Nørsett & Wanner 1993)."
BEST_ORDER = (
    "Elements of degree k have at best the order k, and refinement with this marking reaches it "
    "(Stevenson 2007)."
)
LOGARITHM = (
    "No order is expected: near ring edges slopes behave like logarithms, so that errors are "
    "powers of h times logarithms, and only the finest levels resolve the layers that wear has "
    "smoothed."
)
OTHER_NORM = (
    "No theory is known to us: the method minimises the error in the energy norm, and this is "
    "another norm."
)
MOVING_EDGES = (
    "No theory is known to us: edges of the contact lie anywhere within a cell, so that errors "
    "vary irregularly from level to level."
)
OWN_MESH = "No order is expected: how your meshes are graded is not known."
OWN_ELEMENT = "No order is expected: the polynomials in the space of your element are not known."
NO_TIME = "No order is expected: this quantity does not depend on the time steps."
LONG_STEPS = (
    "No order is expected: some steps are longer than a quarter of the earliest time after the "
    "start."
)
STEP_WITH_CONTACT = (
    "No theory is known to us if edges of the contact move: the rate of wear jumps at these edges."
)

RIM_ELEMENT = "the innermost elements at the rim and at ring edges, which stay coarse"
ROUNDOFF = "roundoff"
"""The causes of floors: errors that do not decrease with the size of the levels."""
FIRST_DEPTH, FIRST_PRESSURE = Part("indentation", START), Part("pressure", START)
ENERGIES = Part("indentation", LATER), Part("running_in_time"), Part("relaxation_time")
"""Quantities that are energies or eigenvalues."""


FOR_UNIFORM_MESHES: Theories = {
    FIRST_DEPTH: Theory(1.0, 0.0, ROOT_AT_RIM),
    FIRST_PRESSURE: Theory(0.5, 0.0, ROOT_OF_PRESSURE),
    OTHERS: Theory(reason=LOGARITHM),
}
"""Theory of elements or cells of one size, which is the same for all degrees."""
FOR_ADAPTIVE_MESHES: Theories = {Part("energy"): Theory(reason=BEST_ORDER)}
"""Theory of adaptive triangles: the best order, but no number is compared."""


def for_graded_elements(degree: int, start_floor: float, floor: float) -> Theories:
    """Return the theory of finite elements on meshes graded to every edge.

    Parameters
    ----------
    degree : polynomial degree of the displacement
    start_floor, floor : lowest relative errors at the start and of histories, due to the elements
        at the rim and at ring edges, which stay coarse
    """
    start, later = (
        Theory(2.0 * degree, each, ENERGY_OF_ELEMENTS, RIM_ELEMENT) for each in (start_floor, floor)
    )
    return dict.fromkeys(ENERGIES, later) | {FIRST_DEPTH: start} | without_order(OTHER_NORM)


def for_graded_pressures(degree: int) -> Theories:
    """Return the theory of MDR and boundary elements on graded cells, for a pressure degree.

    As the mesh is refined, the observed order of the start rises to 2 degree + 3 for even degrees
    and falls to it for odd ones: plane waves ``exp(ikx)`` at kh = 0.7 give the orders 5.34, 6.60,
    9.21 and 10.77 for degrees 1 to 4 (Fourier analysis).
    """
    later = Theory(2.0 * degree + 2, 2e-10, HISTORY_OF_PRESSURES, RIM_ELEMENT)
    theories = dict.fromkeys(ENERGIES, later) | {
        FIRST_DEPTH: Theory(2.0 * degree + 3, 1e-13, ENERGY_OF_PRESSURES, ROUNDOFF),
        Part("pressure", LATER): Theory(degree + 1.0, 1e-7, MEAN_SQUARE_OF_PRESSURES, RIM_ELEMENT),
    }
    if degree == 1:
        # higher degrees are at their floor after a few levels
        theories[Part("steady_rms_slope")] = Theory(2.0, 1e-7, GRADIENT, RIM_ELEMENT)
    return theories | without_order(OTHER_NORM)


def for_layers(order: float) -> Theories:
    """Return the theory of a rising degree on geometric layers: digits gained with each degree.

    Parameters
    ----------
    order : digits of the start gained with each degree; NaN if ring edges reduce them
    """
    start = Theory(order, 1e-13, ANALYTIC, ROUNDOFF)
    return {FIRST_DEPTH: start, OTHERS: Theory(floor=1e-13, reason=LAYERS)}


def for_steps(reason: str) -> Theories:
    """Return the theory of Euler's methods.

    Parameters
    ----------
    reason : why histories have no order; empty if they have
    """
    later = Theory(reason=reason) if reason else Theory(1.0, 0.0, STEP)
    return {LATER: later} | without_order(NO_TIME)
