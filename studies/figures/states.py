"""Profiles and pressures over the radius.

At several times (the paper's Fig. 4), and in the steady state.

Profiles are shown less their least wear, which the figure names: most of what has worn is the same
everywhere.
"""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import xarray

from ...meshes.radial import Array, Indices
from ..methods.base import Solution
from ..methods.quantities import array
from ..problem.problem import P0, Problem
from ..problem.scene import Scene
from .scale import Scale
from .style import (
    FAINT,
    Margins,
    broken_at,
    footing,
    heading,
    method_curve,
    page,
    save,
    shade_rings,
    styled,
    titled,
)

# more rings than this take the whole width of a page, and lines without marks
MANY = 24


def given(quantity: str, solutions: Mapping[str, Solution]) -> dict[str, xarray.Dataset]:
    """Results of the methods that give a quantity."""
    return {name: one.results for name, one in solutions.items() if quantity in one.results}


def curve_of(name: str, problem: Problem) -> dict[str, Any]:
    """The curve of a method over the radius: thin and without marks where there are many rings."""
    look = method_curve(name, len(problem.radii))
    if len(problem.wear_coefficients) > MANY:
        look = {key: value for key, value in look.items() if not key.startswith("mark")}
        look["linewidth"] *= 0.5
    return look


def shown_times(problem: Problem, most: int) -> Indices:
    """Some of the times, the first and the last among them; of few, none is spent on the start."""
    every = np.arange(len(problem.times))
    if problem.earliest and most < 4:
        every = np.flatnonzero(problem.times > 0)
    return every[
        np.unique(np.linspace(0, len(every) - 1, min(len(every), most)).round().astype(np.int64))
    ]


class Panels:
    """Draws profiles and pressures of a scene into panels."""

    def __init__(self, scene: Scene) -> None:
        self.problem, self.scale = scene.problem, Scale(scene)
        self.radii = self.problem.radii * self.scale.radius.factor

    def profile(self, axes: Any, every: Mapping[str, Array]) -> float:
        """Worn heights by method, less the least; returns that, non-dimensional."""
        least = min(float(values.min()) for values in every.values())
        for name, values in every.items():
            axes.plot(
                self.radii,
                (values - least) * self.scale.height.factor,
                **curve_of(name, self.problem),
            )
        shade_rings(axes, *self.problem.rings, self.scale.radius.factor)
        return least

    def pressure(self, axes: Any, every: Mapping[str, Array]) -> None:
        edges = self.problem.merged.ring_edges * self.scale.radius.factor
        for name, values in every.items():
            shown = broken_at(edges, self.radii, values * self.scale.pressure.factor)
            axes.plot(*shown, **curve_of(name, self.problem))
        shade_rings(axes, *self.problem.rings, self.scale.radius.factor)

    def unworn(self, upper: Any, lower: Any) -> None:
        """The face before wear, less its least height.

        Of a flat punch, which has none, the pressure.
        """
        if not self.problem.full_contact:
            heights = self.problem.profile(self.problem.radii) + self.problem.profile.standoff
            upper.plot(
                self.radii,
                (heights - heights.min()) * self.scale.height.factor,
                **FAINT,
                label="unworn punch",
            )
            return
        radii = np.linspace(0, 1, 400)[:-1]
        pressure = P0 * self.scale.pressure.factor / np.sqrt(1 - radii**2)
        lower.plot(radii * self.scale.radius.factor, pressure, **FAINT, label="unworn punch")

    @property
    def note(self) -> str:
        """What is shaded, where anything is, and what the axes are over."""
        shaded = "shaded: rings that wear faster" if np.ptp(self.problem.wear_coefficients) else ""
        return "; ".join(part for part in (shaded, self.scale.note) if part)

    @property
    def labels(self) -> tuple[str, str, str]:
        """Of heights, pressures and radii."""
        height = self.scale.height.label("worn height", "f").replace("$f", "$\\Delta f")
        return (
            height,
            self.scale.pressure.label("pressure", "p"),
            self.scale.radius.label("radius", "r"),
        )


@styled
def draw_states(scene: Scene, solutions: Mapping[str, Solution], path: Path) -> None:
    """Profiles and pressures at several times, every method over the other."""
    problem, every, draw = scene.problem, given("profile", solutions), Panels(scene)
    many = len(problem.wear_coefficients) > MANY
    states = shown_times(problem, 3 if many else 6)
    if many:
        figure, panels = page(
            2 * len(states), 1, 0.95, Margins(top=0.45, down=0.3, bottom=0.68), sharex=True
        )
        pairs = panels.reshape(len(states), 2)
    else:
        width = 0.6 + 1.1 * max(len(states), 3)
        figure, panels = page(
            2, len(states), 1.3, Margins(top=0.62, bottom=0.68), width, sharex=True, sharey="row"
        )
        pairs = panels.T
    tallest, tops = 0.0, []
    for number, (state, (upper, lower)) in enumerate(zip(states, pairs, strict=True)):
        profiles = {name: array(results, "profile")[state] for name, results in every.items()}
        pressures = {name: array(results, "pressure")[state] for name, results in every.items()}
        least = draw.profile(upper, profiles)
        draw.pressure(lower, pressures)
        tallest = max(tallest, *(float(values.max()) - least for values in profiles.values()))
        tops += [float(np.quantile(values, 0.97)) for values in pressures.values()]
        draw.unworn(upper, lower)
        between = ": " if many else "\n"
        less = f"f − {draw.scale.worn(least)}" if least else "f"
        upper.set_title(f"{draw.scale.when(scene.wear.times[state])}{between}Δf = {less}")
        if many or number == 0:
            upper.set_ylabel(draw.labels[0])
            lower.set_ylabel(draw.labels[1])
        if not many or number == len(states) - 1:
            lower.set_xlabel(draw.labels[2])
    for upper, lower in pairs:
        # worn down: what is missing below; a scale also where nothing has worn
        upper.set_ylim(
            1.08 * (tallest or 1.0) * draw.scale.height.factor,
            -0.05 * (tallest or 1.0) * draw.scale.height.factor,
        )
        lower.set_ylim(0, 1.25 * max(tops) * draw.scale.pressure.factor)
    footing(figure, pairs[0, ::-1], draw.note)
    heading(figure, titled(scene.title, "profiles and pressures"))
    save(figure, path)


@styled
def draw_steady(scene: Scene, solutions: Mapping[str, Solution], path: Path) -> None:
    """Limiting profile and steady pressure, every method over the other."""
    every, draw = given("steady_profile", solutions), Panels(scene)
    many = len(scene.problem.wear_coefficients) > MANY
    figure, panels = (
        page(2, 1, 1.3, Margins(top=0.3, bottom=0.68), sharex=True)
        if many
        else page(1, 2, 1.9, Margins(across=0.6, top=0.3, bottom=0.68))
    )
    profile, pressure = panels.ravel()
    draw.profile(
        profile, {name: array(results, "steady_profile") for name, results in every.items()}
    )
    draw.pressure(
        pressure, {name: array(results, "steady_pressure") for name, results in every.items()}
    )
    profile.invert_yaxis()
    pressure.set_ylim(0, 1.05 * pressure.dataLim.ymax)
    profile.set_ylabel(draw.scale.height.label("limiting profile", "f_{stat}"))
    pressure.set_ylabel(draw.scale.pressure.label("steady pressure", "p"))
    for axes in [pressure] if many else [profile, pressure]:
        axes.set_xlabel(draw.labels[2])
    footing(figure, [profile], draw.note)
    heading(figure, titled(scene.title, "steady state"))
    save(figure, path)
