"""Differences of two reports in the fields along the radius, relative to the norms of the fields.

A report maps names to quantities in the scene's units, and has the coordinates `time` and `radius`.
It is either `Result.reported`, or read from `results.nc`.
"""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from .....meshes.radial import Array, Indices
from ...problem.problem import Problem
from ...problem.quantities import QUANTITIES, error_name

OVER_TIME = ("pressure", "profile", "displacement")
IN_STEADY_STATE = ("steady_pressure", "steady_profile")
# Lower limit of the norm of a field, over its largest norm over time: a smaller norm is roundoff.
ROUNDOFF = 1e-9
# Relative difference up to which two times count as the same.
SAME_TIME = 1e-9


@dataclass(frozen=True, eq=False)
class FieldDifference:
    """Difference of two reports in one field.

    Parameters
    ----------
    quantity : name of the field
    times : (T,) times that both reports have, in the scene's units; infinite for the steady state
    radii : (R,) radii at which both have a value, in the scene's units
    relative : (T, R) absolute differences over the norm of the field; NaN if one of the reports has
        no finite value. Differences of pressures are relative to the root mean square; while
        nothing has worn, both are multiplied by the weight of the norm, the root of ``1 - r^2/a^2``
        (`Face.edge_weights`)
    norms : (T,) norms of the difference over the norm of the field
    first_error, second_error : (T,) error estimates for the field in this norm, of the reference
        and of the other report; NaN if there is none
    """

    quantity: str
    times: Array
    radii: Array
    relative: Array
    norms: Array
    first_error: Array
    second_error: Array

    @property
    def largest(self) -> tuple[int, int]:
        """Indices of the time and of the radius at which the difference is largest."""
        place = np.unravel_index(np.nanargmax(self.relative), self.relative.shape)
        return int(place[0]), int(place[1])


@dataclass(frozen=True, eq=False)
class FieldComparison:
    """All differences of two reports in fields along the radius; empty if they share no field.

    Parameters
    ----------
    reference, other : names of the reports; the differences are the other minus the reference
    fields : pressure, profile and displacement over time; if the reports share none of these, the
        steady pressure and the limiting profile
    contact_edges : (T, E) radii of the edges of the contact at the common times, from the
        reference, in the scene's units; E is 0 in full contact
    interpolated : whether the other report is interpolated linearly to the radii of the reference
    """

    reference: str
    other: str
    fields: tuple[FieldDifference, ...]
    contact_edges: Array
    interpolated: bool


def compare_fields(
    problem: Problem,
    names: tuple[str, str],
    reference: Mapping[str, Array],
    other: Mapping[str, Array],
) -> FieldComparison:
    """Return the differences of another report from a reference, in all fields that both have.

    Parameters
    ----------
    problem : the problem of the reference
    names : names of the reference and of the other report
    reference, other : the reports; their times and radii may differ

    Notes
    -----
    Norms are those of `studies/crosscheck/problem/quantities.py`, with integrals over the face by
    the trapezoidal rule between the radii of the report.
    """
    rows, other_rows = _common_times(reference["time"], other["time"])
    radii = reference["radius"]
    interpolated = radii.shape != other["radius"].shape or not np.allclose(radii, other["radius"])
    fields: list[FieldDifference] = []
    for names_of_fields in (OVER_TIME, IN_STEADY_STATE):
        for name in names_of_fields if not fields else ():
            if name not in reference or name not in other:
                continue
            values, other_values = (np.atleast_2d(report[name]) for report in (reference, other))
            if name in OVER_TIME:
                values, other_values = values[rows], other_values[other_rows]
            if interpolated:
                other_values = _interpolated(radii, other["radius"], other_values)
            estimates = (
                _error_estimates(reference, name, rows),
                _error_estimates(other, name, other_rows),
            )
            fields += _difference(problem, name, reference, rows, values, other_values, estimates)
    edges: Array = np.empty((len(rows), 0))
    if "contact_edge" in reference and not problem.full_contact:
        edges = reference["contact_edge"][rows]
    return FieldComparison(*names, tuple(fields), edges, interpolated)


def _common_times(times: Array, other_times: Array) -> tuple[Indices, Indices]:
    """Return the indices of the times that two increasing sequences have in common, in both."""
    nearest = np.searchsorted(other_times, times * (1 - SAME_TIME))
    rows = np.flatnonzero(nearest < len(other_times))
    rows = rows[other_times[nearest[rows]] <= times[rows] * (1 + SAME_TIME)]
    return rows, nearest[rows]


def _difference(
    problem: Problem,
    name: str,
    reference: Mapping[str, Array],
    rows: Indices,
    values: Array,
    other_values: Array,
    estimates: tuple[Array, Array],
) -> list[FieldDifference]:
    """Return the difference in one field; empty if it has no common finite values, or all are zero.

    Parameters
    ----------
    problem, name, reference : the problem, the name of the field and the reference report
    rows : (T,) indices of the times of the reference that the other report has, too
    values, other_values : (T, R) at these times, or (1, R) for the steady state
    estimates : error estimates (T,) or (1,) of the reference and of the other report
    """
    over_time, units, quantity = name in OVER_TIME, problem.units, QUANTITIES[name]
    with np.errstate(invalid="ignore"):
        # both pressures at the rim of a flat punch are infinite
        compared = np.isfinite(other_values - values)
    radii = reference["radius"] / units.length
    if "pressure" in name:
        # pressures jump at ring edges, and have no value there
        jumps = np.isclose(radii[:, None], problem.merged.from_axis[1:-1], 0, 1e-9)
        compared[:, jumps.any(axis=1)] = False
    times_compared, radii_compared = compared.any(axis=1), compared.any(axis=0)
    if not times_compared.any():
        return []
    block = np.ix_(times_compared, radii_compared)
    compared = compared[block]
    ours, theirs = (np.where(compared, each[block], 0.0) for each in (values, other_values))
    times = reference["time"][rows][times_compared] if over_time else np.array([np.inf])
    face = problem.sampled_face(radii[radii_compared])
    greatest = reference.get("steady_displacement_max", np.asarray(units.displacement))
    scales = {"steady_displacement_max": greatest}
    if over_time:
        scales = {
            "pressed": problem.loading.at(times / units.time).distance == 0,
            "depth": _depth(problem, reference)[rows][times_compared],
            "even_wear": _least_worn_depth(problem, reference)[rows][times_compared],
        }
    else:
        ours, theirs = ours[0], theirs[0]
    results = scales | {name: ours, "time": times}
    gaps = np.atleast_2d(quantity.norm.gaps(name, {name: theirs}, results, face))
    size = np.atleast_2d(quantity.norm.size(name, results, face))
    if not size.max() > 0:
        return []
    # if nothing presses, only roundoff is left
    larger = np.maximum(size, ROUNDOFF * size.max())
    norms = quantity.difference({name: theirs}, results, face) * (size / larger)[:, 0]
    if "pressure" in name:
        # the root mean square is that over the radii at which both have a value
        share = (face.weights * compared).sum(axis=1, keepdims=True) / face.weights.sum()
        larger = larger / np.sqrt(share)
    relative = np.where(compared, gaps / larger, np.nan)
    errors = (error[times_compared] for error in estimates)
    return [
        FieldDifference(name, times, reference["radius"][radii_compared], relative, norms, *errors)
    ]


def _depth(problem: Problem, reference: Mapping[str, Array]) -> Array:
    """Return the height (T,) to which differences of heights are relative.

    It is the largest indentation so far beyond the first touch, less the depth by which the whole
    face has worn; "so far" because the indentation decreases under a force that falls. If the
    report has no indentation, it is F / (a E*).
    """
    units = problem.units
    if "indentation" not in reference or np.isnan(reference["indentation"]).all():
        return np.full(len(reference["time"]), units.displacement)
    beyond = reference["indentation"] - problem.profile.standoff * units.displacement
    return np.fmax.accumulate(beyond - _least_worn_depth(problem, reference))


def _least_worn_depth(problem: Problem, reference: Mapping[str, Array]) -> Array:
    """Return the depth (T,) by which the whole face has worn; 0 if there is no profile."""
    if "profile" not in reference:
        return np.zeros(len(reference["time"]))
    units, radii = problem.units, reference["radius"] / problem.units.length
    unworn = (problem.profile(radii) + problem.profile.standoff) * units.displacement
    worn = reference["profile"] - unworn
    on_face = radii >= problem.inner_radius
    return np.nan_to_num(np.fmin.reduce(worn[:, on_face], axis=1, initial=np.inf), posinf=0.0)


def _interpolated(radii: Array, other_radii: Array, other_values: Array) -> Array:
    """Return values (T, R) at `radii` by linear interpolation; NaN outside `other_radii`."""
    return np.array(
        [np.interp(radii, other_radii, row, np.nan, np.nan) for row in other_values]
    ).reshape(len(other_values), len(radii))


def _error_estimates(report: Mapping[str, Array], name: str, rows: Indices) -> Array:
    """Return the error estimates of a report for a field at some of its times; NaN if none."""
    if name not in OVER_TIME:
        return np.atleast_1d(report.get(error_name(name), np.nan))
    return report.get(error_name(name), np.full(len(report["time"]), np.nan))[rows]
