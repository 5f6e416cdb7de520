"""Check numbers of the answer against both ends of the running-in and other reported numbers."""

import numpy as np

from .anchor import Row, Rows
from .reported import DOUBT, EXACT, Reported

# relative change of a time over which the rate of what is left is taken
NEARBY = 1e-3
# a number below which nothing has worn
LEAST = 1e-300
# sums over the face of shaped profiles, whose edges lie between its radii, may be off by this part
BETWEEN_RADII = 1e-3


def check_times_of_running_in(report: Reported) -> Rows:
    """Compare what is left at the reported times with the part that their names tell.

    The whole change is known from both of its ends, in closed form if wear is constant on rings.
    The method's own change differs from it by the errors that the method states of both ends.
    """
    wear, problem = report.solution.wear, report.problem
    if wear is None or not report.full:
        return
    for name, part in problem.load_regime.remaining_fractions.items():
        if not report.given(name):
            # the verdict is undecided then
            continue
        time = float(report.take(name))
        if report.fixed:
            whole, doubt = report.flat.indentation, 0.0
        elif report.graded:
            whole, doubt = wear.total_change, 0.0
        else:
            moved = report.steady_displacement(report.face.radii)[None]
            steady, doubts = report.integrate(moved, report.steady_wear_rate / report.wear)
            start = report.flat.indentation
            whole, doubt = float(steady[0]) - start, float(doubts[0])
            doubt += report.stated("indentation_start") * start
            doubt += report.stated("indentation_steady") * float(steady[0])
        near = wear.modes.remaining_change(time * np.array([1 - NEARBY, 1.0, 1 + NEARBY]))
        decay = abs(np.log(near[2] / near[0])) / (2 * NEARBY)
        stated = float(report.tolerance(name))
        tolerance = stated * decay + (doubt + 1e-12) / whole
        yield Row(f"{name}: what is left then", near[1] / whole, part, tolerance)


def check_repeated_numbers(report: Reported) -> Rows:
    """Compare numbers of the answer with the series of which they are the first or the last."""
    problem = report.problem
    starts = len(report.reading.times) > 0 and report.reading.times[0] == 0
    if report.full and report.given("force_start"):
        # F = 2 a E* d of a flat punch is the unit of force
        tolerance = report.tolerance("force_start")
        yield Row("force_start in closed form", report.take("force_start"), 1.0, tolerance)
    for answer, name, row in (
        ("force_start", "normal_force", 0),
        ("force_end", "normal_force", -1),
        ("contact_radius_start", "contact_radius", 0),
        ("worn_volume", "ring_worn_volume", -1),
        ("indentation_start", "indentation", 0),
    ):
        if answer == "indentation_start" and (report.full or problem.loading.varies):
            # of a flat punch in closed form, also where no force presses at the time 0
            continue
        if report.given(answer) and name in report.table and (starts or row):
            series = np.asarray(report.table[name])[row]
            value = np.asarray(report.table[answer])
            scale = max(float(np.nanmax(np.abs(np.asarray(report.table[name])))), LEAST)
            yield Row(f"{answer} of the answer", value, series, EXACT, scale)


def check_worn_volumes_of_profile(report: Reported) -> Rows:
    """Compare worn volumes of the rings with the profile at the last of the times."""
    problem, face = report.problem, report.face
    unworn = problem.profile(face.radii) + problem.profile.standoff
    # of a flat face that stands off its plane both have the standoff
    parts = face.areas * (report.solution.checked["profile"][-1] - unworn)
    volumes, doubt = face.ring_sums(parts), DOUBT * face.integral_error(parts[None])[0]
    whole = volumes.sum()
    if not whole > 0:
        return
    stated = report.tolerance("worn_volume")
    # the profile is promised relative to the indentation, over the whole face
    depth = float(report.take("indentation")[-1]) if len(report.times) else 0.0
    stated = stated + float(report.errors("profile")[0][-1]) * report.area * depth / whole
    if not report.full:
        doubt += BETWEEN_RADII * np.abs(parts).sum()
    tolerance = stated + doubt / whole
    value = report.take("worn_volume")
    yield Row("worn volumes of the answer, of the profile", value, volumes, tolerance, whole)
