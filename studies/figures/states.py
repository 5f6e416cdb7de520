"""Profiles and pressures over the radius.

At several times (the paper's Fig. 4), and in the steady state.

Profiles are shown less their least wear, which the figure names: most of what has worn is the same
everywhere.
"""

from collections.abc import Mapping
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from ...meshes.radial import Array
from ..crosscheck.dataset import Result
from ..methods.quantities import array
from ..problem.problem import P0
from .scale import Scale, shown_times
from .style import (
    FAINT,
    broken_at,
    complete,
    method_curve,
    page,
    shade_rings,
    titled,
    without_marks,
)


class Panels:
    """Draws profiles and pressures of a result into panels.

    Of many rings panels take the whole width of a page, and curves are thin and without marks.
    """

    def __init__(self, result: Result) -> None:
        self.problem, self.scale = result.scene.problem, Scale(result.scene)
        self.radii = self.problem.radii * self.scale.radius.factor
        self.many = len(self.problem.wear_coefficients) > 24

    def draw(
        self, upper: Any, lower: Any, profiles: Mapping[str, Array], pressures: Mapping[str, Array]
    ) -> float:
        """Draw worn heights less the least, and pressures, by method; return the least height."""
        least = min(float(heights.min()) for heights in profiles.values())
        edges = self.problem.merged.ring_edges * self.scale.radius.factor
        for name, heights in profiles.items():
            look = method_curve(name, len(self.radii))
            if self.many:
                look = without_marks(look) | {"linewidth": 0.5 * look["linewidth"]}
            upper.plot(self.radii, (heights - least) * self.scale.height.factor, **look)
            pressure = pressures[name] * self.scale.pressure.factor
            lower.plot(*broken_at(edges, self.radii, pressure), **look)
        for axes in (upper, lower):
            shade_rings(axes, *self.problem.rings, self.scale.radius.factor)
        lower.set_xlabel(self.scale.radius.label("radius", "r"))
        return least

    def draw_unworn(self, upper: Any, lower: Any) -> None:
        """Draw the face before wear, less its least height; of a flat punch, the pressure."""
        look = FAINT | {"label": "unworn punch"}
        if not self.problem.full_contact:
            heights = self.problem.profile(self.problem.radii)
            upper.plot(self.radii, (heights - heights.min()) * self.scale.height.factor, **look)
            return
        radii = np.linspace(0, 1, 400)[:-1]
        pressure = P0 * self.scale.pressure.factor / np.sqrt(1 - radii**2)
        lower.plot(radii * self.scale.radius.factor, pressure, **look)

    def complete(self, figure: Figure, title: str, axes: Any) -> Figure:
        """Say what is shaded, where anything is, and what the axes are over."""
        shaded = "shaded: rings that wear faster" if np.ptp(self.problem.wear_coefficients) else ""
        return complete(figure, title, axes, "; ".join(filter(None, (shaded, self.scale.note))))


def draw_states(result: Result) -> Figure:
    """Draw profiles and pressures at several times, every method over the other."""
    panels, results = Panels(result), result.given("profile")
    states = shown_times(panels.problem, 3 if panels.many else 6)
    if panels.many:
        figure, grid = page(2 * len(states), 1, 0.95, top=0.45, down=0.3, sharex=True)
        pairs = grid.reshape(len(states), 2)
    else:
        width = 0.6 + 1.1 * max(len(states), 3)
        figure, grid = page(2, len(states), 1.3, top=0.62, width=width, sharex=True, sharey="row")
        pairs = grid.T
    for state, (upper, lower) in zip(states, pairs, strict=True):
        profiles, pressures = (
            {name: array(values, quantity)[state] for name, values in results.items()}
            for quantity in ("profile", "pressure")
        )
        least = panels.draw(upper, lower, profiles, pressures)
        panels.draw_unworn(upper, lower)
        when = panels.scale.when(result.scene.wear.times[state])
        less = f" − {panels.scale.worn(least)}" if least else ""
        upper.set_title((": " if panels.many else "\n").join([when, f"Δf = f{less}"]))
    tallest = max(_drawn(pairs[:, 0], 1.0)) or panels.scale.height.factor
    for upper, lower in pairs:
        # worn down: what is missing below
        upper.set_ylim(1.08 * tallest, -0.05 * tallest)
        lower.set_ylim(0, 1.25 * max(_drawn(pairs[:, 1], 0.97)))
        for axes in (upper, lower):
            axes.label_outer()
    for upper, lower in pairs if panels.many else pairs[:1]:
        upper.set_ylabel(panels.scale.height.label("worn height", "\\Delta f"))
        lower.set_ylabel(panels.scale.pressure.label("pressure", "p"))
    return panels.complete(figure, titled(result.scene, "profiles and pressures"), pairs[0, ::-1])


def _drawn(panels: Any, quantile: float) -> list[float]:
    """Quantiles of the values of all curves."""
    lines = [line for axes in panels for line in axes.get_lines()]
    return [float(np.nanquantile(line.get_ydata(), quantile)) for line in lines]


def draw_steady(result: Result) -> Figure:
    """Draw limiting profile and steady pressure, every method over the other."""
    panels, results = Panels(result), result.given("steady_profile")
    if panels.many:
        figure, grid = page(2, 1, 1.3, sharex=True)
    else:
        figure, grid = page(1, 2, 1.9, across=0.6)
    upper, lower = grid.ravel()
    profiles, pressures = (
        {name: array(values, quantity) for name, values in results.items()}
        for quantity in ("steady_profile", "steady_pressure")
    )
    panels.draw(upper, lower, profiles, pressures)
    upper.invert_yaxis()
    lower.set_ylim(bottom=0)
    upper.set_ylabel(panels.scale.height.label("limiting profile", "f_{stat}"))
    lower.set_ylabel(panels.scale.pressure.label("steady pressure", "p"))
    upper.set_xlabel(lower.get_xlabel())
    upper.label_outer()
    return panels.complete(figure, titled(result.scene, "steady state"), [upper])
