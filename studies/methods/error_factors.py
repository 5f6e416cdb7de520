"""All factors and floors of error estimates: what each multiplies, and the test that shows it.

An error estimate is the difference to a coarser discretisation times a factor, and not less than a
floor. `TABLE` lists them; `studies/crosscheck/README.md` shows it.
"""

from typing import NamedTuple


class ErrorFactor(NamedTuple):
    """A factor or a floor of an error estimate.

    Parameters
    ----------
    value : the number
    multiplies : what it multiplies
    shown_by : the test that shows that it is enough
    """

    value: float
    multiplies: str
    shown_by: str


ESTIMATES = "tests/physics/test_estimates.py::test_random_scenes"
PUNCHES = "tests/physics/test_random_punches.py::test_of_many_random_punches_few_are_undecided"

TABLE = {
    "flat punch": ErrorFactor(
        1.5,
        "the difference of a flat punch to a coarser mesh, by all but triangles",
        ESTIMATES,
    ),
    "flat punch on triangles": ErrorFactor(
        8.0,
        "the difference of a flat punch to larger triangles, or of degree 2 to degree 3",
        ESTIMATES,
    ),
    "flat punch on halved elements": ErrorFactor(
        3.0,
        "the difference of a flat punch to elements of a low degree that are twice as large",
        "tests/physics/test_low_degrees.py::test_no_true_error_is_above_the_stated_one",
    ),
    "wear along the radius": ErrorFactor(
        1.5,
        "both of these where k varies along the radius: its kinks ask for fewer layers",
        "tests/physics/test_graded.py::test_methods_agree_and_errors_stated_are_above_the_true_ones",
    ),
    "moving contact": ErrorFactor(
        2.5,
        "the difference to coarser cells where edges of the contact move",
        PUNCHES,
    ),
    "moving contact, energies and volumes": ErrorFactor(
        1.5,
        "that of energies and volumes under one load, which are of second order in the cells",
        PUNCHES,
    ),
    "decaying force": ErrorFactor(
        2.0,
        "that of forces at a fixed indentation, whose errors stay while they decay",
        "tests/physics/test_fixed_indentation.py::test_the_last_of_a_force_is_not_promised",
    ),
    "time to full contact": ErrorFactor(
        2.0,
        "that of the time from which all of the face carries, which is known to a step",
        "tests/physics/test_random_scenes.py::test_no_number_is_silently_beyond_what_was_asked_for",
    ),
    "steps of the coarser march": ErrorFactor(
        4.0,
        "the error that a step in time may add, so that the coarser march has larger steps, too",
        PUNCHES,
    ),
    "inside of the half-space": ErrorFactor(
        1.5,
        "the difference of stresses and displacements inside to a degree and a pole less",
        "tests/physics/test_stresses.py::test_stresses_under_the_flat_punch",
    ),
    "nearby times": ErrorFactor(
        2.5,
        "a time: the greatest difference from it down, and up, by this factor counts, because "
        "differences cross zero",
        "tests/physics/test_trust.py::test_errors_of_a_time_asked_for_alone",
    ),
    "part of the field": ErrorFactor(
        0.1,
        "the error of the displacement: values at one place are not known better than to this part",
        ESTIMATES,
    ),
    "floor": ErrorFactor(
        0.01,
        "rtol: nothing is known better, because two computations may agree by chance",
        ESTIMATES,
    ),
    "floor of energies": ErrorFactor(
        1e-5,
        "rtol: energies, which converge twice as fast, are not known better",
        ESTIMATES,
    ),
    "floor of moving contact": ErrorFactor(
        0.02,
        "rtol: nothing is known better where edges of the contact move",
        PUNCHES,
    ),
    "stiffness at the rim": ErrorFactor(
        0.2,
        "the width of the element at the rim: the indentation of a flat start is not known better",
        "tests/physics/test_flat_punch.py::test_indentation",
    ),
    "pressure at the rim": ErrorFactor(
        3.0,
        "the width of the element at the rim: pressures of a flat start are not known better",
        "tests/physics/test_trust.py::test_start_pressures_of_random_scenes",
    ),
    "lost bend": ErrorFactor(
        0.25,
        "the bend of a field within a cell: worn faces and displacements are not known better",
        "tests/physics/test_worn_faces.py::test_a_run_in_face_has_the_steady_slope",
    ),
}


def error_factor(name: str) -> float:
    """Return the value of a factor or floor by its name in `TABLE`."""
    return TABLE[name].value


def as_markdown() -> str:
    """Return the table in Markdown, as the documentation shows it."""
    lines = ["| name | value | multiplies | shown by |", "| --- | --- | --- | --- |"]
    for name, factor in TABLE.items():
        test = factor.shown_by.removeprefix("tests/")
        lines.append(f"| {name} | {factor.value:g} | {factor.multiplies} | `{test}` |")
    return "\n".join(lines)
