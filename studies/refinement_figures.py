"""Figures of the study of refinement: errors against unknowns, quality of the triangles, and the meshes themselves."""

from __future__ import annotations

from collections.abc import Callable
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np

from meshes.half_space import HalfSpaceMesh
from meshes.radial import Array

from .figures import _mesh_panel
from .levels import new_figure, style

ERRORS = ("d0", "history", "steady")
FAMILIES = ("uniform", "graded", "adaptive", "file")


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
    figure.legend(handles, names, loc="outside lower center", ncols=len(names), frameon=False, fontsize=9)
    figure.suptitle(f"uniform, graded and adaptive meshes (goal {goal:g}: dotted)", fontsize=10)
    figure.savefig(path)


def draw_quality(best: dict[tuple[str, str], HalfSpaceMesh], path: Path) -> None:
    """Share of triangles below each quality, finest mesh of each kind."""
    cases = list(dict.fromkeys(case for case, _ in best))
    figure = new_figure(0.6 + 3.2 * len(cases), 3.4)
    panels = figure.subplots(1, len(cases), sharey=True, squeeze=False)[0]
    for case, axes in zip(cases, panels, strict=True):
        for number, family in enumerate(FAMILIES):
            if (case, family) in best:
                quality = np.sort(best[case, family].quality)
                look = style(number) | {"marker": ""}
                axes.plot(quality, np.arange(1, len(quality) + 1) / len(quality), label=family, **look)
        axes.set(xlim=(0, 1), ylim=(0, 1), xlabel="2 inradius / circumradius", title=case)
        axes.title.set_fontsize(10)
        axes.legend(frameon=False, fontsize=8, loc="upper left")
    panels[0].set_ylabel("share of triangles below")
    figure.savefig(path)


def draw_meshes(case: str, edges: Array, meshes: dict[str, HalfSpaceMesh], path: Path) -> None:
    """The finest mesh of each kind: whole, under the punch, at the narrowest ring, at the rim."""
    views: list[tuple[str, Callable[[HalfSpaceMesh], tuple[float, float]], float, str]] = [
        ("whole", lambda mesh: (0, mesh.truncation), 0.0, "$r/a$"),
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
            _mesh_panel(axes, mesh, view(mesh), name, label, centre=centre)
        row[0].set_ylabel(f"{family}: depth $z/a$")
    figure.suptitle(f"{case}: the finest mesh of each kind; the bar above is the punch", fontsize=10)
    figure.savefig(path)
