"""Any method that yields a compliance, on a punch whose contact opens, closes and spreads.

Presses of the unworn face are fitted to the edges of the contact, histories are marched on linear
pressures over cells all over the face, and the steady state, in which all of the face carries, is
that of the flat punch. What results are worth is seen from half as many cells and four times the
error of a step, and at the start by a lower degree.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cache, lru_cache
from typing import Any

import numpy as np
import xarray

from ....mdr import energy
from ....meshes.compliance import Compliance
from ....meshes.contact_cells import ContactCells
from ....meshes.errors import RingwearError
from ....meshes.radial import Array
from ...problem.defaults import cells_of
from ...problem.problem import Problem
from ...problem.profile import InitialProfile
from ...progress import Stages
from ...wear.contact_edges import located
from ...wear.contact_march import ContactHistory, ContactMarch
from ...wear.fitted_press import CLOSE, CompliancesOn, FittedContact, FittedPress
from ...wear.moments import moments, unresolved_height
from ...wear.unilateral import Interval, Load
from ..base import Solution
from ..quantities import CHANCE, differences
from .sampler import ContactSampler

# of the accuracy asked for that each step in time may add to the worn depth
PER_STEP = 0.05
# times the difference to half as many cells that errors are stated as: edges move, and seldom to
# the same place in a cell
SAFETY = 2.5
# of the bend of fields from cell to cell, which cells lose: where an edge stays in a cell of both
# meshes, their difference says nothing of it. Of punches drawn at random none penetrates by more
# than 0.23 of it where cells hold the face
OF_BENDS = 0.25
# times before and after one that say as much of its error
AROUND = 2
ROUNDOFF = 1e-12
# quantities that err as heights of the face do
OF_HEIGHTS = ("profile", "displacement", "indentation", "displacement_centre", "displacement_max")
# of slopes of the unworn face, which are differences of heights, and of edges, which are sought to
# a few times `CLOSE`
LEAST = {"rms_slope": 1e-8, "contact_radius": 5 * CLOSE}


@dataclass(frozen=True, eq=False)
class UnilateralMethod:
    """What a method gives to contact on part of the face.

    Parameters
    ----------
    even : compliance on linear pressures over cells, and the unknowns behind it; a coarser one
        shows what it errs by
    fitted : compliance on pressures of high degree between given edges
    degrees : highest of those pressures, and a lower one to judge it by
    """

    even: Callable[[ContactCells, bool], tuple[Compliance, int]]
    fitted: Callable[[tuple[float, ...], tuple[bool, ...], int], Compliance]
    degrees: tuple[int, int]


@dataclass(frozen=True, eq=False)
class _Marched:
    """A march, and the unworn press before it."""

    sampler: ContactSampler
    history: ContactHistory
    first: FittedPress | None

    def sampled(self, on_face: bool = False) -> xarray.Dataset:
        return self.sampler.contact_history(self.history, self.first, on_face)


def load_of(problem: Problem) -> Load:
    """The force, which is the unit, or the indentation."""
    return Load(1.0) if problem.indentation is None else Load(None, problem.indentation)


def history(one: UnilateralMethod, problem: Problem, stages: Stages) -> Solution:
    """The history of a punch from its unworn face on."""
    profile, load = problem.profile, load_of(problem)
    with stages("locating"):
        intervals, cells = _located(problem)
        _, coarse_cells = _located(problem, 0.5)
    notes: list[str] = []
    presses: list[FittedPress | None] = [None, None]
    if problem.times[0] == 0:
        with stages("pressing"):
            higher, lower = one.degrees
            rough = _fitted(one, lower, profile, load, intervals, notes)
            press = _fitted(one, higher, profile, load, rough.intervals, notes) if rough else None
        if rough and press:
            presses = [press, rough]
    tolerance = PER_STEP * problem.rtol
    with stages("marching"):
        compliance, unknowns = one.even(cells, False)
        fine = _march(problem, compliance, presses[0], tolerance)
    with stages("estimating"):
        coarse = _march(problem, one.even(coarse_cells, True)[0], presses[1], 4 * tolerance)
        errors = _errors(problem, coarse.sampled(on_face=True), fine.sampled(on_face=True))
        lost = OF_BENDS * fine.sampler.bent(fine.history) / fine.history.indentation
        errors |= {name: np.maximum(errors[name], lost) for name in ("profile", "displacement")}
        # nothing has worn at the start
        errors["profile"] = np.where(problem.times == 0, ROUNDOFF, errors["profile"])
        height = unresolved_height(profile, compliance.space, float(fine.history.indentation.max()))
        missed = height / fine.history.indentation
        errors |= {name: np.maximum(errors[name], missed) for name in OF_HEIGHTS}
        if problem.indentation is not None:
            # forces go as no more than the square of the depth, and their errors stay while they
            # decay
            forces = ("normal_force", "ring_force")
            errors |= {name: 2 * np.maximum(errors[name], missed) for name in forces}
        if missed.max() > problem.rtol:
            notes.append(
                f"the face is finer than the {len(compliance.space.degrees)} cells resolve: "
                "heights "
                f"differ from what they hold by up to {missed.max():.1e} of the indentation"
            )
    parts = {"pressure space": float(errors["indentation"].max())}
    if problem.indentation is not None:
        # what was given has no error; the force decays, and is judged by the first
        force = fine.history.force
        parts = {"force": SAFETY * float(np.abs(coarse.history.force - force).max() / force[0])}
    if problem.march != "modal":
        exact = _Marched(fine.sampler, _steps(fine.sampler, problem, tolerance, None), presses[0])
        steps = differences(fine.sampled(on_face=True), exact.sampled(on_face=True), problem.face)
        errors = {name: error + steps[name] for name, error in errors.items()}
        parts["time step"] = float(steps["indentation"].max())
    results = fine.sampled()
    return Solution(
        results,
        fine.sampled(on_face=True).isel(time=problem.checked),
        errors,
        parts,
        unknowns,
        _settings(fine, presses[0]),
        (*notes, *_parts_of_contact(problem, results)),
    )


@lru_cache(maxsize=16)
def _located(problem: Problem, finer: float = 1.0) -> tuple[tuple[Interval, ...], ContactCells]:
    """Where contact begins, and cells for it, the same for every method.

    It decides on the cells only: any method's compliance will do, and this one is quick.
    """
    return located(energy.compliance, problem.profile, load_of(problem), cells_of(problem, finer))


def _fitted(
    one: UnilateralMethod,
    degree: int,
    profile: InitialProfile,
    load: Load,
    start: tuple[Interval, ...],
    notes: list[str],
) -> FittedPress | None:
    @cache
    def on(edges: tuple[float, ...], infinite: tuple[bool, ...]) -> Compliance:
        return one.fitted(edges, infinite, degree)

    compliances: CompliancesOn = on
    try:
        press = FittedContact(profile, load, compliances).press(start)
        press.check()
    except RingwearError as error:
        if not notes:
            notes.append(
                "the start is as accurate as the march, not fitted to the edges of the contact: "
                f"{error}"
            )
        return None
    return press


def _march(
    problem: Problem, compliance: Compliance, first: FittedPress | None, tolerance: float
) -> _Marched:
    sampler = ContactSampler(problem, problem.profile, compliance)
    return _Marched(sampler, _steps(sampler, problem, tolerance, problem.step), first)


def _steps(
    sampler: ContactSampler, problem: Problem, tolerance: float, step: float | None
) -> ContactHistory:
    of_profile = moments(sampler.profile, sampler.space)
    march = ContactMarch(
        sampler.compliance, problem.wear_coefficients, of_profile, load_of(problem)
    )
    return (
        march.adaptive(problem.times, tolerance)
        if step is None
        else march.implicit(problem.times, step)
    )


def _errors(problem: Problem, coarse: xarray.Dataset, fine: xarray.Dataset) -> dict[str, Array]:
    """Of each quantity over time.

    The greatest difference of times around, for it changes with where edges are in cells.
    """
    errors, later = {}, problem.times > 0
    for name, difference in differences(coarse, fine, problem.face).items():
        near = difference.copy()
        if later.any():
            among = np.pad(difference[later], AROUND)
            near[later] = np.lib.stride_tricks.sliding_window_view(among, 2 * AROUND + 1).max(
                axis=1
            )
        # edges of the contact leave more to chance
        least = np.where(later, 2 * CHANCE * problem.rtol, LEAST.get(name, ROUNDOFF))
        errors[name] = np.maximum(SAFETY * near, least)
    return errors


def _settings(marched: _Marched, first: FittedPress | None) -> dict[str, Any]:
    history, space = marched.history, marched.sampler.space
    iterations = np.array(history.iterations or (0,))
    settings = {
        "cells": len(space.degrees),
        "pressures": space.size,
        "steps": history.steps,
        "rejected_steps": history.rejected,
        "contact_iterations_mean": float(iterations.mean()),
        "contact_iterations_greatest": int(iterations.max()),
    }
    if first is not None:
        settings |= {"start_pressures": len(first.pressure), "start_evaluations": first.evaluations}
    return settings


def _parts_of_contact(problem: Problem, results: xarray.Dataset) -> list[str]:
    """A note if contact is not one disc at any time."""
    edges = results["contact_edge"].values
    parts, inner = (
        np.isfinite(edges).sum(axis=1) // 2,
        edges[:, 0] if edges.shape[1] else np.zeros(len(edges)),
    )
    apart = (parts > 1) | (np.nan_to_num(inner) > 0)
    if not apart.any():
        return []
    times = problem.times[apart] * problem.units.time
    return [
        f"contact is no disc from t = {times[0]:.3g} to {times[-1]:.3g}, in up to {parts.max()} "
        "parts: the springs' "
        "rule of the MDR, q = d - g, would not hold there; its energy does"
    ]


def with_steady(found: Solution, steady: Solution | None) -> Solution:
    """The history beside the steady state of the flat punch."""
    if steady is None:
        return found
    return replace(
        found,
        results=xarray.merge([found.results, steady.results.drop_vars("time", errors="ignore")]),
        checked=xarray.merge([found.checked, steady.checked.drop_vars("time", errors="ignore")]),
        errors=found.errors | steady.errors,
        notes=(*found.notes, *steady.notes),
        settings=found.settings | {"steady_state": steady.settings | {"unknowns": steady.unknowns}},
    )
