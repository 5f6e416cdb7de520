"""How far two methods differ for every pressure, not for one scene."""

import numpy as np
from matplotlib.figure import Figure

from ..crosscheck.dataset import Result
from .style import GREYS, PAGE, complete, new_panels, set_logarithmic


def draw_operators(result: Result) -> Figure:
    """Draw the relative difference of two methods against the wavelength of the pressure."""
    figure, panels = new_panels(PAGE, 3.4)
    axes, least = panels[0, 0], 1e-16
    for pair, marker, color in zip(result.operators, "ox^s", GREYS, strict=False):
        axes.plot(
            pair.wavelengths / result.scene.punch.radius,
            np.maximum(pair.differences, least),
            marker,
            label=f"{pair.methods[0].upper()} from {pair.methods[1].upper()}, each mark a mode",
            markersize=2.5,
            markerfacecolor="none",
            markeredgewidth=0.6,
            color=color,
        )
        label = f"all steady states: {pair.rings:.0e}"
        axes.axhline(
            max(pair.rings, least), linewidth=0.8, color=color, linestyle="--", label=label
        )
    shortest = 2 * float(result.scene.problem.rings.widths.min())
    axes.axvline(shortest, color="0.4", linestyle=":", label="two of the narrowest rings")
    set_logarithmic(axes, "x", "y")
    axes.set_xlabel("wavelength of the pressure over the punch radius a")
    axes.set_ylabel("relative difference of energies")
    return complete(
        figure,
        (result.scene.title, "the methods compared for every pressure"),
        [axes],
        "Of the same pressure both methods give the elastic energy. Waves shorter than the "
        "elements are beyond either.",
    )
