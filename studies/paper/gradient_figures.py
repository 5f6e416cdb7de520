"""Figs. 6 and 7 of the paper, redrawn: the gradient of the limiting profile against wear ratio and width ratio."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from ringwear.mdr import direct
from ringwear.meshes.radial import alternating_edges
from ringwear.studies.figures.run import D0, shade_rings
from ringwear.studies.paper.figures import DOTTED, canvas, foot_legend
from ringwear.studies.paper.gradients import WIDTH_STUDY_RATIO, Curves, alternating_pressures, many_rings, odd_and_even

DASHES: tuple[Any, ...] = ("-", (0, (7, 2)), (0, (4, 2)), (0, (5, 1.5, 1, 1.5)), (0, (2, 1.2)), (0, (1, 1)))


def draw_wear_ratios(curves: Curves, path: Path) -> None:
    """Fig. 6: against ``k2/k1``, both averages; insets with the limiting profiles of four rings."""
    figure = canvas(12, 5.4)
    panels = figure.subplots(1, 2)
    for average, axes in enumerate(panels):
        _draw_curves(axes, curves, average)
        ratios = next(iter(curves.direct.values()))[0]
        axes.plot(ratios, many_rings(ratios, np.array(1.0))[average], color="black", linewidth=2.6, alpha=0.35,
                  label="$N \\to \\infty$")  # fmt: skip
        axes.set_xlim(1e-4, 1e4)
        axes.set_ylim(0.9, 4.4 if average == 0 else 3.9)
        axes.set_xlabel("wear ratio $k_2/k_1$")
        axes.axhline(1, **DOTTED)
    _inset(panels[0], (0.11, 0.66, 0.19, 0.24), 4, 1.0, 0.01, "$N$ = 4, $k_2/k_1$ = 0.01")
    _inset(panels[0], (0.40, 0.66, 0.19, 0.24), 4, 1.0, 100.0, "$N$ = 4, $k_2/k_1$ = 100")
    foot_legend(figure, panels[0])
    figure.suptitle("Fig. 6: RMS gradient of the limiting profile against the wear ratio, $h_2/h_1$ = 1", fontsize=10)
    figure.savefig(path)


def draw_width_ratios(curves: Curves, path: Path) -> None:
    """Fig. 7: against ``h2/h1``, both averages; insets with the limiting profiles of eight rings."""
    figure = canvas(12, 5.4)
    panels = figure.subplots(1, 2)
    for average, axes in enumerate(panels):
        _draw_curves(axes, curves, average)
        ratios = next(iter(curves.direct.values()))[0]
        limit = many_rings(np.array(WIDTH_STUDY_RATIO), ratios)[average]
        axes.plot(ratios, limit, color="black", linewidth=2.6, alpha=0.35, label="$N \\to \\infty$")
        axes.set_xlim(0.1, 10)
        axes.set_ylim(0.9, 6.2 if average == 0 else 5.0)
        axes.set_xlabel("width ratio $h_2/h_1$")
        axes.xaxis.set_major_formatter(lambda value, _: f"{value:g}")
        axes.axhline(1, **DOTTED)
    _inset(panels[0], (0.35, 0.60, 0.27, 0.27), 8, 0.1, WIDTH_STUDY_RATIO, "$N$ = 8, $h_2/h_1$ = 0.1")
    _inset(panels[0], (0.70, 0.60, 0.27, 0.27), 8, 10.0, WIDTH_STUDY_RATIO, "$N$ = 8, $h_2/h_1$ = 10")
    foot_legend(figure, panels[0])
    figure.suptitle(
        f"Fig. 7: RMS gradient of the limiting profile against the width ratio, $k_2/k_1$ = {WIDTH_STUDY_RATIO:g}",
        fontsize=10,
    )
    figure.savefig(path)


def _draw_curves(axes: Any, curves: Curves, average: int) -> None:
    for (rings, (ratios, values)), dashes in zip(curves.direct.items(), DASHES, strict=False):
        axes.plot(ratios, values[average], linestyle=dashes, color="black", linewidth=1.2, label=f"$N$ = {rings}")
    for order, (ratios, values) in enumerate(curves.fem.values()):
        label = "FEM" if order == 0 else None
        axes.plot(ratios, values[average], "o", color="#c0392b", markersize=4.5, markerfacecolor="none", label=label)
    axes.set_xscale("log")
    axes.set_ylabel(r"RMS gradient $\nabla f/\nabla f_0$")
    axes.set_title(f"average over the {('radius (line)', 'area')[average]}", fontsize=9)


def _inset(axes: Any, place: tuple[float, ...], rings: int, width_ratio: float, wear_ratio: float, title: str) -> None:
    """A limiting profile, as in the paper's small figures."""
    inset = axes.inset_axes(place)
    edges = alternating_edges(rings, width_ratio)
    wear = odd_and_even(rings) @ [1.0, wear_ratio]
    pressures = odd_and_even(rings) @ alternating_pressures(edges, np.array([wear_ratio]))[:, 0]
    radii = np.linspace(0, 1, 600)
    inset.plot(radii, direct.limiting_profile(edges, pressures, radii) / D0, color="black", linewidth=1)
    shade_rings(inset, edges, wear)
    inset.invert_yaxis()
    inset.tick_params(labelsize=7)
    inset.set_xticks([0, 0.5, 1], ["0", "$r/a$", "1"])
    inset.set_ylabel("$f_{stat}/d_0$", fontsize=7, labelpad=1)
    inset.set_title(title, fontsize=7.5, pad=3)
