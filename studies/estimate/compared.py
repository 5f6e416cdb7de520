"""Reduce the results of another program to the few numbers that explain its error.

Patterns in one column, of a mesh or of a column that is written wrongly, belong to single radii:
they are no parameters of a scene or of a reading, and are found here, too.
"""

from collections.abc import Iterator
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from ...meshes import Array, Indices
from ..crosscheck import FIELDS, Results, Scene
from .diagnosis import EXPLAINS, REDUCES, Diagnosis
from .measurement import Measurement

# quantities on which mistakes have a known effect
PRINTED = ("displacement", "profile", "indentation", "pressure", "normal_force")
# relative error that is assumed of another program if that of its mesh is not known
USUAL_ERROR = 0.03
# least number of parts of the face over which fields are averaged
MIN_PARTS = 4
# greatest number of times that are compared, evenly spread over those of the other program
MAX_TIMES = 24
# widths in which pressures are left out of the means: beside ring edges, where they jump, over the
# width of the ring; at the rim over the punch radius
EDGE_MARGIN, RIM_MARGIN = 0.15, 0.05
# least size of a worn height, over the greatest one: less wear is compared with this size
MIN_WORN_PART = 0.02
# radius, over the punch radius, beyond which errors count as errors at the rim
RIM = 0.8
PATTERNS = {
    "coarse rim": (
        "errors of pressure of about {:.2g} at the rim, which decrease as the rim wears",
        "halve the element size at the rim: the first pressures change most",
    ),
    "checkerboard": (
        "errors of pressure of about {:.2g} whose sign alternates from radius to radius",
        "average neighbouring pressures: the errors disappear, because the pressure space is too "
        "rich for the displacements",
    ),
}
"""What each pattern looks like, with the size of the errors, and its remedy."""


@dataclass(frozen=True, eq=False)
class Comparison:
    """Results of another program and ours, in the units of the scene.

    S is the number of times that are compared, P the number of parts of the face.

    Parameters
    ----------
    times : (T,) times of the other program
    radii : (R,) radii of the other program
    theirs, ours : pressure, displacement, profile (T, R), indentation, normal_force (T,), NaN or
        absent where they are unknown
    scene : the scene that both have solved
    mesh_results : results of elements with nodes at their radii, where these are known
    """

    times: Array
    radii: Array
    theirs: Results
    ours: Results
    scene: Scene
    mesh_results: Results = field(default_factory=dict)

    @cached_property
    def time_rows(self) -> Indices:
        """(S,) indices of the compared times among all times."""
        count = len(self.times)
        return np.unique(np.linspace(0, count - 1, min(count, MAX_TIMES)).round().astype(int))

    @cached_property
    def pressures(self) -> tuple[Array, Array, Array] | None:
        """Their times (T,), radii (R,) and pressures (T, R), non-dimensional; or None."""
        if "pressure" not in self.theirs:
            return None
        units = self.scene.problem.units
        pressures = self.theirs["pressure"] / units.pressure
        return self.times / units.time, self.radii / units.length, pressures

    @cached_property
    def part_means(self) -> Array:
        """(P, R) weights of the means over P parts of the face: rings, or pieces of rings.

        Radii beside ring edges and at the rim count only in parts that have no other radii.
        """
        edges = self.scene.problem.ring_edges * self.scene.problem.units.length
        rings = len(edges) - 1
        pieces = -(-MIN_PARTS // rings)
        starts = np.linspace(edges[:-1], edges[1:], pieces, endpoint=False, axis=1).ravel()
        part = np.searchsorted(starts, self.radii, side="right") - 1
        ring = np.clip(np.searchsorted(edges, self.radii) - 1, 0, rings - 1)
        distances = np.abs(self.radii - edges[1:-1, None])
        clear = (distances > EDGE_MARGIN * np.diff(edges)[ring]).all(axis=0)
        clear &= self.radii < edges[-1] * (1 - RIM_MARGIN)
        used = clear | ~np.isin(part, part[clear])
        members = used & (part == np.arange(len(starts))[:, None])
        members = members[members.any(axis=1)]
        return members / members.sum(axis=1, keepdims=True)

    @cached_property
    def quantities(self) -> tuple[str, ...]:
        """The quantities that both programs have."""
        return tuple(name for name in self.theirs if name in self.ours)

    def observed(self, name: str, results: Results) -> Array:
        """Return numbers (S, P) or (S, 1) of some results, NaN where there are none.

        If they have a field at some radii of a part only, the mean is scaled by the ratio of our
        means over all and over these radii.
        """
        theirs, ours = (each[name][self.time_rows] for each in (results, self.ours))
        common = np.isfinite(theirs) & np.isfinite(ours)
        if name not in FIELDS:
            return np.where(common, theirs, np.nan)[:, None]
        with np.errstate(all="ignore"):
            means, our_means_at_theirs, our_means = (
                (np.where(mask, values, 0.0) @ self.part_means.T) / (mask @ self.part_means.T)
                for mask, values in ((common, theirs), (common, ours), (np.isfinite(ours), ours))
            )
            scale = np.clip(our_means / our_means_at_theirs, 0.5, 2.0)
        return means * np.where(np.isfinite(scale), scale, 1.0)

    def known(self) -> tuple[Array, ...]:
        """Return our numbers (n,) of each measurement, NaN where we have none."""
        return tuple(self.observed(name, self.ours).ravel() for name in self.quantities)

    def mesh_errors(self) -> tuple[Array, ...]:
        """Return the relative errors (n,) of a linear mesh in each measurement; 0 where unknown."""
        if not self.mesh_results:
            return ()
        on_mesh = self.ours | self.mesh_results
        return tuple(
            relative(self.observed(name, on_mesh).ravel(), known)
            for name, known in zip(self.quantities, self.known(), strict=True)
        )

    def measurements(self, noise: float, bias: float) -> tuple[Measurement, ...]:
        """Return the numbers as measurements.

        Parameters
        ----------
        noise : assumed error of a number, over the root mean square of its quantity at its time
        bias : assumed relative error that all numbers of a quantity have in common
        """
        measurements = []
        for name in self.quantities:
            values, times = self.observed(name, self.theirs), self.times[self.time_rows]
            present = np.isfinite(values)
            counts = np.maximum(present.sum(axis=1, keepdims=True), 1)
            squares = np.sum(np.where(present, values, 0.0) ** 2, axis=1, keepdims=True)
            sizes = np.sqrt(squares / counts)
            if name == "profile":
                sizes = np.maximum(sizes, MIN_WORN_PART * sizes.max(initial=0.0))
            deviations = np.where(present & (sizes > 0), noise * sizes, np.inf)
            means = self.part_means if name in FIELDS else None
            measurements.append(
                Measurement(
                    name,
                    name,
                    times,
                    np.where(present, values, 0.0).ravel(),
                    deviations.ravel(),
                    False,
                    self.radii if name in FIELDS else None,
                    None,
                    means,
                    bias,
                )
            )
        return tuple(measurements)


def relative(theirs: Array, ours: Array) -> Array:
    """Return relative differences, 0 where they are not finite: without a value, or over zero."""
    with np.errstate(all="ignore"):
        differences = theirs / ours - 1
    return np.where(np.isfinite(differences), differences, 0.0)


def patterns(errors: Array, radii: Array, radius: float) -> Iterator[tuple[str, float, float]]:
    """Yield each pattern: its name, the size of the errors, and the part of them that it explains.

    Parameters
    ----------
    errors : (T, R) relative errors of the pressure, 0 where none is known
    radii : (R,) in the same unit as `radius`
    radius : of the punch
    """
    size = float(np.linalg.norm(errors) / np.sqrt(errors.size or 1))
    error = errors / (np.linalg.norm(errors) or 1.0)
    early = error[: (len(error) + 1) // 2, radii > RIM * radius]
    yield "coarse rim", size, float(1 - np.sqrt(abs(1 - np.sum(early**2))))
    yield "checkerboard", size, float(-np.sum(error[:, 1:] * error[:, :-1]))


def in_columns(comparison: Comparison) -> Iterator[tuple[str, Diagnosis]]:
    """Yield each column of fields, and a way in which it may be written wrongly: what remains then.

    A column may be shifted by a node, or have the wrong sign on one ring.
    """
    edges = comparison.scene.problem.ring_edges * comparison.scene.problem.units.length
    ring = np.clip(np.searchsorted(edges, comparison.radii) - 1, 0, len(edges) - 2)
    # pressures at the rim are those of the mesh
    inside = comparison.radii < edges[-1] * (1 - RIM_MARGIN)
    for name in comparison.quantities:
        if name not in FIELDS or len(ring) < 2:
            continue
        theirs, words = comparison.theirs[name], name.replace("_", " ")
        # with the errors of their mesh, where these are known
        ours = comparison.mesh_results.get(name, comparison.ours[name])
        ways = [
            (
                "shifted column",
                shift,
                f"a column {name} that is shifted {side} by one node",
                f"compare the rows of radius and {words}: do both begin at the same node?",
                pd.DataFrame(ours).shift(shift, axis="columns").to_numpy(),
            )
            for shift, side in ((1, "outward"), (-1, "inward"))
        ]
        ways += [
            (
                f"sign of the {words}",
                number + 1,
                f"an opposite sign of {words} on ring {number + 1}",
                "compare the sign of this column on this ring with that on the others",
                np.where(ring == number, -ours, ours),
            )
            for number in range(len(edges) - 1)
        ]
        before = relative_size(theirs, ours, inside)
        for mistake, size, looks_like, confirm, wrong in ways:
            remaining = relative_size(theirs, wrong, inside)
            judgement = EXPLAINS if remaining <= USUAL_ERROR else REDUCES
            yield (
                name,
                Diagnosis(mistake, size, judgement, looks_like, before, remaining, confirm),
            )


def relative_size(theirs: Array, ours: Array, inside: NDArray[np.bool_]) -> float:
    """Return the mean difference of two fields (T, R) at some radii (R,), over their mean size."""
    both = np.isfinite(theirs) & np.isfinite(ours) & inside
    size = np.abs(ours[both]).sum()
    return float(np.abs(theirs - ours)[both].sum() / size) if size else 0.0
