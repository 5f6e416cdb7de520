"""The paper's explicit march as an outcome beside the others: the `mdr` history where ``march = "explicit"``."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from ringwear.mdr.uniform_grid import PaperGrid
from ringwear.meshes.radial import Array
from ringwear.studies.methods.outcome import Outcome, outcome
from ringwear.studies.problem.problem import NaturalScene


def paper_history(natural: NaturalScene) -> Outcome:
    """The history on the uniform grid of the scene, by the scene's step."""
    assert natural.step is not None  # the scene's door saw to it
    return _march(natural, natural.scene.accuracy.mdr.grid, natural.step)


def paper_errors(natural: NaturalScene, result: Outcome) -> Outcome:
    """Relative error estimates: the grid and the step are first order, so a run with half the points has twice the error."""
    from ringwear.studies.methods.outcome import relative_difference

    assert natural.step is not None
    coarse = _march(natural, natural.scene.accuracy.mdr.grid // 2, 2 * natural.step)
    estimates = {
        name: relative_difference(name, getattr(coarse, name), value) for name, value in vars(result).items() if value.size
    }
    return outcome(estimates)


def _march(natural: NaturalScene, count: int, step: float) -> Outcome:
    edges, wear = natural.phases
    grid = PaperGrid(edges, wear, count)
    pressure, profile, indentation = grid.march(natural.times, step)
    slopes = np.gradient(profile, grid.radii, axis=1)
    weight = np.ones(count + 1) if natural.scene.output.gradient_average == "line" else 2 * grid.radii
    parts = {
        "pressure": _sampled(pressure, grid, natural.radii),
        "profile": _sampled(profile, grid, natural.radii),
        "indentation": indentation,
        "displacement_centre": indentation - profile[:, 0],
        "displacement_max": indentation - profile.min(axis=1),
        "rms_slope": np.sqrt(np.trapezoid(weight * slopes**2, grid.radii, axis=1)),
        "ring_force": _ring_forces(pressure, grid, natural.edges),
    }
    return outcome(parts | {"displacement": indentation[:, None] - parts["profile"]})


def _sampled(values: Array, grid: PaperGrid, radii: Array) -> Array:
    return np.array([np.interp(radii, grid.radii, row) for row in values]).reshape(len(values), len(radii))


def _ring_forces(pressure: Array, grid: PaperGrid, edges: Array) -> Array:
    """Force on each ring by the trapezoidal rule, read off the running integral at the ring edges."""
    density = 2 * np.pi * grid.radii * pressure
    running = np.concatenate(
        [np.zeros((len(pressure), 1)), np.cumsum((density[:, 1:] + density[:, :-1]) / 2, axis=1)], axis=1
    )
    return np.diff(_sampled(running / grid.count, grid, edges), axis=1)


def with_steady(history: Outcome, steady: Outcome) -> Outcome:
    """The history of one outcome with the steady state (and relaxation times) of another."""
    names = [name for name in vars(steady) if name.startswith("steady") or name == "relaxation_time"]
    return replace(history, **{name: getattr(steady, name) for name in names})
