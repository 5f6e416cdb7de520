"""Differences of two reports in the fields along the radius, relative to the norms of the fields.

A report holds quantities by name, in the scene's units, with its coordinates `time` and `radius`:
what a method reports (`Result.reported`), or what was read from `results.nc`.
"""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from ...meshes.radial import Array, Indices
from ..problem.problem import Problem
from ..problem.quantities import error_name

OVER_TIME = ("pressure", "profile", "displacement")
IN_STEADY_STATE = ("steady_pressure", "steady_profile")
# part of the largest norm below which there is no more than the roundoff of a field
ROUNDOFF = 1e-9


@dataclass(frozen=True, eq=False)
class FieldDifference:
    """By how much two reports differ in one field.

    Parameters
    ----------
    quantity : its name
    times : (T,) times that both give, in the scene's units; infinite for the steady state
    radii : (R,) radii at which both give it, in the scene's units
    relative : (T, R) absolute differences over the norm of the field; NaN where one of the reports
        has no finite value. Those of pressures are over the root mean square; while nothing has
        worn, both have the weight of the norm, the root of ``1 - r^2/a^2`` (`Face.edge_weights`)
    norms : (T,) norms of the difference over the norm of the field
    first_error, second_error : (T,) errors that the reference and the other state of the field in
        this norm; NaN where they state none
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
        """Indices of the time and of the radius where the difference is largest."""
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
    contact_edges : (T, E) radii of the edges of the contact at the common times, by the reference,
        in the scene's units; E is 0 if the contact is all of the face
    interpolated : whether the other is interpolated linearly to the radii of the reference
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
    """Return the differences of another report from a reference, in all fields that both give.

    Parameters
    ----------
    problem : that of the reference
    names : of the reference and of the other
    reference, other : reports, at times and radii of their own

    Notes
    -----
    Norms are those of `studies/problem/quantities.py`, with integrals over the face by trapezoids
    between the radii of the report.
    """
    same = np.isclose(reference["time"][:, None], other["time"], rtol=1e-9, atol=0)
    rows, their_rows = np.nonzero(same)
    radii = reference["radius"]
    interpolated = radii.shape != other["radius"].shape or not np.allclose(radii, other["radius"])
    fields: list[FieldDifference] = []
    for names_of_fields in (OVER_TIME, IN_STEADY_STATE):
        for name in names_of_fields if not fields else ():
            if name not in reference or name not in other:
                continue
            values, their_values = (np.atleast_2d(report[name]) for report in (reference, other))
            if name in OVER_TIME:
                values, their_values = values[rows], their_values[their_rows]
            if interpolated:
                their_values = _interpolated(radii, other["radius"], their_values)
            stated = _stated(reference, name, rows), _stated(other, name, their_rows)
            fields += _difference(problem, name, reference, rows, values, their_values, stated)
    edges = reference.get("contact_edge", np.empty((len(reference["time"]), 0)))[rows]
    return FieldComparison(*names, tuple(fields), edges, interpolated)


def _difference(
    problem: Problem,
    name: str,
    reference: Mapping[str, Array],
    rows: Indices,
    values: Array,
    their_values: Array,
    stated: tuple[Array, Array],
) -> list[FieldDifference]:
    """Return the difference in one field: none if no finite values meet, or all are zero.

    Parameters
    ----------
    problem, name, reference : what is compared
    rows : (T,) numbers of the times of the reference that the other gives, too
    values, their_values : (T, R) at these times, or (1, R) of the steady state
    stated : errors (T,) or (1,) that the reference and the other state
    """
    over_time, units = name in OVER_TIME, problem.units
    with np.errstate(invalid="ignore"):
        # pressures at the rim of a flat punch are infinite by both
        gaps = np.abs(their_values - values)
    radii = reference["radius"] / units.length
    if "pressure" in name:
        # they jump at ring edges, and have no value there
        jumps = np.isclose(radii[:, None], problem.merged.ring_edges[1:-1], 0, 1e-9)
        gaps[:, jumps.any(axis=1)] = np.nan
    compared = np.isfinite(gaps)
    shown, at = compared.any(axis=1), compared.any(axis=0)
    if not shown.any():
        return []
    part = np.ix_(shown, at)
    gaps, compared, values, radii = gaps[part], compared[part], values[part], radii[at]
    times = reference["time"][rows][shown] if over_time else np.array([np.inf])
    face = problem.sampled_face(radii)
    if "pressure" in name:
        if over_time:
            unworn = problem.loading.at(times / units.time).distance == 0
            blunting = np.where(unworn[:, None], np.sqrt(face.edge_weights), 1.0)
            gaps, values = gaps * blunting, np.where(compared, values, 0.0) * blunting
        weights = face.weights * compared
        scale = _root_mean_square(values, weights)
    elif over_time:
        scale = _depth(problem, reference)[rows][shown]
    else:
        scale = np.atleast_1d(reference.get("steady_displacement_max", units.displacement))
    if not scale.max() > 0:
        return []
    # where nothing presses, no more than roundoff is left
    relative = gaps / np.maximum(scale, ROUNDOFF * scale.max())[:, None]
    if "pressure" in name:
        norms = _root_mean_square(relative, weights)
    else:
        norms = np.nanmax(relative, axis=1)
    errors = (error[shown] for error in stated)
    return [FieldDifference(name, times, reference["radius"][at], relative, norms, *errors)]


def _depth(problem: Problem, reference: Mapping[str, Array]) -> Array:
    """Return what heights are relative to at each time: the indentation beyond the first touch.

    It is the greatest so far, because it comes back under a force that falls. If the report has no
    indentation, it is F / (a E*).
    """
    units = problem.units
    if "indentation" not in reference or np.isnan(reference["indentation"]).all():
        return np.full(len(reference["time"]), units.displacement)
    beyond = reference["indentation"] - problem.profile.standoff * units.displacement
    return np.fmax.accumulate(beyond)


def _root_mean_square(values: Array, weights: Array) -> Array:
    """Return the root mean square (T,) of values (T, R) by weights (T, R), zero where none is."""
    squares = np.where(weights > 0, values, 0.0) ** 2
    return np.asarray(np.sqrt((weights * squares).sum(axis=1) / weights.sum(axis=1)))


def _interpolated(radii: Array, their_radii: Array, their_values: Array) -> Array:
    """Return values (T, R) at other radii, linear in between, NaN beyond the last of theirs."""
    return np.array(
        [np.interp(radii, their_radii, row, np.nan, np.nan) for row in their_values]
    ).reshape(len(their_values), len(radii))


def _stated(report: Mapping[str, Array], name: str, rows: Indices) -> Array:
    """Return the errors that a report states of a field at some of its times; NaN if none."""
    if name not in OVER_TIME:
        return np.atleast_1d(report.get(error_name(name), np.nan))
    return report.get(error_name(name), np.full(len(report["time"]), np.nan))[rows]
