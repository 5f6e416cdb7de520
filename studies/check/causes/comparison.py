"""Results of another program and ours, reduced to the few numbers that a hypothesis predicts."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ....meshes import Array, Indices
from ...crosscheck import FIELDS, Results, Scene

# least and greatest number of parts of the face over which fields are averaged
MIN_PARTS, MAX_PARTS = 4, 8
# greatest number of times that are compared, evenly spread over those of the other program
MAX_TIMES = 24
# widths in which pressures are left out of the means: beside ring edges, where they jump, over the
# width of the ring; at the rim over the punch radius
EDGE_MARGIN, RIM_MARGIN = 0.15, 0.05
# part of the greatest norm of the worn height that is added to all of its norms, so that little
# wear counts little
MIN_WORN_PART = 0.02


@dataclass(frozen=True, eq=False)
class Comparison:
    """Results of another program and ours, in the units of the scene.

    S is the number of times that are compared, K the number of numbers that are compared at each
    time, Q the number of quantities.

    Parameters
    ----------
    times : (T,) times of the other program
    radii : (R,) radii of the other program
    theirs, ours : pressure, displacement, profile (T, R), indentation, normal_force (T,), NaN or
        absent where they are unknown
    scene : the scene that both have solved
    """

    times: Array
    radii: Array
    theirs: Results
    ours: Results
    scene: Scene

    @cached_property
    def time_rows(self) -> Indices:
        """(S,) indices of the compared times among all times."""
        count = len(self.times)
        return np.unique(np.linspace(0, count - 1, min(count, MAX_TIMES)).round().astype(int))

    @cached_property
    def part_means(self) -> Array:
        """(P, R) weights of the means over P parts of the face: rings, pieces of rings, or groups.

        Radii beside ring edges and at the rim count only in parts that have no other radii.
        """
        edges = self.scene.problem.ring_edges * self.scene.problem.units.length
        rings = len(edges) - 1
        if rings < MIN_PARTS:
            pieces = -(-MIN_PARTS // rings)
            starts = np.linspace(edges[:-1], edges[1:], pieces, endpoint=False, axis=1).ravel()
        else:
            starts = edges[:-1][:: -(-rings // MAX_PARTS)]
        part_of_radius = np.searchsorted(starts, self.radii, side="right") - 1
        ring = np.clip(np.searchsorted(edges, self.radii) - 1, 0, rings - 1)
        edge_distance = np.minimum(
            np.abs(self.radii - np.where(ring > 0, edges[ring], -np.inf)),
            np.abs(self.radii - np.where(ring < rings - 1, edges[ring + 1], np.inf)),
        )
        clear = edge_distance > EDGE_MARGIN * np.diff(edges)[ring]
        clear &= self.radii < edges[-1] * (1 - RIM_MARGIN)
        means = np.zeros((len(starts), len(self.radii)))
        for part in range(len(starts)):
            on_part = part_of_radius == part
            on_part = on_part & clear if (on_part & clear).any() else on_part
            means[part, on_part] = 1 / max(1, on_part.sum())
        return means[means.any(axis=1)]

    @cached_property
    def quantities(self) -> tuple[str, ...]:
        """The Q quantities that both programs have."""
        return tuple(name for name in self.theirs if name in self.ours)

    @cached_property
    def column_names(self) -> tuple[str, ...]:
        """The quantity of each of the K numbers: a field has one number for each part."""
        count = {name: len(self.part_means) if name in FIELDS else 1 for name in self.quantities}
        return tuple(name for name in self.quantities for _ in range(count[name]))

    @cached_property
    def membership(self) -> Array:
        """(Q, K) 1 where a number belongs to a quantity, else 0."""
        names = self.column_names
        return np.array([[name == other for other in names] for name in self.quantities], float)

    @cached_property
    def observed(self) -> Array:
        """(S, K) the other program's numbers: means of fields over parts, and other quantities.

        They are NaN where the other program has no value. If it has a field at some radii of a part
        only, the mean is scaled by the ratio of our means over all and over these radii.
        """
        columns = []
        for name in self.quantities:
            theirs, ours = (results[name][self.time_rows] for results in (self.theirs, self.ours))
            common = np.isfinite(theirs) & np.isfinite(ours)
            if name not in FIELDS:
                columns.append(np.where(common, theirs, np.nan)[:, None])
                continue
            everywhere = np.isfinite(ours)
            with np.errstate(all="ignore"):
                means, our_means_at_theirs, our_means = (
                    (np.where(mask, values, 0.0) @ self.part_means.T) / (mask @ self.part_means.T)
                    for mask, values in ((common, theirs), (common, ours), (everywhere, ours))
                )
                scale = np.clip(our_means / our_means_at_theirs, 0.5, 2.0)
            columns.append(means * np.where(np.isfinite(scale), scale, 1.0))
        return np.concatenate(columns, axis=1)

    @cached_property
    def expected(self) -> Array:
        """(S, K) our numbers: what would be observed without any error."""
        columns = []
        for name in self.quantities:
            ours = self.ours[name][self.time_rows]
            if name in FIELDS:
                finite = np.isfinite(ours)
                with np.errstate(invalid="ignore"):
                    sums = np.where(finite, ours, 0.0) @ self.part_means.T
                    ours = sums / (finite @ self.part_means.T)
            columns.append(ours if ours.ndim == 2 else ours[:, None])
        return np.concatenate(columns, axis=1)

    @cached_property
    def present(self) -> Array:
        """(S, K) whether the other program has a number."""
        return np.isfinite(self.observed)

    def norms(self, values: Array) -> Array:
        """Return the root mean squares (S, Q) of the numbers (S, K) of each quantity."""
        squares = np.where(self.present, values, 0.0) ** 2 @ self.membership.T
        return np.asarray(np.sqrt(squares / np.maximum(self.present @ self.membership.T, 1)))

    def relative_differences(self, predicted: Array) -> Array:
        """Return the differences (S, K) of the observed to the predicted numbers, both (S, K).

        They are relative to the mean of both norms at each time, so that they are at most about 2;
        0 where there is nothing to compare.
        """
        norm = (self._observed_norms + self.norms(predicted)) / 2
        if "profile" in self.quantities:
            worn = norm[:, self.quantities.index("profile")]
            worn += MIN_WORN_PART * worn.max(initial=0.0)
        norms = norm @ self.membership
        difference = np.where(self.present, self.observed - predicted, 0.0)
        return np.divide(difference, norms, out=np.zeros_like(difference), where=norms > 0)

    @cached_property
    def _observed_norms(self) -> Array:
        return self.norms(self.observed)
