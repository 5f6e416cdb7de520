"""What the error of another program's results looks like.

Faults that people make are put into our own results. The part of their error that a fault explains
is the confidence in it.
"""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace
from itertools import chain
from typing import Any

import numpy as np

from ...meshes.radial import Array
from ..methods.base import method
from ..problem.quantities import QUANTITIES
from ..progress import Stages
from ..sampling.norms import Results
from ..scene.scene import Scene


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


@dataclass(frozen=True, eq=False)
class Comparison:
    """Results of another program and ours, in the units of the scene: faults may explain the error.

    Parameters
    ----------
    times : (T,) that it gives
    radii : (R,) that it gives
    theirs, ours : pressure, displacement, profile (T, R), indentation, normal_force (T,), NaN or
        absent where they are not given
    scene : what both are of
    """

    times: Array
    radii: Array
    theirs: Results
    ours: Results
    scene: Scene

    def relative(self, results: Results, names: Iterable[str]) -> Array:
        """Return relative differences of results to ours in one row, 0 where there is none.

        The squares of each quantity sum to their mean.
        """
        with np.errstate(all="ignore"):
            parts = [(results[name] / self.ours[name] - 1).ravel() for name in names]
        row = np.hstack([[], *(part / np.sqrt(part.size) for part in parts)])
        return np.where(np.isfinite(row), row, 0.0)

    def fit(self, predicted: Results) -> tuple[float, float]:
        """Return how large a fault is, over that predicted, and the part of the error it explains.

        Only of the quantities that are predicted.
        """
        error = self.relative(self.theirs, predicted)
        change = self.relative(predicted, predicted) * (error != 0)
        size = change @ error / (change @ change or 1.0)
        whole, left = np.linalg.norm(error), np.linalg.norm(error - size * change)
        part = float((whole - left) / (whole or 1.0))
        # one number is explained by anything that can be fitted
        return size, part * (1 - 1 / (np.count_nonzero(error) or 1))

    def solve(self, **changes: Any) -> Results:
        """Return our results, to a hundredth, of a problem that is changed."""
        problem = replace(self.scene.problem, rtol=1e-2, steady=False, **changes)
        units = problem.units
        radii = np.minimum(self.radii / units.length, 1) if len(self.radii) else None
        problem = replace(problem, times=self.times / units.time, output_radii=radii)
        results = method("mdr").solve(problem, Stages("mdr")).results
        names = self.ours.keys() & results.keys()
        return {name: results[name] * getattr(units, QUANTITIES[name].unit) for name in names}

    def explain(self, predicted: Results) -> float:
        """Return the part of the error that a fault explains, which is there wholly or not."""
        size, part = self.fit(predicted)
        return part * (abs(size - 1) < 0.1)

    def of_model(self) -> Iterator[Diagnosis]:
        """Return faults of what was modelled."""
        rings, units = self.scene.problem.rings, self.scene.problem.units
        wear, plane = rings.wear_coefficients, 1 - self.scene.problem.poisson_ratio**2
        swapped = rings._replace(wear_coefficients=wear.min() + wear.max() - wear)
        yield Diagnosis(
            "swapped materials",
            1.0,
            self.explain(self.solve(rings=swapped)),
            "the wear coefficients of two materials are swapped",
            "late pressures are greatest where wear is least",
        )
        for size in (2.0, 0.5):
            wide = replace(units, length=size * units.length, time=size * units.time)
            yield Diagnosis(
                "radius for diameter",
                size,
                self.explain(self.solve(units=wide)),
                f"a punch of {size} times the radius: a diameter for a radius, or the reverse",
                "the radius in the model where pressures end",
            )
        for size in (plane, 1 / plane):
            stiff = replace(units, modulus=size * units.modulus, time=units.time / size)
            yield Diagnosis(
                "Poisson's ratio",
                size,
                self.explain(self.solve(units=stiff)),
                f"a half-space {size:.4g} times as stiff: E for E/(1 - nu^2), or the reverse",
                "with a Poisson's ratio of 0 the error is gone",
            )
        ratios = {name: 1 + self.fit({name: 2 * values})[0] for name, values in self.ours.items()}
        size = max(ratios.values(), key=lambda ratio: abs(np.log(abs(ratio) or 1.0)))
        labels = {1e3: "units", 1e6: "units", 2 * np.pi: "2 pi missing", plane: "Poisson's ratio"}
        names = [labels[of] for of in labels if np.isclose(abs(size), (of, 1 / of), 0.01, 0).any()]
        factors = ", ".join(f"{name} {ratio:.4g}" for name, ratio in ratios.items())
        yield Diagnosis(
            [*names, "constant factor"][0],
            size,
            self.explain({name: self.ours[name] * ratios[name] for name in ratios}),
            f"over ours, at all times and radii: {factors}",
            "units; the sum of 2 pi r p dr beside the load; results with a Poisson's ratio of 0",
        )

    def of_history(self) -> Iterator[Diagnosis]:
        """Return faults that displacements show over time."""
        names = self.ours.keys() & {"indentation", "displacement"}
        depths = {name: self.ours[name] for name in names}
        if len(self.times) < 2 or not depths:
            return
        from scipy.interpolate import interp1d  # runs without results of others load this file, too

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
        # equal steps end at the times that are given
        step, size, longest = last, 0.005, np.diff(self.times).max()
        for _ in range(4):
            step = longest / np.clip(np.round(longest / abs(step * size)), 1, 1000)
            stepped = self.solve(march="implicit", step=step / problem.units.time)
            size, part = self.fit({name: stepped[name] for name in depths})
            if part < 0.1:
                break
        yield Diagnosis(
            "first-order time step",
            step * size,
            part,
            f"steps of first order, of about {step * size:.3g} (below 0: explicit ones)",
            "half the time step has half the error",
        )
        histories = {name: interp1d(self.times, depths[name], axis=0) for name in depths}
        parts = {}
        for late in np.geomspace(last / 300, last, 150):
            times = np.maximum(self.times - late, self.times[0])
            parts[late] = self.explain({name: histories[name](times) for name in depths})
        late = max(parts, key=lambda late: parts[late])
        yield Diagnosis(
            "late start",
            late,
            parts[late],
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


def diagnose(comparison: Comparison) -> list[Diagnosis]:
    """Return what the error of their results looks like, the most confident first.

    Returns
    -------
    list of Diagnosis
        Empty if nothing explains most of the error, or if this is below the accuracy that the scene
        asks for.

    Notes
    -----
    Radius and modulus are changed by their units, which is exact of flat punches under one load;
    of others these two faults may stay unnamed.
    """
    error = comparison.relative(comparison.theirs, comparison.ours)
    if np.linalg.norm(error) <= comparison.scene.accuracy.rtol:
        return []
    faults = chain(comparison.of_model(), comparison.of_history(), comparison.of_pressure())
    likely = [fault for fault in faults if fault.confidence > 0.7]
    return sorted(likely, key=lambda fault: -fault.confidence)
