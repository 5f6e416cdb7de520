"""All factors and floors of error estimates, and the test that justifies each of them.

An error estimate is the difference to the solution of a coarser discretisation times a factor, and
at least a floor. `TABLE` lists all of them; `studies/crosscheck/verdict/README.md` prints the
table.
"""

from typing import NamedTuple


class ErrorFactor(NamedTuple):
    """A factor or a floor of an error estimate.

    Parameters
    ----------
    value : the number
    multiplies : what it multiplies
    shown_by : the test that shows that the number is large enough
    """

    value: float
    multiplies: str
    shown_by: str


ESTIMATES = "tests/physics/test_estimates.py::test_random_scenes"
PUNCHES = "tests/physics/test_random_punches.py::test_at_most_one_of_12_punches_is_undecided"

TABLE = {
    "flat punch": ErrorFactor(
        1.5,
        "difference of a flat punch to a coarser mesh, except on triangles and on halved elements",
        ESTIMATES,
    ),
    "flat punch on triangles": ErrorFactor(
        1.0,
        "difference of a flat punch to a degree less on the same triangles, if their sizes and "
        "their degree are the defaults: most of it is the error of that degree",
        ESTIMATES,
    ),
    "flat punch on larger triangles": ErrorFactor(
        8.0,
        "for triangles that the scene sets: difference of a flat punch to a degree less on larger "
        "triangles, or of degree 2 to degree 3 on the same triangles",
        ESTIMATES,
    ),
    "flat punch on halved elements": ErrorFactor(
        3.0,
        "difference of a flat punch to low-degree elements that are twice as large",
        "tests/physics/test_low_degrees.py::test_estimates_bound_the_errors_of_low_degrees",
    ),
    "wear along the radius": ErrorFactor(
        1.5,
        "the factor and the floor of a flat punch if k varies along the radius, because kinks of k "
        "get fewer layers",
        "tests/physics/test_graded.py::test_methods_agree_and_estimates_bound_their_errors",
    ),
    "moving contact": ErrorFactor(
        2.5,
        "difference to coarser cells, if edges of the contact move",
        PUNCHES,
    ),
    "moving contact, energies and volumes": ErrorFactor(
        1.5,
        "the same for energies and volumes under one force, which converge at second order in the "
        "size of cells, so that the difference is three times the error",
        PUNCHES,
    ),
    "steps of the coarser march": ErrorFactor(
        2.0,
        "length of a time step in the coarser march, whether the tolerance limits it or the length "
        "of the step before it",
        "tests/physics/test_moving_edges.py::test_ring_forces_at_the_last_time",
    ),
    "depth of a step": ErrorFactor(
        0.025,
        "rtol, or 1e-3 if that is smaller: error of the worn depth, over the indentation, that a "
        "time step may add. An error that is larger by a factor multiplies all estimates by it",
        "tests/physics/test_moving_edges.py::test_estimates_include_steps_that_are_too_long",
    ),
    "slope of a step": ErrorFactor(
        0.6,
        "the same for the slope of the worn face, over that slope, where layers are thin",
        "tests/physics/test_moving_edges.py::test_estimates_include_steps_that_are_too_long",
    ),
    "inside of the half-space": ErrorFactor(
        1.5,
        "difference of stresses and displacements inside to a solution with one degree and one "
        "pole less",
        "tests/physics/test_stresses.py::test_stresses_under_the_flat_punch",
    ),
    "nearby times": ErrorFactor(
        2.5,
        "a time t: the largest difference at times from t / value to t * value counts, because "
        "differences cross zero",
        "tests/physics/test_trust.py::test_estimates_at_a_single_time_bound_the_errors",
    ),
    "part of the field": ErrorFactor(
        0.1,
        "error of the displacement field: least error of displacements at a single place",
        ESTIMATES,
    ),
    "floor": ErrorFactor(
        0.01,
        "rtol: least error of a flat punch, because two solutions may agree by chance",
        ESTIMATES,
    ),
    "floor of energies": ErrorFactor(
        1e-5,
        "rtol: least error of energies of a flat punch, which converge twice as fast",
        ESTIMATES,
    ),
    "floor of moving contact": ErrorFactor(
        0.02,
        "rtol: least error if edges of the contact move",
        PUNCHES,
    ),
    "stiffness at the rim": ErrorFactor(
        0.2,
        "width of the element at the rim: error of the indentation of a flat start, which is part "
        "of the least error of times of running-in",
        "tests/physics/test_estimates_at_extremes.py::"
        "test_estimates_of_running_in_times_include_a_coarse_rim",
    ),
    "pressure at the rim": ErrorFactor(
        3.0,
        "width of the element at the rim: least error of pressures of a flat start",
        "tests/physics/test_trust.py::test_start_pressures_are_those_of_the_closed_form",
    ),
    "worn depth at the rim": ErrorFactor(
        0.65,
        "root of (worn length at the rim / width of the face), while that length is below the "
        "width of the element at the rim: least error of worn profiles and displacements (2 / pi "
        "for a solid punch)",
        "tests/physics/test_flat_punch.py::test_worn_depths_within_the_element_at_the_rim",
    ),
    "roundoff of slopes": ErrorFactor(
        4e-13,
        "1 / (1 - 2 nu) / root of (worn length on the slower side of an edge / ring width): least "
        "error of RMS slopes by finite elements, whose stiffness against a change of volume "
        "multiplies roundoff",
        "tests/physics/test_flat_punch.py::test_slopes_of_thin_layers_near_incompressibility",
    ),
    "pressure at free edges": ErrorFactor(
        0.3,
        "pressure beside a free edge, on the cell in which that edge lies: least error of "
        "pressures. A line misses 0.18 of it if the pressure vanishes as a root, and 0.29 if it "
        "jumps in the middle of the cell",
        "tests/physics/test_moving_edges.py::test_pressures_of_a_toroid",
    ),
    "fitted start": ErrorFactor(
        1e-12,
        "1: least error of a start that is fitted to the edges of the contact, roundoff",
        PUNCHES,
    ),
    "edge of a fitted start": ErrorFactor(
        5e-8,
        "1: least error of the radius of the first contact, a few times the tolerance of the "
        "search for its edges, and of the slope of the unworn face, a difference of heights",
        "tests/physics/test_profiles.py::test_starts_against_closed_forms",
    ),
    "kinks inside elements": ErrorFactor(
        2.0,
        "difference of the face from what the elements of a fitted start resolve, over the "
        "indentation, if kinks are inside its elements: least error of the start",
        "tests/physics/test_kinks.py::test_starts_of_tables",
    ),
    "uniform grid": ErrorFactor(
        2.5,
        "difference to the grid with half as many springs and half as many steps: slopes and "
        "jumps converge with order 1/2, so that the error is 1 / (sqrt(2) - 1) times it",
        "tests/physics/test_low_degrees.py::test_errors_are_below_their_estimates",
    ),
    "uniform grid, slope": ErrorFactor(
        4.0,
        "the same for slopes, whose squares have a logarithm at each ring edge",
        "tests/physics/test_low_degrees.py::test_errors_are_below_their_estimates",
    ),
    "incompressible layers": ErrorFactor(
        5e-8,
        "1: least error of a flat punch on layers with a Poisson's ratio above 0.49999, to which "
        "two solutions are extrapolated",
        "tests/physics/test_thin_layers.py::test_incompressible_layers",
    ),
    "incompressible inside": ErrorFactor(
        3e-6,
        "1: the same for displacements and stresses inside",
        "tests/physics/test_thin_layers.py::test_fields_inside_incompressible_layers",
    ),
    "lost bend": ErrorFactor(
        0.25,
        "bend of a field within a cell: least error of worn profiles and displacements",
        "tests/physics/test_worn_faces.py::test_a_run_in_face_has_the_steady_slope",
    ),
}


def error_factor(name: str) -> float:
    """Return the value of a factor or floor, by its name in `TABLE`."""
    return TABLE[name].value
