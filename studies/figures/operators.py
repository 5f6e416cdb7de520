"""Draw the differences of two methods as operators, for every pressure instead of one scene."""

from matplotlib.figure import Figure

from ..crosscheck import Result
from .style import PAGE, complete, curve, new_panels, set_logarithmic
from .ticks import one_digit


def draw_operators(result: Result) -> Figure:
    """Draw the relative difference of two methods against the wavelength of the pressure.

    Wavelengths that the elements do not resolve are shaded.
    """
    figure, panels = new_panels(PAGE, 3.4)
    axes = panels[0, 0]
    radius = result.scene.punch.radius
    for number, pair in enumerate(result.operators):
        look = curve(number) | {"linestyle": "", "markersize": 2.5, "markeredgewidth": 0.6}
        names = f"{pair.methods[0].upper()} minus {pair.methods[1].upper()}"
        label = f"{names}, one mark per mode"
        axes.plot(pair.wavelengths / radius, pair.differences, **look, label=label)
        label = f"{names}, all steady states: {one_digit(pair.rings)}"
        axes.axhline(pair.rings, linewidth=0.8, color=look["color"], linestyle="--", label=label)
    shortest = 2 * float(result.scene.problem.rings.widths.min())
    axes.axvline(
        shortest, color="0.4", linestyle=":", label="twice the width of the narrowest ring"
    )
    set_logarithmic(axes, "x", "y", most=8)
    finest = min(pair.shortest_resolved for pair in result.operators) / radius
    left, unresolved = axes.get_xlim()[0], "waves finer than the elements"
    axes.axvspan(left, finest, color="0.88", linewidth=0, zorder=0, label=unresolved)
    axes.set_xlim(left=left)
    axes.set_xlabel("wavelength of the pressure over the punch radius a")
    axes.set_ylabel("relative difference of energies")
    return complete(
        figure,
        (result.scene.title, "the methods compared for every pressure"),
        [axes],
        "Each method computes the elastic energy of the same pressures. The largest elements do "
        "not resolve the waves in the shaded part:\n"
        "differences there, up to 100 %, are irrelevant for the answer, which consists of the long "
        "waves at the right.",
    )
