"""Reduce the results of another program to the few numbers that explain its error."""

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from ...meshes import Array, Indices
from ..crosscheck import FIELDS, Results, Scene
from .measurement import Measurement
from .model import unit_of

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
    element : element of the other program, for `mesh_results`; empty if it has no mesh
    """

    times: Array
    radii: Array
    theirs: Results
    ours: Results
    scene: Scene
    element: str = ""

    @cached_property
    def time_rows(self) -> Indices:
        """(S,) indices of the compared times among all times."""
        count = len(self.times)
        return np.unique(np.linspace(0, count - 1, min(count, MAX_TIMES)).round().astype(int))

    @cached_property
    def pressures(self) -> tuple[Array, Array, Array] | None:
        """Their times (T,), radii (R,) and pressures (T, R), without units; None if there are none."""
        if "pressure" not in self.theirs:
            return None
        units = self.scene.problem.units
        pressures = self.theirs["pressure"] / unit_of(units, "pressure")
        return self.times / units.time, self.radii / units.length, pressures

    @cached_property
    def mesh_results(self) -> Results:
        """Results of elements with nodes at their radii; empty where these are not known."""
        if not self.element or self.pressures is None:
            return {}
        # it loads scikit-fem, which tables without an error do not need
        from ..wear_step.models import results_on_mesh

        found = results_on_mesh(self.scene.problem, *self.pressures, self.element)
        units = self.scene.problem.units
        return {name: values * unit_of(units, name) for name, values in found.items()}

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

    def observed(self, name: str) -> Array:
        """Return the other program's numbers (S, P) or (S, 1), NaN where it has none.

        If it has a field at some radii of a part only, the mean is scaled by the ratio of our means
        over all and over these radii.
        """
        theirs, ours = (results[name][self.time_rows] for results in (self.theirs, self.ours))
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
        ours = replace(self, theirs=self.ours)
        return tuple(ours.observed(name).ravel() for name in self.quantities)

    def mesh_errors(self) -> tuple[Array, ...]:
        """Return the relative errors (n,) of a linear mesh in each measurement; 0 where unknown."""
        if not self.mesh_results:
            return ()
        names = [name for name in self.quantities if name in self.mesh_results]
        on_mesh = replace(self, theirs=self.mesh_results)
        ours = replace(self, theirs=self.ours)
        return tuple(
            relative(on_mesh.observed(name), ours.observed(name)).ravel()
            if name in names
            else np.zeros(ours.observed(name).size)
            for name in self.quantities
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
            values, times = self.observed(name), self.times[self.time_rows]
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
