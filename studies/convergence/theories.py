"""What theory expects of each measure, in a sentence with its source, or why it expects nothing.

The sources:

- Babuška & Suri, The p and h-p versions of the finite element method, SIAM Review 36 (1994).
- Grisvard, Elliptic Problems in Nonsmooth Domains (1985): singular exponents where boundary
  conditions change.
- Gui & Babuška, The h, p and h-p versions of the finite element method in one dimension, Numer.
  Math. 49 (1986).
- Hairer, Nørsett & Wanner, Solving Ordinary Differential Equations I (1993).
- Sauter & Schwab, Boundary Element Methods (2011), chapter 4: Galerkin's method for operators of
  order -1.
- Strang & Fix, An Analysis of the Finite Element Method (1973), chapter 8: singular functions.
"""

from ..study.levels import Theory

ROOT_AT_RIM = (
    "The displacement behaves as the root of the distance from the rim (Grisvard 1985), of which "
    "elements of one size h miss h^(1/2) in the energy norm, and d0 is an energy, which errs by "
    "the square (Strang & Fix 1973)."
)
ROOT_OF_PRESSURE = (
    "The pressure is infinite as the inverse root of the distance from the rim; with a weight that "
    "vanishes there, the element at the rim misses a part of size h^(1/2) of it."
)
ENERGY_OF_ELEMENTS = (
    "On meshes graded to every edge, displacements of degree k err by h^k in the energy norm "
    "(Babuška & Suri 1994), and {what} by the square."
)
ENERGY_OF_PRESSURES = (
    "Pressures of degree q err by h^(q+3/2) in the energy norm, of order -1/2 (Sauter & Schwab "
    "2011), and d0 by the square."
)
HISTORY_OF_PRESSURES = (
    "Wear weighs pressures by their mean square, in which degree q errs by h^(q+1) (Sauter & "
    "Schwab 2011); eigenvalues and histories err by the square."
)
GRADIENT = (
    "A gradient loses an order of h to the displacement, and its mean square is of order 2q where "
    "histories are of order 2q+2 (Sauter & Schwab 2011, by an inverse inequality)."
)
MEAN_SQUARE_OF_PRESSURES = (
    "Pressures of degree q err by h^(q+1) in the mean square on meshes graded to every edge "
    "(Sauter & Schwab 2011)."
)
ANALYTIC = (
    "On geometric layers the error of an energy falls by a factor of 9 with each degree: the "
    "function is analytic in Bernstein's ellipse up to the singular point, one layer away (Gui & "
    "Babuška 1986)."
)
LAYERS = (
    "No order is expected: layers further in have lower degrees, and become smaller with each "
    "degree, so that several errors fall together."
)
STEP = "The implicit method of Euler is of order one in the step (Hairer, Nørsett & Wanner 1993)."

LOGARITHM = (
    "No power is known: beside ring edges slopes behave as logarithms, so that powers of h have "
    "logarithms as factors, and layers that wear has blunted are resolved late."
)
OTHER_NORM = (
    "No theory is known to us: the method is best in the energy norm, and this norm is another one."
)
MOVING_EDGES = (
    "No theory is known to us: edges of the contact lie anywhere within a cell, so that errors "
    "scatter from level to level."
)
OWN_MESH = "No order is expected: how your meshes are graded is not known."
OWN_ELEMENT = "No order is expected: which polynomials your element holds is not known."
OWN_QUANTITY = "No order is expected of a quantity of your own."
NO_TIME = "No order is expected: it does not depend on time."
LONG_STEPS = "No order is expected: some steps are longer than a quarter of the first of the times."
STEP_WITH_CONTACT = (
    "No theory is known to us where edges of the contact move: the rates of wear jump there."
)

RIM_ELEMENT = "the innermost elements at the rim and at ring edges, which stay coarse"
ROUNDOFF = "roundoff"
REFERENCE = "the reference, which is known to no more digits"

ENERGY_NAMES = {"d(t)": "d(t)", "relaxation time": "relaxation times"}
"""Measures that are energies, or eigenvalues, and what sentences call them."""
TIMELESS = ("d0", "pressure at start", "relaxation time", "steady slope", "steady profile")
"""Measures that steps in time do not change."""


def of_uniform(measure: str) -> Theory:
    """Return what elements or cells of one size lead to, whatever their degree."""
    if measure == "d0":
        return Theory(1.0, 0.0, ROOT_AT_RIM)
    if measure == "pressure at start":
        return Theory(0.5, 0.0, ROOT_OF_PRESSURE)
    return Theory(reason=LOGARITHM)


def of_graded_elements(measure: str, degree: int, floors: dict[str, float]) -> Theory:
    """Return what finite elements on meshes graded to every edge lead to.

    Parameters
    ----------
    measure : by its name
    degree : of the displacement
    floors : relative errors that levels do not go below, by measure
    """
    floor, cause = floors.get(measure, 0.0), RIM_ELEMENT if measure in floors else ""
    if measure == "d0" or measure in ENERGY_NAMES:
        sentence = ENERGY_OF_ELEMENTS.format(what=ENERGY_NAMES.get(measure, "d0"))
        return Theory(2.0 * degree, floor, sentence, cause)
    return Theory(reason=OTHER_NORM)


def of_graded_pressures(measure: str, degree: int, floors: dict[str, float]) -> Theory:
    """Return what MDR and boundary elements on graded meshes lead to, by the pressure's degree.

    Even degrees come up to the order of d0, odd ones fall to that of the history: plane waves
    ``exp(ikx)`` at kh = 0.7 give the orders 5.34, 6.60, 9.21 and 10.77 of d0 (Fourier analysis).
    """
    floor, cause = floors.get(measure, 0.0), RIM_ELEMENT if measure in floors else ""
    if measure == "d0":
        return Theory(2.0 * degree + 3, floor, ENERGY_OF_PRESSURES, ROUNDOFF)
    if measure in ENERGY_NAMES:
        return Theory(2.0 * degree + 2, floor, HISTORY_OF_PRESSURES, cause)
    if measure == "pressure":
        return Theory(degree + 1.0, floor, MEAN_SQUARE_OF_PRESSURES, cause)
    return Theory(reason=OTHER_NORM)


def of_steps_in_moving_contact(_: str) -> Theory:
    """Return what the implicit march leads to where contact opens, closes and spreads."""
    return Theory(reason=STEP_WITH_CONTACT)


def of_steps(short: bool, measure: str) -> Theory:
    """Return what the implicit march leads to in full contact.

    Parameters
    ----------
    short : whether all steps are shorter than the first of the times
    measure : by its name
    """
    if measure in TIMELESS:
        return Theory(reason=NO_TIME)
    if not short:
        return Theory(reason=LONG_STEPS)
    return Theory(1.0, 0.0, STEP)


def of_cells(_: str) -> Theory:
    """Return what cells lead to on which contact opens, closes and spreads."""
    return Theory(reason=MOVING_EDGES)
