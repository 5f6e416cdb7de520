"""What the error of another program's results looks like.

Faults that people make are put into our own results. The part of their error that a fault explains
is the confidence in it.
"""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace
from itertools import chain
from typing import Any

import numpy as np
from scipy.interpolate import interp1d

from ...meshes.radial import Array
from ..methods.mdr import METHOD
from ..methods.norms import Results
from ..problem.quantities import QUANTITIES
from ..progress import Stages
from .comparison import Comparison


@dataclass(frozen=True)
class Diagnosis:
    """What an error looks like.

    Parameters
    ----------
    name : of the fault
    size : its number
    confidence : up to 1: the part of the error that the fault explains
    words : what the results look like, with the number
    confirm : what would confirm it
    """

    name: str
    size: float
    confidence: float
    words: str
    confirm: str


def diagnose(comparison: Comparison, least: float = 0.6) -> list[Diagnosis]:
    """Return what the error of their results looks like, the most confident first.

    Parameters
    ----------
    comparison : Comparison
    least : float
        Confidence below which nothing is said.

    Returns
    -------
    list of Diagnosis
        Empty if nothing fits, or if the error is below the accuracy that the scene asks for.

    Notes
    -----
    A fault that the scene cannot have, such as another radius of a punch with a profile that is
    given up to the rim, is passed over.
    """
    case = Case(**vars(comparison))
    if np.linalg.norm(case.relative(case.theirs, case.ours)) <= case.scene.accuracy.rtol:
        return []
    faults = chain(case.of_model(), case.of_numbers(), case.of_history(), case.of_pressure())
    likely = [fault for fault in faults if fault.confidence > least]
    return sorted(likely, key=lambda fault: -fault.confidence)


class Case(Comparison):
    """A comparison whose error faults may explain."""

    def relative(self, results: Results, names: Iterable[str]) -> Array:
        """Return relative differences of results to ours in one row, 0 where there is none.

        The squares of each quantity sum to their mean.
        """
        with np.errstate(all="ignore"):
            parts = [(results[name] / self.ours[name] - 1).ravel() for name in names]
        row = np.hstack([part / np.sqrt(part.size) for part in parts])
        return np.where(np.isfinite(row), row, 0.0)

    def fit(self, predicted: Results) -> tuple[float, float]:
        """Return how large a fault is, over that predicted, and the part of the error it explains.

        Only of the quantities that are predicted.
        """
        error = self.relative(self.theirs, predicted)
        change = self.relative(predicted, predicted) * (error != 0)
        size = change @ error / (change @ change or 1.0)
        whole, left = np.linalg.norm(error), np.linalg.norm(error - size * change)
        return size, float((whole - left) / (whole or 1.0))

    def solve(self, **changes: Any) -> Results:
        """Return our results, to a thousandth, of a problem that is changed."""
        problem = replace(self.scene.problem, rtol=1e-3, **changes)
        units = problem.units
        radii = np.minimum(self.radii / units.length, 1) if len(self.radii) else None
        problem = replace(problem, times=self.times / units.time, output_radii=radii)
        results = METHOD.solve(problem, Stages("mdr")).results
        names = self.ours.keys() & results.keys()
        return {name: results[name] * getattr(units, QUANTITIES[name].unit) for name in names}

    def of_change(
        self, name: str, size: float, words: str, confirm: str, **changes: Any
    ) -> Diagnosis:
        """Return the fault of a problem that is changed; a fraction of it explains nothing."""
        times, part = self.fit(self.solve(**changes))
        return Diagnosis(name, size, part * (abs(times - 1) < 0.1), words, confirm)

    def of_model(self) -> Iterator[Diagnosis]:
        """Return faults of what was modelled."""
        rings, units = self.scene.problem.rings, self.scene.problem.units
        wear, plane = rings.wear_coefficients, 1 - self.scene.problem.poisson_ratio**2
        yield self.of_change(
            "swapped materials",
            1.0,
            "the wear coefficients of two materials are swapped",
            "late pressures are greatest where wear is least",
            rings=rings._replace(wear_coefficients=wear.min() + wear.max() - wear),
        )
        for size in (2.0, 0.5):
            yield self.of_change(
                "radius for diameter",
                size,
                f"a punch of {size} times the radius: a diameter for a radius, or the reverse",
                "the radius in the model where pressures end",
                units=replace(units, length=size * units.length, time=size * units.time),
            )
        for size in (plane, 1 / plane):
            yield self.of_change(
                "Poisson's ratio",
                size,
                f"a half-space {size:.4g} times as stiff: E for E/(1 - nu^2), or the reverse",
                "with a Poisson's ratio of 0 the error is gone",
                units=replace(units, modulus=size * units.modulus, time=units.time / size),
            )

    def of_numbers(self) -> Iterator[Diagnosis]:
        """Return the fault of numbers that are off by factors, each quantity by its own."""
        ratios = {name: 1 + self.fit({name: 2 * values})[0] for name, values in self.ours.items()}
        size = max(ratios.values(), key=lambda ratio: abs(np.log(abs(ratio) or 1.0)))
        known = dict.fromkeys((1e3, 1e6, 1e9), "units") | {
            2 * np.pi: "2 pi missing",
            1 - self.scene.problem.poisson_ratio**2: "Poisson's ratio",
        }
        names = [
            name
            for factor, name in known.items()
            if np.isclose(abs(size), (factor, 1 / factor), 0.01).any()
        ]
        yield Diagnosis(
            [*names, "constant factor"][0],
            size,
            self.fit({name: self.ours[name] * ratios[name] for name in ratios})[1],
            "over ours, at all times and radii: "
            + ", ".join(f"{name} {ratio:.4g}" for name, ratio in ratios.items()),
            "units; the sum of 2 pi r p dr beside the load; results with a Poisson's ratio of 0",
        )

    def of_history(self) -> Iterator[Diagnosis]:
        """Return faults that displacements show over time."""
        names = self.ours.keys() & {"indentation", "displacement"}
        depths = {name: self.ours[name] for name in names}
        if len(self.times) < 2 or not depths:
            return
        problem, last = self.scene.problem, float(self.times[-1])
        # relative error of d0 of a clamped half-space over a/R (`study truncation`)
        clamped = np.interp(problem.poisson_ratio, [0, 0.3, 0.45, 0.5], [0.94, 1.09, 1.51, 1.91])
        offset = clamped * problem.units.displacement / 2
        size, part = self.fit({name: values - offset for name, values in depths.items()})
        reach = 1 / (size or 1.0)
        yield Diagnosis(
            "truncated half-space",
            reach,
            part * (reach > 2),
            f"displacements too low by one length: a half-space cut off at about {reach:.3g} a",
            "a half-space twice as large has half the error",
        )
        # steps end at the times that are given
        step, size, longest = last, 0.005, np.diff(self.times).max()
        for _ in range(4):
            step = np.clip(abs(step * size), longest / 1000, longest)
            stepped = self.solve(march="implicit", step=step / problem.units.time)
            size, part = self.fit({name: stepped[name] for name in depths})
        yield Diagnosis(
            "first-order time step",
            step * size,
            part,
            f"steps of first order, of about {step * size:.3g} (below 0: explicit ones)",
            "half the time step has half the error",
        )
        histories = {name: interp1d(self.times, depths[name], axis=0) for name in depths}
        fits = []
        for late in np.geomspace(last / 300, last, 150):
            times = np.maximum(self.times - late, self.times[0])
            fits.append((self.fit({name: histories[name](times) for name in depths})[1], late))
        part, late = max(fits)
        yield Diagnosis(
            "late start",
            late,
            part,
            f"a history that starts about {late:.3g} too late",
            "with this taken off the times the error is gone",
        )

    def of_pressure(self) -> Iterator[Diagnosis]:
        """Return faults of the mesh, by the place and the sign of errors of pressure."""
        if "pressure" not in self.ours:
            return
        error = self.relative(self.theirs, ["pressure"]).reshape(self.ours["pressure"].shape)
        size = float(np.linalg.norm(error))
        error /= size or 1.0
        early = error[: (len(error) + 1) // 2, self.radii > 0.8 * self.scene.punch.radius]
        yield Diagnosis(
            "coarse rim",
            size,
            1 - np.sqrt(abs(1 - np.sum(early**2))),
            f"errors of pressure, of {size:.2g}, that are at the rim and fall as it wears",
            "half the element size at the rim changes the first pressures most",
        )
        yield Diagnosis(
            "checkerboard",
            size,
            -np.sum(error[:, 1:] * error[:, :-1]),
            f"errors of pressure, of {size:.2g}, that change their sign from radius to radius",
            "means of neighbours lose it: pressures are too rich for the displacements",
        )
