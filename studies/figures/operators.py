"""How far two methods differ for every pressure, not for one scene."""

from collections.abc import Iterable
from pathlib import Path
from typing import Any

import numpy as np

from ..crosscheck.operators import OperatorDifference
from ..problem.scene import Scene
from .style import GREYS, Margins, footing, heading, page, powers, save, styled, titled

LEAST = 1e-16  # a difference drawn where there is none


@styled
def draw_operators(scene: Scene, operators: Iterable[OperatorDifference], path: Path) -> None:
    """Relative difference of two methods against the wavelength of the pressure."""
    figure, panels = page(1, 1, 2.4, Margins(left=0.6, top=0.3, bottom=0.68))
    axes = panels[0, 0]
    for pair, marker, color in zip(operators, "ox^s", GREYS, strict=False):
        label = f"{pair.methods[0].upper()} from {pair.methods[1].upper()}, each mark a mode"
        look: dict[str, Any] = {
            "markersize": 2.5,
            "markerfacecolor": "none",
            "markeredgewidth": 0.6,
            "color": color,
        }
        shown = np.maximum(pair.differences, LEAST)
        axes.loglog(pair.wavelengths / scene.punch.radius, shown, marker, label=label, **look)
        every = f"all steady states: {pair.rings:.0e}"
        axes.axhline(
            max(pair.rings, LEAST), linewidth=0.8, color=color, linestyle="--", label=every
        )
    powers(axes.xaxis, axes.yaxis)
    shortest = 2 * float(scene.problem.rings.widths.min())
    axes.axvline(
        shortest, linewidth=0.8, color="0.4", linestyle=":", label="two of the narrowest rings"
    )
    axes.set_xlabel("wavelength of the pressure over the punch radius $a$")
    axes.set_ylabel("relative difference of energies")
    note = (
        "Of the same pressure both methods give the elastic energy. Waves shorter than the "
        "elements are beyond either."
    )
    footing(figure, [axes], note)
    heading(figure, titled(scene.title, "the methods compared for every pressure"))
    save(figure, path)
