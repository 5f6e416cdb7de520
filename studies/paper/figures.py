"""Figs. 4 to 7 of the paper, redrawn, and the relaxation times."""

from pathlib import Path
from typing import Any

import numpy as np

from ...mdr import direct
from ...meshes.radial import Array
from ..figures.style import (
    FAINT,
    LINES,
    broken_at,
    legend_of,
    method_curve,
    new_figure,
    shade_rings,
)
from ..methods.sampler import AVERAGES
from ..problem.problem import D0, Rings
from .gradients import WEAR_RATIO_OF_WIDTHS, Curves, direct_gradients
from .running_in import (
    CURVE,
    SHARES,
    STATIONARY,
    WEAR_RATIO,
    WEAR_RATIOS,
    FiveRings,
    many_ring_times,
)

QUANTITIES = {
    "profile": "profile $(f-f_{min})/d_0$",
    "line_profile": "1D profile $(g-f_{min})/d_0$",
    "pressure": "pressure $p/p_0$",
}
LIMIT: dict[str, Any] = {"color": "0.65", "linewidth": 2.6, "label": r"$N \to \infty$"}
TITLES = ("average over the radius (line)", "average over the area")
# of Figs. 6 and 7: ratio, what is held, and the punches whose limiting profiles are shown beside
RATIOS = {
    6: ("wear ratio $k_2/k_1$", "$h_2/h_1$ = 1"),
    7: ("width ratio $h_2/h_1$", f"$k_2/k_1$ = {WEAR_RATIO_OF_WIDTHS}"),
}
PROFILES = {
    6: {
        f"$N$ = 4, $k_2/k_1$ = {ratio:g}": Rings.alternating(4, 1.0, ratio)
        for ratio in (0.01, 100.0)
    },
    7: {
        f"$N$ = 8, $h_2/h_1$ = {ratio:g}": Rings.alternating(8, ratio, WEAR_RATIO_OF_WIDTHS)
        for ratio in (0.1, 10.0)
    },
}


def draw_states(five: FiveRings, path: Path) -> None:
    """Fig. 4: profile, one-dimensional profile and pressure at seven states."""
    problem, reference = five.reference.problem, five.states["mdr"]
    radii, columns = problem.radii, len(SHARES)
    figure = new_figure(2.05 * columns, 7.4)
    panels = figure.subplots(3, columns, sharex=True, sharey="row")
    for state, share in enumerate(SHARES):
        when = f"$t$ = {100 * five.times[state] / five.stationary:.3g} % of $t_{{stat}}$\n"
        worn = f"$f_{{min}}$ = {reference.least_wear[state]:.3g} $d_0$"
        panels[0, state].set_title(
            f"{100 * share:.0f} %\n" + (when + worn if share < 1 else "steady state\n"),
            fontsize=8.5,
        )
        for quantity, axes in zip(QUANTITIES, panels[:, state], strict=True):
            for order, (name, states) in enumerate(five.states.items()):
                # markers of different methods on different points
                look = method_curve(name, len(radii)) | {"markevery": (9 * order, 28)}
                axes.plot(
                    *broken_at(problem.ring_edges, radii, getattr(states, quantity)[state]), **look
                )
            if share == 1 and quantity in five.limiting:
                values = broken_at(problem.ring_edges, radii, five.limiting[quantity])
                axes.plot(
                    *values,
                    **method_curve("direct", len(radii)) | {"label": "DIRECT (steady state only)"},
                )
            shade_rings(axes, *problem.rings)
        panels[2, state].plot(radii, 1 / np.sqrt(1 - radii**2), label="unworn", **FAINT)
        panels[2, state].set_xlabel("$r/a$, $x/a$")
    for axes, label in zip(panels[:, 0], QUANTITIES.values(), strict=True):
        axes.set_ylabel(label)
    panels[0, 0].invert_yaxis()
    # a worn rim carries no line density, so that g(a) = d; at the start the pressure at the rim is
    # infinite
    panels[1, 0].set_ylim(1.2, 1.2 * float(reference.line_profile.min()))
    panels[2, 0].set_ylim(0, 1.3 * np.quantile(reference.pressure[1:], 0.98))
    legend_of(figure, panels[2, -1:])
    figure.suptitle(
        "Fig. 4: five rings, $k_2/k_1$ = 10, $h_2/h_1$ = 1, by the displacement difference over "
        "that of the steady state; "
        f"$t_{{stat}}$: {100 * STATIONARY:g} %; shaded rings wear faster",
        fontsize=10,
    )
    figure.savefig(path)


def draw_history(five: FiveRings, path: Path) -> None:
    """Fig. 5: RMS gradient over time, the states of Fig. 4 marked."""
    figure = new_figure(10, 4)
    panels = figure.subplots(1, 2)
    marked = five.times[:-1] / five.stationary
    over_homogeneous = direct_gradients(five.reference.problem.ring_edges, np.array([WEAR_RATIO]))[
        :, 0
    ]
    for average, (axes, scale) in enumerate(zip(panels, over_homogeneous, strict=True)):
        for order, (name, states) in enumerate(five.curves.items()):
            look = method_curve(name, len(CURVE)) | {"markevery": (4 * order, 12)}
            axes.plot(CURVE, states.gradients[:, average], **look)
        at_states = five.states["mdr"].gradients[:-1, average]
        axes.plot(
            marked,
            at_states,
            "D",
            color="black",
            markerfacecolor="white",
            label="states of Fig. 4",
            zorder=5,
        )
        for share, time, value in zip(SHARES, marked, at_states, strict=False):
            axes.annotate(
                f"{100 * share:.0f} %",
                (time, value),
                (8, -9),
                textcoords="offset points",
                fontsize=8,
            )
        axes.axhline(1, **FAINT)
        axes.set_ylim(-0.09, 1.09)
        axes.set_xlabel("time $t/t_{stat}$")
        axes.set_ylabel(r"RMS gradient $\nabla f/\nabla f_{stat}$")
        axes.set_title(TITLES[average], fontsize=9)
        right = axes.secondary_yaxis(
            "right", functions=(lambda v, s=scale: v * s, lambda v, s=scale: v / s)
        )
        right.set_ylabel(r"over the homogeneous punch, $\nabla f/\nabla f_0$")
    legend_of(figure, panels[:1])
    figure.suptitle(
        "Fig. 5: gradient of the worn surface, five rings, $k_2/k_1$ = 10, $h_2/h_1$ = 1",
        fontsize=10,
    )
    figure.savefig(path)


def draw_gradients(number: int, curves: Curves, path: Path) -> None:
    """Figs.

    6 and 7: gradient against a ratio by both averages, and limiting profiles of two punches.
    """
    figure = new_figure(13, 5)
    panels: Any = figure.subplot_mosaic(
        [[*AVERAGES, name] for name in PROFILES[number]], width_ratios=[3, 3, 1.3]
    )
    ratio, held = RATIOS[number]
    for average, name in enumerate(AVERAGES):
        axes = panels[name]
        axes.plot(curves.ratios, curves.limit[average], **LIMIT)
        for (count, values), line in zip(curves.direct.items(), LINES, strict=False):
            axes.plot(
                curves.ratios,
                values[average],
                color="black",
                linestyle=line,
                linewidth=1.1,
                label=f"$N$ = {count}",
            )
        for values in curves.fem.values():
            axes.plot(
                curves.ratios,
                values[average],
                **method_curve("fem") | {"linestyle": "none", "markersize": 4.5},
            )
        axes.axhline(1, **FAINT)
        axes.set_xscale("log")
        axes.set_xlim(curves.ratios[0], curves.ratios[-1])
        axes.set_xlabel(ratio)
        axes.set_ylabel(r"RMS gradient $\nabla f/\nabla f_0$")
        axes.set_title(TITLES[average], fontsize=9)
    radii = np.linspace(0, 1, 600)
    for name, rings in PROFILES[number].items():
        profile = direct.limiting_profile(rings.ring_edges, direct.steady_pressures(*rings), radii)
        panels[name].plot(radii, profile / D0, color="black", linewidth=1)
        shade_rings(panels[name], *rings)
        panels[name].invert_yaxis()
        panels[name].set_ylabel("$f_{stat}/d_0$")
        panels[name].set_title(name, fontsize=9)
    legend_of(figure, [panels["line"]])
    figure.suptitle(
        f"Fig. {number}: RMS gradient of the limiting profile against the {ratio}, {held}",
        fontsize=10,
    )
    figure.savefig(path)


def draw_relaxation(times: dict[int, Array], path: Path) -> None:
    """Slowest relaxation time against wear ratio, and the first modes of the punch of most
    rings.
    """
    figure = new_figure(11, 4.2)
    left, right = figure.subplots(1, 2, sharex=True, sharey=True)
    for (count, values), line in zip(times.items(), LINES, strict=False):
        left.plot(
            WEAR_RATIOS,
            values[:, 0],
            color="black",
            linestyle=line,
            linewidth=1.1,
            label=f"$N$ = {count}",
        )
    values = times[max(times)]
    left.plot(WEAR_RATIOS, many_ring_times(values[:, 0].max()), **LIMIT, zorder=1)
    left.set_ylabel(r"relaxation time $\tau$ over $a/(E^* k_{slow} v_0)$")
    left.set_ylim(bottom=0)
    left.set_title("slowest mode", fontsize=9)
    left.legend(frameon=False, fontsize=8, ncols=2)
    right.plot(WEAR_RATIOS, values, color="black", linewidth=1.1)
    right.set_title(f"first {values.shape[1]} modes, $N$ = {max(times)}", fontsize=9)
    left.set_xscale("log")
    for axes in (left, right):
        axes.set_xlabel("wear ratio $k_2/k_1$")
    figure.suptitle(
        "How long running-in takes: relaxation times of alternating rings of equal width",
        fontsize=10,
    )
    figure.savefig(path)
