"""Results of another program beside ours, as few numbers that a hypothesis has to predict."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ....meshes.radial import Array, Indices
from ...problem.quantities import FIELDS
from ...sampling.norms import Results
from ...scene.scene import Scene

# means over the radius that a field gives at a time, at least and at most
FEWEST_PARTS, MOST_PARTS = 4, 8
# times that are looked at, evenly spread over those given
MOST_TIMES = 24
# part of a ring's width beside its edges, where pressures jump, and of the radius at the rim
BESIDE_EDGE, BESIDE_RIM = 0.15, 0.05
# part of its greatest value below which a worn height is too little to be compared
LITTLE_WORN = 0.02


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

    @cached_property
    def rows(self) -> Indices:
        """(S,) times that are looked at, counted among those given."""
        count = len(self.times)
        return np.unique(np.linspace(0, count - 1, min(count, MOST_TIMES)).round().astype(int))

    @cached_property
    def parts(self) -> Array:
        """(P, R) means over parts of the face, which are rings, halves of rings, or several rings.

        Radii beside ring edges count only where a part has no others.
        """
        edges = self.scene.problem.ring_edges * self.scene.problem.units.length
        rings = len(edges) - 1
        if rings < FEWEST_PARTS:
            pieces = -(-FEWEST_PARTS // rings)
            ends = np.linspace(edges[:-1], edges[1:], pieces, endpoint=False, axis=1).ravel()
        else:
            ends = edges[:-1][:: -(-rings // MOST_PARTS)]
        part = np.searchsorted(ends, self.radii, side="right") - 1
        ring = np.clip(np.searchsorted(edges, self.radii) - 1, 0, rings - 1)
        near = np.minimum(
            np.abs(self.radii - np.where(ring > 0, edges[ring], -np.inf)),
            np.abs(self.radii - np.where(ring < rings - 1, edges[ring + 1], np.inf)),
        )
        clear = near > BESIDE_EDGE * np.diff(edges)[ring]
        clear &= self.radii < edges[-1] * (1 - BESIDE_RIM)
        means = np.zeros((len(ends), len(self.radii)))
        for each in range(len(ends)):
            on = part == each
            on = on & clear if (on & clear).any() else on
            means[each, on] = 1 / max(1, on.sum())
        return means[means.any(axis=1)]

    @cached_property
    def names(self) -> tuple[str, ...]:
        """Quantities that both give."""
        return tuple(name for name in self.theirs if name in self.ours)

    @cached_property
    def fields(self) -> tuple[str, ...]:
        """Quantity of each of the K numbers that are compared at a time: a field has one a part."""
        count = {name: len(self.parts) if name in FIELDS else 1 for name in self.names}
        return tuple(name for name in self.names for _ in range(count[name]))

    @cached_property
    def members(self) -> Array:
        """(Q, K) whether a number is of a quantity."""
        return np.array([[name == other for other in self.fields] for name in self.names], float)

    @cached_property
    def observed(self) -> Array:
        """(S, K) theirs: means of fields over parts of the face, and other quantities.

        NaN where nothing is given. Where theirs gives a field at some radii of a part only, its
        mean is scaled by ours.
        """
        found = []
        for name in self.names:
            theirs, ours = (of[name][self.rows] for of in (self.theirs, self.ours))
            given = np.isfinite(theirs) & np.isfinite(ours)
            if name not in FIELDS:
                found.append(np.where(given, theirs, np.nan)[:, None])
                continue
            everywhere = np.isfinite(ours)
            with np.errstate(all="ignore"):
                means, of_these, of_all = (
                    (np.where(on, values, 0.0) @ self.parts.T) / (on @ self.parts.T)
                    for on, values in ((given, theirs), (given, ours), (everywhere, ours))
                )
                scale = np.clip(of_all / of_these, 0.5, 2.0)
            found.append(means * np.where(np.isfinite(scale), scale, 1.0))
        return np.concatenate(found, axis=1)

    @cached_property
    def expected(self) -> Array:
        """(S, K) ours: what would be observed without any error."""
        found = []
        for name in self.names:
            ours = self.ours[name][self.rows]
            if name in FIELDS:
                given = np.isfinite(ours)
                with np.errstate(invalid="ignore"):
                    ours = (np.where(given, ours, 0.0) @ self.parts.T) / (given @ self.parts.T)
            found.append(ours if ours.ndim == 2 else ours[:, None])
        return np.concatenate(found, axis=1)

    @cached_property
    def given(self) -> Array:
        """(S, K) whether theirs gives a number."""
        return np.isfinite(self.observed)

    def norms(self, values: Array) -> Array:
        """Return root mean squares (S, Q) of the numbers (S, K) of each quantity."""
        squares = np.where(self.given, values, 0.0) ** 2 @ self.members.T
        return np.asarray(np.sqrt(squares / np.maximum(self.given @ self.members.T, 1)))

    def gaps(self, predicted: Array) -> Array:
        """Return differences (S, K) of theirs to what a hypothesis predicts, relative to both.

        To the mean of both norms at each time, so that they are at most about 2; 0 where there is
        nothing to compare.
        """
        norm = (self._norms_of_theirs + self.norms(predicted)) / 2
        if "profile" in self.names:
            worn = norm[:, self.names.index("profile")]
            worn += LITTLE_WORN * worn.max(initial=0.0)
        norms = norm @ self.members
        gap = np.where(self.given, self.observed - predicted, 0.0)
        return np.divide(gap, norms, out=np.zeros_like(gap), where=norms > 0)

    @cached_property
    def _norms_of_theirs(self) -> Array:
        return self.norms(self.observed)
