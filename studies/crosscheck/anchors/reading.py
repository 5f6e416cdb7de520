"""Read a scene a second time, from its TOML, independently of `Problem`.

Anchors use only these numbers. A mistake of `Problem` in reading, scaling or integrating the scene
therefore appears as a difference. Only the functions that give heights of a profile are those of
the scene; tests compare these with formulas of their own.
"""

import tomllib
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from scipy.special import exprel

from ....mdr.flat_punch import flat_punch_of
from ....meshes.ground.ground import HALF_SPACE, Ground
from ....meshes.radial import Array, Indices, unit_gauss
from ..problem.fields import Height, TomlTable
from ..problem.quantities import Units
from ..scene.scene import Scene

# difference of two radii, in punch radii, below which they are the same but for roundoff
SAME_RADIUS = 1e-14
# points of the Gauss rule that integrates over a segment on which the wear coefficient is linear
GAUSS_POINTS = 24


@dataclass(frozen=True, eq=False)
class Reading:
    """The numbers of a scene, read directly from its TOML.

    Parameters
    ----------
    rtol : relative accuracy that the scene asks for
    average : `line` or `area`, how the RMS slope is averaged
    edges : (N+1,) ring edges over the punch radius
    wear_radii, wear : (M,) radii over the punch radius, all ring edges among them, and the wear
        coefficients there, over the greatest; linear between, with two equal radii at a step
    force, speed : (2, K) times and values of the load, in the scene's units; linear between, and
        constant before the first time and after the last
    times : (T,) times of the scene, in its unit
    units : the units of non-dimensional numbers, in the scene's units
    heights : functions of the unworn heights over the radius, both in the scene's unit
    recess : (N,) recess of each ring, in the scene's unit
    ground : layers, with thicknesses over the punch radius and moduli over that of the first layer
    """

    rtol: float
    average: str
    edges: Array
    wear_radii: Array
    wear: Array
    force: Array
    speed: Array
    times: Array
    units: Units
    heights: tuple[Height, ...]
    recess: Array
    ground: Ground = HALF_SPACE

    @classmethod
    def of(cls, scene: Scene) -> "Reading":
        """Read a scene."""
        toml = tomllib.loads(scene.to_toml())
        load, half_space = toml["load"], toml["half_space"]
        # the radius of a face that is as wide as its scar is not in the scene
        punch = {"radius": scene.punch.radius} | toml["punch"]
        radius = punch["radius"]
        modulus = _plane_strain_modulus((half_space.get("layers") or [half_space])[0])
        ground = _ground(half_space, modulus, radius)
        if "punch_youngs_modulus" in half_space:
            # the compliances of two half-spaces add up
            compliance = 1 - half_space.get("punch_poisson_ratio", 0.3) ** 2
            both = 1 / (1 / modulus + compliance / half_space["punch_youngs_modulus"])
            if ground.layered:
                ground = replace(ground, share=both / modulus)
            modulus = both
        edges = _edges(punch)
        wear_radii, wear = _wear(punch, edges)
        fastest = float(wear.max())
        cycles, pressed = load.get("repeat", 1), load.get("mean_pressure", 1.0)
        force = _over_time(load.get("normal_force", pressed), cycles)
        speed = _over_time(load.get("sliding_speed", 1.0), cycles)
        greatest = force[1].max()
        if "mean_pressure" in load:
            greatest *= np.pi * (radius**2 - punch.get("inner_radius", 0.0) ** 2)
        if "indentation" in load:
            # unit of force: that of a flat punch at the same indentation beyond the first touch
            profile, unit = scene.problem.profile, scene.problem.units.displacement
            depth = load["indentation"] - profile.standoff * unit
            greatest = radius * modulus * depth / flat_punch_of(float(edges[0]), ground).indentation
        time = radius / modulus / fastest / speed[1].max()
        face = scene.punch.profile
        of_profile = [face.height_over(radius)] if face else []
        return cls(
            rtol=toml.get("accuracy", {}).get("rtol", 1e-4),
            average=toml.get("output", {}).get("gradient_average", "line"),
            edges=edges,
            wear_radii=wear_radii,
            wear=wear / fastest,
            force=force,
            speed=speed,
            times=np.array(scene.wear.times, dtype=float),
            units=Units(radius, modulus, float(greatest), time, fastest),
            heights=(*scene.punch.heights, *of_profile),
            recess=np.zeros(len(edges) - 1) + np.array(punch.get("recess", 0.0)),
            ground=ground,
        )

    def wear_at(self, radii: Array) -> Array:
        """Return the wear coefficient at radii (over the punch radius), over the greatest."""
        return np.interp(radii, self.wear_radii, self.wear)

    @cached_property
    def _segments(self) -> tuple[Array, Array, Indices]:
        """Radii (2, n) of the ends of segments, the wear coefficients there, and first segments.

        The wear coefficient is linear on a segment. The last array (N,) has the index of the first
        segment of each ring.
        """
        on_face = (np.diff(self.wear_radii) > 0) & (self.wear_radii[:-1] >= self.edges[0])
        ends, wear = (
            np.stack([values[:-1], values[1:]])[:, on_face]
            for values in (self.wear_radii, self.wear)
        )
        return ends, wear, np.searchsorted(ends[0], self.edges[:-1])

    @cached_property
    def inverse_wear(self) -> Array:
        """(N,) integrals of ``dA / k`` over the rings, with k over the greatest.

        The variable s of the integral grows with the logarithm of k from 0 to 1 on each segment: on
        it, ``dr / k = b ds / (k0 exprel(c))`` with its width b, the value k0 at its inner end and
        the change c of the logarithm, and the radius is a smooth function of s.
        """
        ends, wear, first = self._segments
        nodes, weights = unit_gauss(GAUSS_POINTS)
        width, change = np.diff(ends, axis=0)[0], np.log(wear[1] / wear[0])
        parts = nodes * exprel(np.outer(change, nodes)) / exprel(change)[:, None]
        means = ends[0] + width * (parts @ weights)
        integrals = 2 * np.pi * width * means / wear[0] / exprel(change)
        return np.asarray(np.add.reduceat(integrals, first))

    def extremes_of_wear(self) -> tuple[Array, Array]:
        """Return the least and the greatest wear coefficient on each ring, over the greatest."""
        _, wear, first = self._segments
        least, greatest = np.minimum.reduceat(wear, first, 1), np.maximum.reduceat(wear, first, 1)
        return least.min(axis=0), greatest.max(axis=0)

    def unworn(self, radii: Array) -> Array:
        """Return the heights of the unworn face at radii (over the punch radius), non-dimensional.

        The TOML has no functions of a user, so that all functions are those of the scene.
        """
        ring = np.clip(
            np.searchsorted(self.edges, radii, side="right") - 1, 0, len(self.recess) - 1
        )
        heights = self.recess[ring] + sum(of(radii * self.units.length) for of in self.heights)
        return np.asarray(heights / self.units.displacement)

    def load(self, times: Array) -> tuple[Array, Array, Array]:
        """Return force, sliding distance and work (the integral of force over distance) at times.

        All are non-dimensional, (T,). Between knots force and speed are linear in time, so that
        Simpson's rule integrates their product exactly.
        """
        until = np.atleast_1d(times) * self.units.time
        grid = np.unique(np.concatenate([[0.0], self.force[0], self.speed[0], until]))
        points = np.array([grid[:-1], (grid[1:] + grid[:-1]) / 2, grid[1:]])
        forces, speeds = (
            np.interp(points, *load) / load[1].max() for load in (self.force, self.speed)
        )
        rates = np.array([1, 4, 1]) @ np.array([speeds, forces * speeds]) / 6
        sums = np.cumsum(rates * np.diff(grid), axis=1) / self.units.time
        distance, work = np.pad(sums, ((0, 0), (1, 0)))[:, np.searchsorted(grid, until)]
        return np.interp(until, *self.force) / self.force[1].max(), distance, work


def _over_time(load: float | TomlTable, cycles: int) -> Array:
    """Return the times and the values (2, K) of a load, which a scene may give as a number."""
    table = load if isinstance(load, dict) else {"times": [0.0], "values": [load]}
    times, values = np.array([table["times"], table["values"]], dtype=float)
    # a cycle ends where the next one begins
    later = slice(int(times[0] == 0), None)
    starts = times[-1] * np.arange(1, cycles)[:, None]
    times = np.append(times, (starts + times[later]).ravel())
    return np.array([times, np.append(values, np.tile(values[later], cycles - 1))])


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


def _edges(punch: TomlTable) -> Array:
    """Return the ring edges (N+1,) of a punch, over its radius."""
    hole = punch.get("inner_radius", 0.0)
    if "ring_edges" in punch:
        return np.array([hole, *punch["ring_edges"]]) / punch["radius"]
    widths = np.ones(punch.get("rings", 1))
    widths[1::2] = punch.get("width_ratio", 1.0)
    hole /= punch["radius"]
    return hole + (1 - hole) * np.append(0.0, np.cumsum(widths)) / widths.sum()


def _wear(punch: TomlTable, edges: Array) -> tuple[Array, Array]:
    """Return radii (M,) over that of the punch, and the wear coefficients there.

    Ring edges are among the radii. The wear coefficient is linear between radii, and has a step
    where two are equal.
    """
    given = punch.get("wear_coefficients", punch.get("wear_coefficient"))
    if not isinstance(given, dict):
        if isinstance(given, float | int):
            given = [given, given * punch.get("wear_ratio", 1.0)]
        # two coefficients alternate from the centre
        on_rings = np.resize(np.array(given, dtype=float), len(edges) - 1)
        return np.repeat(edges, 2)[1:-1], np.repeat(on_rings, 2)
    radii, values = (np.array(given[key], dtype=float) for key in ("radii", "values"))
    radii /= punch["radius"]
    nearest = edges[np.searchsorted((edges[1:] + edges[:-1]) / 2, radii)]
    radii = np.where(np.abs(radii - nearest) <= SAME_RADIUS, nearest, radii)
    missing = np.setdiff1d(edges, radii)
    places = np.searchsorted(radii, missing)
    wear = np.insert(values, places, np.interp(missing, radii, values))
    return np.insert(radii, places, missing), wear
