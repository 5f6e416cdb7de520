"""How long running-in takes: relaxation times of alternating rings over wear ratio and number of rings.

Many rings, seen from far, wear as one material whose coefficient is the mean of ``1/k`` over the width, inverted
(Eq. 26 on the scale of a ring): their slowest relaxation time is that of a homogeneous punch, times this mean.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from ringwear.mdr.energy import compliance
from ringwear.meshes.radial import Array
from ringwear.studies.methods.radial import mdr_settings, mdr_space
from ringwear.studies.paper.figures import canvas
from ringwear.studies.paper.gradient_figures import DASHES
from ringwear.studies.paper.gradients import odd_and_even
from ringwear.studies.paper.running_in import paper_punch
from ringwear.studies.problem.scene import Scene
from ringwear.studies.progress import Report
from ringwear.studies.wear.archard import Wear

RINGS = (2, 4, 5, 8, 16)
QUICK_RINGS = (2, 5)
WEAR_RATIOS = np.array([float(f"{10 ** (i / 4 - 4):.12g}") for i in range(33)])
MODES = 5
RTOL = 1e-3  # measured: the slowest to 1e-7, the fifth to 3e-5


@dataclass(frozen=True, eq=False)
class Spectrum:
    """Relaxation times in units of ``a / (E* k_slow v0)``, `k_slow` the smaller wear coefficient.

    Parameters
    ----------
    times : (M, modes) for each number of rings, slowest first
    homogeneous : slowest relaxation time of the homogeneous punch
    """

    times: dict[int, Array]
    homogeneous: float

    def many_rings(self, wear_ratios: Array) -> Array:
        """(M,) slowest relaxation time in the limit of many rings of equal width."""
        slow = np.minimum(1, wear_ratios)
        return self.homogeneous * slow * (1 + 1 / wear_ratios) / 2

    def rows(self) -> list[tuple[int, float, int, float, float]]:
        """Rings, wear ratio, mode, and the time in units of the slower and of the first material's wear."""
        return [
            (rings, float(ratio), mode + 1, float(time), float(time / min(1.0, ratio)))
            for rings, values in self.times.items()
            for ratio, row in zip(WEAR_RATIOS, values, strict=True)
            for mode, time in enumerate(row)
        ]


def spectrum(scene: Scene, rings: tuple[int, ...], report: Report, rtol: float = RTOL) -> Spectrum:
    """Relaxation times by MDR: one compliance for each number of rings, one eigenproblem for each wear ratio."""
    times = {}
    coarse = scene.changed(accuracy__rtol=rtol)
    for count in (1, *rings):
        report(f"    mdr  relaxation of {count} rings ...")
        natural = paper_punch(coarse, count).natural
        half_space = compliance(mdr_space(natural, **mdr_settings(natural)))
        ratios = WEAR_RATIOS if count > 1 else np.ones(1)
        wears = [odd_and_even(count) @ [1.0, ratio] / min(1.0, ratio) for ratio in ratios]
        times[count] = np.array([Wear(half_space, wear).relaxation_times[:MODES] for wear in wears])
    return Spectrum({count: times[count] for count in rings}, float(times[1][0, 0]))


def draw_spectrum(found: Spectrum, path: Path) -> None:
    """Slowest relaxation time against wear ratio, and the first modes of the punch of most rings."""
    figure = canvas(11, 4.2)
    left, right = figure.subplots(1, 2)
    for (rings, values), dashes in zip(found.times.items(), DASHES, strict=False):
        left.plot(WEAR_RATIOS, values[:, 0], linestyle=dashes, color="black", linewidth=1.2, label=f"$N$ = {rings}")
    left.plot(WEAR_RATIOS, found.many_rings(WEAR_RATIOS), color="black", linewidth=2.6, alpha=0.35, label="$N \\to \\infty$")
    left.set_ylim(bottom=0)
    left.set_title("slowest mode", fontsize=9)
    left.legend(frameon=False, fontsize=8, ncols=2)
    rings, values = list(found.times.items())[-1]
    for mode in range(values.shape[1]):
        right.plot(WEAR_RATIOS, values[:, mode], color=str(0.75 * mode / MODES), linewidth=1.2)
        right.annotate(f"{mode + 1}", (WEAR_RATIOS[-1], values[-1, mode]), (3, -3), textcoords="offset points", fontsize=7)
    right.set_yscale("log")
    for part in (right.yaxis.set_major_formatter, right.yaxis.set_minor_formatter):
        part(lambda value, _: f"{value:g}")
    right.set_title(f"first {values.shape[1]} modes, $N$ = {rings}", fontsize=9)
    for axes in (left, right):
        axes.set_xscale("log")
        axes.set_xlabel("wear ratio $k_2/k_1$")
        axes.set_ylabel(r"relaxation time $\tau$ over $a/(E^* k_{slow} v_0)$")
    figure.suptitle("How long running-in takes: relaxation times of alternating rings of equal width", fontsize=10)
    figure.savefig(path)
