"""Read a scene a second time, from its TOML, independently of `Problem`.

Anchors use only these numbers. A mistake of `Problem` in reading, scaling or integrating the scene
therefore appears as a difference.
"""

import tomllib
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise

import numpy as np

from ....mdr.flat_punch import flat_punch_of
from ....meshes.errors import RingwearError
from ....meshes.ground.ground import HALF_SPACE, Ground
from ....meshes.radial import Array, ring_areas, unit_gauss
from ..problem.fields import TomlTable
from ..problem.quantities import Units
from ..scene.scene import Scene

# difference of two radii, in punch radii, below which they are the same but for roundoff
SAME_RADIUS = 1e-14
# relative change of the wear coefficient along a segment below which a closed form loses digits, so
# that a Gauss rule integrates instead, and the points of that rule, which gives all digits
SMALL_CHANGE, GAUSS_POINTS = 0.5, 24


@dataclass(frozen=True, eq=False)
class OverTime:
    """A load that is linear between times, and constant before the first and after the last.

    Parameters
    ----------
    times : (K,) in the scene's unit
    values : (K,) over the greatest of them
    greatest : the greatest value, in the scene's unit
    """

    times: Array
    values: Array
    greatest: float

    @classmethod
    def of(cls, load: float | TomlTable) -> "OverTime":
        """Return a load that a scene gives as a number, or as a table of times and values."""
        table = load if isinstance(load, dict) else {"times": [0.0], "values": [load]}
        values = np.array(table["values"], dtype=float)
        return cls(np.array(table["times"], dtype=float), values / values.max(), values.max())

    def at(self, times: Array) -> Array:
        """Return the values at times, over the greatest value."""
        return np.interp(times, self.times, self.values)


@dataclass(frozen=True, eq=False)
class Reading:
    """The numbers of a scene, read directly from its TOML.

    Parameters
    ----------
    rtol : relative accuracy that the scene asks for
    average : `line` or `area`, how the RMS slope is averaged
    edges : (N+1,) ring edges over the punch radius
    coefficients : (N,) wear coefficients of the rings, in the scene's unit; None with a `table`
    table : radii and wear coefficients along the radius, in the scene's units; empty if the wear
        coefficient is constant on rings
    force, speed : the load over time
    times : (T,) times of the scene, in its unit
    units : the units of non-dimensional numbers, in the scene's units
    profile : the table of the unworn profile, with lengths in the scene's unit; None if it is flat
    recess : (N,) recess of each ring, in the scene's unit
    ground : layers, with thicknesses over the punch radius and moduli over that of the first layer
    """

    rtol: float
    average: str
    edges: Array
    coefficients: Array | None
    table: TomlTable
    force: OverTime
    speed: OverTime
    times: Array
    units: Units
    profile: TomlTable | None
    recess: Array
    ground: Ground = HALF_SPACE

    @classmethod
    def of(cls, scene: Scene) -> "Reading":
        """Read a scene."""
        toml = tomllib.loads(scene.to_toml())
        punch, load, half_space = toml["punch"], toml["load"], toml["half_space"]
        radius = punch["radius"]
        modulus = _plane_strain_modulus((half_space.get("layers") or [half_space])[0])
        ground = _ground(half_space, modulus, radius)
        if "punch_youngs_modulus" in half_space:
            # the compliances of two half-spaces add up
            compliance = 1 - half_space.get("punch_poisson_ratio", 0.3) ** 2
            modulus = 1 / (1 / modulus + compliance / half_space["punch_youngs_modulus"])
        edges = _edges(punch)
        coefficients, table = _wear(punch, len(edges) - 1)
        fastest = float(np.max(table["values"] if coefficients is None else coefficients))
        force = OverTime.of(load.get("normal_force", load.get("mean_pressure", 1.0)))
        speed = OverTime.of(load.get("sliding_speed", 1.0))
        greatest = force.greatest
        if "mean_pressure" in load:
            greatest *= np.pi * (radius**2 - punch.get("inner_radius", 0.0) ** 2)
        if "indentation" in load:
            # unit of force: that of a flat punch at the same indentation beyond the first touch
            profile, unit = scene.problem.profile, scene.problem.units.displacement
            depth = load["indentation"] - profile.standoff * unit
            greatest = radius * modulus * depth / flat_punch_of(float(edges[0]), ground).indentation
        time = radius / modulus / fastest / speed.greatest
        return cls(
            rtol=toml.get("accuracy", {}).get("rtol", 1e-4),
            average=toml.get("output", {}).get("gradient_average", "line"),
            edges=edges,
            coefficients=coefficients,
            table=table,
            force=force,
            speed=speed,
            times=np.array(scene.wear.times, dtype=float),
            units=Units(radius, modulus, float(greatest), time, fastest),
            profile=punch.get("profile"),
            recess=np.zeros(len(edges) - 1) + np.array(punch.get("recess", 0.0)),
            ground=ground,
        )

    @property
    def knots(self) -> Array:
        """(K,) times between which force and speed are linear, including the time 0."""
        return np.unique(np.concatenate([[0.0], self.force.times, self.speed.times]))

    def wear_at(self, radii: Array) -> Array:
        """Return the wear coefficient at radii (over the punch radius), over the greatest."""
        if self.table:
            length = self.units.length
            values = np.interp(radii * length, self.table["radii"], self.table["values"])
        else:
            assert self.coefficients is not None
            ring = np.searchsorted(self.edges, radii, side="right") - 1
            values = self.coefficients[np.clip(ring, 0, len(self.coefficients) - 1)]
        return values / self.units.wear_coefficient

    @cached_property
    def inverse_wear(self) -> Array:
        """(N,) integrals of ``dA / k`` over the rings, with k over the greatest, in closed form.

        They do not need the wear coefficient at single radii, which may be rounded to the other
        side of a ring edge.
        """
        if not self.table:
            assert self.coefficients is not None
            return ring_areas(self.edges) * self.units.wear_coefficient / self.coefficients
        # k is linear between the radii of the table, and constant beyond them
        radii = np.concatenate([[-1.0], np.array(self.table["radii"]) / self.units.length, [2.0]])
        values = np.array(self.table["values"])[[0, *range(len(radii) - 2), -1]]
        cuts = np.unique(np.concatenate([self.edges, np.clip(radii, self.edges[0], 1.0)]))
        ends = np.stack([cuts[:-1], cuts[1:]])
        # the part of the table that contains a segment; at a step, two radii are equal
        part = np.searchsorted(radii, ends.mean(axis=0)) - 1
        rise = np.diff(values)[part] / np.diff(radii)[part]
        wear = values[part] + rise * (ends - radii[part])
        integrals = _integrals_over_wear(ends, wear / self.units.wear_coefficient)
        return np.add.reduceat(integrals, np.searchsorted(cuts, self.edges[:-1]))

    def extremes_of_wear(self) -> tuple[Array, Array]:
        """Return the least and the greatest wear coefficient on each ring, over the greatest."""
        if not self.table:
            middles = (self.edges[1:] + self.edges[:-1]) / 2
            return self.wear_at(middles), self.wear_at(middles)
        # k is linear between the radii of the table, so that its extremes on a ring are at these
        # radii or at the ring edges, where one-sided values are needed because k may jump
        radii, extremes = np.array(self.table["radii"]) / self.units.length, []
        for inner, outer in pairwise(self.edges):
            on_ring = [self._beside(inner, -1), self._beside(outer, 0)]
            inside = (radii > inner + SAME_RADIUS) & (radii < outer - SAME_RADIUS)
            values = np.append(np.array(self.table["values"])[inside], on_ring)
            extremes.append((values.min(), values.max()))
        least, greatest = np.transpose(extremes) / self.units.wear_coefficient
        return least, greatest

    def _beside(self, edge: float, which: int) -> float:
        """Return the wear coefficient of the table beside a ring edge: outside (-1) or inside (0).

        At a step of the table, two radii are equal, and `which` is the index of one of them.
        """
        radii, values = np.array(self.table["radii"]) / self.units.length, self.table["values"]
        at_edge = np.flatnonzero(np.abs(radii - edge) <= SAME_RADIUS)
        if len(at_edge):
            return float(values[at_edge[which]])
        return float(np.interp(edge, radii, values))

    def unworn(self, radii: Array) -> Array:
        """Return the heights of the unworn face at radii (over the punch radius), non-dimensional.

        Profiles that a user gives as Python functions are left out, because the TOML has none.
        """
        ring = np.clip(
            np.searchsorted(self.edges, radii, side="right") - 1, 0, len(self.recess) - 1
        )
        heights = self.recess[ring]
        if self.profile is not None:
            heights = heights + _heights(self.profile, radii * self.units.length, self.units.length)
        return heights / self.units.displacement

    def load(self, times: Array) -> tuple[Array, Array, Array]:
        """Return force, sliding distance and work (the integral of force over distance) at times.

        All are non-dimensional, (T,). Between knots force and speed are linear in time, so that
        Simpson's rule integrates their product exactly.
        """
        until, knots = np.atleast_1d(times) * self.units.time, self.knots
        at_knots = np.zeros((2, len(knots)))
        at_knots[:, 1:] = np.cumsum(self._integrals(knots[:-1], knots[1:]), axis=1)
        last = np.searchsorted(knots, until, side="right") - 1
        distance, work = at_knots[:, last] + self._integrals(knots[last], until)
        return self.force.at(until), distance / self.units.time, work / self.units.time

    def _integrals(self, starts: Array, ends: Array) -> Array:
        """Return distance and work (2, n) from times to others before the next knots."""
        speeds, forces = (
            np.array([load.at(times) for times in (starts, (starts + ends) / 2, ends)])
            for load in (self.speed, self.force)
        )
        distance = speeds[[0, 2]].sum(axis=0) / 2
        work = np.array([1, 4, 1]) @ (forces * speeds) / 6
        return (ends - starts) * np.array([distance, work])


def _integrals_over_wear(ends: Array, wear: Array) -> Array:
    """Return ``int 2 pi r / k dr`` over segments (n,) between radii (2, n).

    The wear coefficient k is linear between its values (2, n) at these radii.
    """
    width, change = ends[1] - ends[0], (wear[1] - wear[0]) / wear[0]
    small = np.abs(change) < SMALL_CHANGE
    safe = np.where(small, 1.0, change)
    # means over the segment of 1 / (1 + change s) and of s / (1 + change s), with s from 0 to 1
    mean = np.log1p(safe) / safe
    mean_of_s = (1 - mean) / safe
    nodes, weights = unit_gauss(GAUSS_POINTS)
    factors = 1 / (1 + np.outer(np.where(small, change, 0.0), nodes))
    mean = np.where(small, factors @ weights, mean)
    mean_of_s = np.where(small, factors @ (weights * nodes), mean_of_s)
    return 2 * np.pi * width * (ends[0] * mean + width * mean_of_s) / wear[0]


def _plane_strain_modulus(material: TomlTable) -> float:
    """Return the plane strain modulus of the half-space, or of a layer."""
    if "plane_strain_modulus" in material:
        return float(material["plane_strain_modulus"])
    return float(material["youngs_modulus"] / (1 - material.get("poisson_ratio", 0.3) ** 2))


def _ground(half_space: TomlTable, unit: float, radius: float) -> Ground:
    """Return the ground over the punch radius, with moduli over a unit."""
    materials = [*half_space.get("layers", []), *([] if half_space.get("rigid") else [half_space])]
    ratios = [material.get("poisson_ratio", 0.3) for material in materials]
    # E* = 2 G / (1 - nu)
    shear = [
        _plane_strain_modulus(material) * (1 - ratio) / 2 / unit
        for material, ratio in zip(materials, ratios, strict=True)
    ]
    if half_space.get("rigid"):
        shear, ratios = [*shear, np.inf], [*ratios, 0.3]
    thicknesses = tuple(layer["thickness"] / radius for layer in half_space.get("layers", []))
    return Ground(thicknesses, tuple(shear), tuple(ratios))


def _heights(profile: TomlTable, radii: Array, punch_radius: float) -> Array:
    """Return the heights of a profile at radii, all in the scene's unit.

    Raises
    ------
    RingwearError
        if no function reads profiles of this kind
    """
    kind = profile["kind"]
    if kind not in HEIGHTS:
        raise RingwearError(
            f"punch.profile.kind = {kind!r} has no second reading, by which anchors check the "
            "heights of the face: add a function of this kind to HEIGHTS in "
            "studies/crosscheck/anchors/reading.py, as CONTRIBUTING.md describes"
        )
    table = profile | {"punch_radius": punch_radius}
    return np.asarray(HEIGHTS[kind](table, radii), dtype=float)


def _parabola(profile: TomlTable, radii: Array) -> Array:
    return radii**2 / (2 * profile["curvature_radius"])


def _ball(profile: TomlTable, radii: Array) -> Array:
    ball = profile["ball_radius"]
    # R (1 - cos(x)) = 2 R sin(x/2)^2, without cancellation
    return 2 * ball * np.sin(np.arcsin(radii / ball) / 2) ** 2


def _truncated_cone(profile: TomlTable, radii: Array) -> Array:
    return profile["slope"] * np.maximum(radii - profile["flat_radius"], 0.0)


def _truncated_paraboloid(profile: TomlTable, radii: Array) -> Array:
    flat = profile["flat_radius"]
    return np.where(radii > flat, radii**2 - flat**2, 0.0) / (2 * profile["curvature_radius"])


def _concave(profile: TomlTable, radii: Array) -> Array:
    return profile["depth"] * (1 - (radii / profile["punch_radius"]) ** 2)


def _cone(profile: TomlTable, radii: Array) -> Array:
    return profile["slope"] * radii


def _power(profile: TomlTable, radii: Array) -> Array:
    return profile["coefficient"] * (radii / profile["punch_radius"]) ** profile["exponent"]


def _rounded_rim(profile: TomlTable, radii: Array) -> Array:
    beyond = np.maximum(radii - profile["flat_radius"], 0.0)
    return beyond**2 / (2 * profile["curvature_radius"])


def _table(profile: TomlTable, radii: Array) -> Array:
    from scipy.interpolate import pchip_interpolate  # imported here: only tables need it

    return pchip_interpolate(profile["radii"], profile["heights"], radii)


# Functions that return the heights of a profile at radii, by its kind. Their arguments are the
# table of the profile, to which `punch_radius` is added, and the radii. All lengths are in the
# scene's unit.
HEIGHTS: dict[str, Callable[[TomlTable, Array], Array]] = {
    "parabola": _parabola,
    "ball": _ball,
    "truncated_cone": _truncated_cone,
    "truncated_paraboloid": _truncated_paraboloid,
    "concave": _concave,
    "cone": _cone,
    "power": _power,
    "rounded_rim": _rounded_rim,
    "table": _table,
}


def _edges(punch: TomlTable) -> Array:
    """Return the ring edges (N+1,) of a punch, over its radius."""
    hole = punch.get("inner_radius", 0.0)
    if "ring_edges" in punch:
        return np.array([hole, *punch["ring_edges"]]) / punch["radius"]
    widths = np.ones(punch.get("rings", 1))
    widths[1::2] = punch.get("width_ratio", 1.0)
    hole /= punch["radius"]
    return hole + (1 - hole) * np.append(0.0, np.cumsum(widths)) / widths.sum()


def _wear(punch: TomlTable, rings: int) -> tuple[Array | None, TomlTable]:
    """Return the wear coefficients of the rings, or else the table along the radius."""
    coefficients = punch.get("wear_coefficients", punch.get("wear_coefficient"))
    if isinstance(coefficients, dict):
        return None, coefficients
    if isinstance(coefficients, float | int):
        coefficients = [coefficients, coefficients * punch.get("wear_ratio", 1.0)]
    # two coefficients alternate from the centre
    return np.resize(np.array(coefficients, dtype=float), rings), {}
