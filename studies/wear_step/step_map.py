"""Map of element size and wear step: which explicit updates are stable, and how accurate.

Each point is a march of explicit updates on linear quadrilaterals of one size, as in programs with
elements. Its error is that of the pressure against the same mesh without any error of the steps.
"""

import numpy as np
import pandas as pd
from matplotlib.figure import Figure

from ...meshes import Array
from ..crosscheck import Problem, Scene
from ..figures.style import complete, in_style, new_panels, set_logarithmic
from .contact_nodes import contact_nodes
from .elements import PER_NODE
from .explicit import INSIDE, ExplicitWear, explicit
from .limits import mesh_below, vertices_of_size

ELEMENT = "Q1"
SIZES, QUICK_SIZES = (0.2, 0.1, 0.05, 0.025), (0.2, 0.1)
"""Sizes of the elements on the contact, in punch radii."""
PARTS = (0.05, 0.1, 0.25, 0.5, 0.8, 0.95, 1.05, 1.3, 2.0)
"""Steps over the longest stable one."""
FEWEST_UPDATES, MOST_UPDATES = 120, 1000
"""Least and greatest number of updates of a march; so many show a growth by 1.1 per update."""
UNSTABLE = 0.5
"""Error of the pressure at the end, over its root mean square, from which a march is unstable."""
COLUMNS = ("size", "step", "step over limit", "updates", "error of the pressure", "stable")


def step_map(problem: Problem, quick: bool) -> pd.DataFrame:
    """Return a row for each size and step, in punch radii and units of the non-dimensional time.

    Parameters
    ----------
    problem : a flat punch under a constant load, on a homogeneous half-space
    quick : whether fewer sizes are marched
    """
    rows = []
    for size in QUICK_SIZES if quick else SIZES:
        vertices = vertices_of_size(problem, size)
        mesh = mesh_below(vertices, ELEMENT, problem.merged.ring_edges)
        update = explicit(problem, contact_nodes(mesh, ELEMENT, problem.ground), PER_NODE)
        for part in PARTS:
            count, error = _march(update, part * update.limit)
            stable = error < UNSTABLE
            rows.append((size, part * update.limit, part, count, error, stable))
    return pd.DataFrame(rows, columns=[*COLUMNS])


def _march(update: ExplicitWear, step: float) -> tuple[int, float]:
    """Return the number of updates of a march, and the error of its last pressures."""
    wanted = int(np.ceil(update.running_in_time / step / 4))
    count = int(np.clip(wanted, FEWEST_UPDATES, MOST_UPDATES))
    pressure: Array = update.start
    for pressure, _ in update.march(step, count + 1):
        if not np.abs(pressure).max() < 1e6 * np.abs(update.start).max():
            return count, np.inf
    right = update.pressures(update.exact(np.array([count * step])))[0]
    inner = update.radii < INSIDE
    return count, float(
        np.sqrt(np.mean((pressure - right)[inner] ** 2) / np.mean(right[inner] ** 2))
    )


def draw_map(table: pd.DataFrame, scene: Scene, title: str) -> Figure:
    """Draw the map, with the limit by the eigenvalue of each mesh as a line."""
    names, units = scene.unit_names, scene.problem.units
    sizes = table["size"] * units.length
    steps, stable = table["step"] * units.time, table["stable"].to_numpy(bool)
    limits = (table["step"] / table["step over limit"] * units.time).groupby(sizes).first()
    with in_style():
        figure, ((axes,),) = new_panels(5.4, 3.8)
        axes.plot(limits.index, limits, "k-", linewidth=1.2, label="limit by the eigenvalue")
        colours = np.log10(np.clip(table["error of the pressure"], 1e-4, 1.0))
        points = axes.scatter(
            sizes[stable], steps[stable], c=colours[stable], cmap="viridis", vmin=-4, vmax=0, s=40
        )
        axes.scatter(
            sizes[~stable], steps[~stable], marker="x", color="#c0392b", s=40, label="unstable"
        )
        set_logarithmic(axes, "x", "y")
        bar = figure.colorbar(points, ax=axes)
        bar.set_label("error of the pressure by the steps, as power of ten")
        axes.set(
            xlabel=_labelled("size of linear quadrilaterals", names.name("length")),
            ylabel=_labelled("wear step", names.name("time")),
        )
        return complete(figure, [title], [axes])


def _labelled(text: str, unit: str) -> str:
    return text if unit == "1" else f"{text} ({unit})"


def conclude_map(table: pd.DataFrame, scene: Scene) -> str:
    """Return a sentence on the limit by the size, and on the marches at both sides of it."""
    names, units = scene.unit_names, scene.problem.units
    within = table["step over limit"] < 1
    right = (table["stable"] == within).sum()
    finest = table[table["size"] == table["size"].min()]
    limit = float((finest["step"] / finest["step over limit"]).iloc[0]) * units.time
    size = names.write(float(finest["size"].iloc[0]) * units.length, "length", 3)
    return (
        f"Explicit updates at the nodes of linear quadrilaterals of {size} are stable up to "
        f"{names.write(limit, 'time', 3)} by the greatest eigenvalue, in proportion to the size; "
        f"{right} of {len(table)} marches at 5 % to twice the limit are stable below it and "
        "unstable above it (figure map)."
    )
