"""Figures of the study of refinement: errors against unknowns, quality of the elements, and the meshes themselves."""

from __future__ import annotations

from collections.abc import Callable
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
from ringwear.meshes.half_space import quality, truncation
from ringwear.meshes.radial import Array
from ringwear.studies.convergence.levels import new_figure, style
from ringwear.studies.figures.run import mesh_panel
from skfem import Mesh

ERRORS = ("d0", "history", "steady")
FAMILIES = (
    "h, triangles", "h, quadrilaterals", "p, triangles", "p, quadrilaterals", "graded triangles", "adaptive triangles",
    "file",
)  # fmt: skip


def draw_errors(rows: list[dict[str, Any]], goal: float, path: Path) -> None:
    """Errors against unknowns: a column for each case, a row for each quantity."""
    cases = list(dict.fromkeys(row["case"] for row in rows))
    figure = new_figure(0.6 + 3.2 * len(cases), 7.6)
    panels = figure.subplots(3, len(cases), sharex="col", sharey=True, squeeze=False)
    labels = {"d0": "of $d_0$", "history": "of $d(t)$, greatest", "steady": "of steady $u_{z,max}$"}
    for column, case in enumerate(cases):
        for row_of_panels, quantity in enumerate(ERRORS):
            axes = panels[row_of_panels, column]
            for number, family in enumerate(FAMILIES):
                own = [r for r in rows if r["case"] == case and r["mesh"] == family and "greatest" in r]
                if own:
                    values = np.array([[r["unknowns"], max(r[quantity], 1e-10)] for r in own])
                    axes.loglog(*values.T, label=family, **style(number))
            axes.axhline(goal, color="0.6", linewidth=0.8, linestyle=":")
            axes.grid(True, which="major", color="0.9", linewidth=0.6)
            axes.set_ylabel(f"relative error\n{labels[quantity]}" if column == 0 else "")
        panels[0, column].set_title(case, fontsize=10)
        panels[-1, column].set_xlabel("unknowns")
    handles, names = panels[0, 0].get_legend_handles_labels()
    figure.legend(handles, names, loc="outside lower center", ncols=4, frameon=False, fontsize=9)
    figure.suptitle(f"refinement in size (h), in degree (p), graded and adaptive (goal {goal:g}: dotted)", fontsize=10)
    figure.savefig(path)


def draw_quality(best: dict[tuple[str, str], Mesh], path: Path) -> None:
    """Share of elements below each quality, finest mesh of each kind."""
    cases = list(dict.fromkeys(case for case, _ in best))
    figure = new_figure(0.6 + 3.2 * len(cases), 3.4)
    panels = figure.subplots(1, len(cases), sharey=True, squeeze=False)[0]
    for case, axes in zip(cases, panels, strict=True):
        for number, family in enumerate(FAMILIES):
            if (case, family) in best:
                shape = np.sort(quality(best[case, family]))
                look = style(number) | {"marker": ""}
                axes.plot(shape, np.arange(1, len(shape) + 1) / len(shape), label=family, **look)
        axes.set(xlim=(0, 1), ylim=(0, 1), xlabel="least sine of the corners", title=case)
        axes.title.set_fontsize(10)
        axes.legend(frameon=False, fontsize=8, loc="upper left")
    panels[0].set_ylabel("share of elements below")
    figure.savefig(path)


def draw_meshes(case: str, edges: Array, meshes: dict[str, Mesh], path: Path) -> None:
    """The finest mesh of each kind: whole, under the punch, at the narrowest ring, at the rim."""
    views: list[tuple[str, Callable[[Mesh], tuple[float, float]], float, str]] = [
        ("whole", lambda mesh: (0, truncation(mesh)), 0.0, "$r/a$"),
        ("under the punch", lambda _: (0, 1.15), 0.0, "$r/a$"),
        ("at the rim", lambda _: (-2e-2, 2e-2), 1.0, "$(r-a)/a$"),
    ]
    if len(edges) > 2:
        inner, outer = min(pairwise(edges), key=lambda ring: ring[1] - ring[0])
        reach, middle = min(2 * (outer - inner), 0.4), float(inner + outer) / 2
        views.insert(2, ("narrowest ring", lambda _: (-reach, reach), middle, rf"$r/a - {middle:.4g}$"))
    figure = new_figure(3.2 * len(views), 3.5 * len(meshes))
    panels = figure.subplots(len(meshes), len(views), squeeze=False)
    for row, (family, mesh) in zip(panels, meshes.items(), strict=True):
        for axes, (name, view, centre, label) in zip(row, views, strict=True):
            mesh_panel(axes, mesh, view(mesh), name, label, centre=centre)
        row[0].set_ylabel(f"{family}: depth $z/a$")
    figure.suptitle(f"{case}: the finest mesh of each kind; the bar above is the punch", fontsize=10)
    figure.savefig(path)
