"""The cells of the map of limits: families of scenes over two parameters, each by the methods they concern."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from ringwear.meshes.radial import alternating_edges
from ringwear.studies.problem.scene import Scene

COARSE: dict[str, Any] = {"direct": {"rtol": 1e-4}, "mdr": {"rtol": 1e-3}, "fem": {"rtol": 1e-2}}
METHODS = ("direct", "mdr", "fem")
Key = float | str


@dataclass(frozen=True)
class Cell:
    """One scene by one method.

    Parameters
    ----------
    family : the two parameters, ``x × y``
    method : which method
    x, y : their values
    table : the scene
    scaled : whether the whole run in the scene's units is judged, instead of its natural results
    """

    family: str
    method: str
    x: Key
    y: Key
    table: dict[str, Any]
    scaled: bool = False


class Families:
    """All families on the solid, load and wear of a scene.

    Parameters
    ----------
    scene : its scales
    quick : every third value only
    """

    def __init__(self, scene: Scene, quick: bool) -> None:
        self.quick = quick
        solid = {"plane_strain_modulus": scene.natural.modulus, "poisson_ratio": scene.half_space.poisson_ratio}
        load = {"normal_force": scene.natural.force, "sliding_speed": scene.load_.sliding_speed}
        self.unit = Scene.from_table(
            {
                "punch": {"radius": scene.punch.radius, "rings": 1, "wear_coefficients": [1.0]},
                "half_space": solid,
                "load": load,
            }
        ).natural.time
        self.scales: dict[str, Any] = {"half_space": solid, "load": load}
        self.radius = scene.punch.radius

    def values(self, low: float, high: float, count: int) -> list[float]:
        """Values from `low` to `high` in equal ratios; fewer when quick, the ends always among them."""
        return [float(v) for v in np.geomspace(low, high, max(3, (count + 3) // 4) if self.quick else count)]

    def some(self, *values: Any) -> list[Any]:
        """The values; when quick, every third, and the last."""
        return list(dict.fromkeys([*values[::3], values[-1]])) if self.quick else list(values)

    def table(self, method: str, punch: dict[str, Any], times: Iterable[float] = (), **accuracy: Any) -> dict[str, Any]:
        """A scene of one method; ring edges of `punch` are in punch radii, times in ``a/(E* k_1 v0)``."""
        punch = {"radius": self.radius, **punch}
        if "ring_edges" in punch:
            punch["ring_edges"] = [*(float(e) * self.radius for e in punch["ring_edges"][:-1]), self.radius]
        wear = {"times": [float(t) * self.unit for t in times]}
        return {"methods": [method], "punch": punch, "wear": wear, "accuracy": COARSE[method] | accuracy, **self.scales}

    def wear_and_rings(self) -> Iterator[Cell]:
        for rings in self.some(1, 2, 3, 5, 8, 16, 32, 64, 128, 256, 1024):
            for method in METHODS:
                most = {"direct": 1024, "mdr": 256, "fem": 256}[method]
                # the largest are slow, not the less certain for it: three ratios of wear
                count = 17 if rings <= 64 or (method != "direct" and rings <= 128) else 3
                crude = {"rtol": 0.1} if rings > 64 and method != "direct" else {}
                if rings > most or (self.quick and rings > 64):
                    continue
                for ratio in self.values(1e-8, 1e8, count):
                    times = (0.0, 100 / min(1, ratio)) if rings <= 8 and method != "direct" else ()
                    table = self.table(method, {"rings": rings, "wear_coefficients": [1.0, ratio]}, times, **crude)
                    if rings == 1:
                        table["punch"]["wear_coefficients"] = [ratio]
                    yield Cell("k2/k1 × rings", method, ratio, float(rings), table)

    def widths_and_wear(self) -> Iterator[Cell]:
        for width in self.values(1e-4, 1e4, 17):
            for method in METHODS:
                for ratio in self.values(1e-8, 1e8, 9):
                    edges = alternating_edges(5, width)[1:].tolist()
                    punch = {"ring_edges": edges, "wear_coefficients": [1.0, ratio]}
                    yield Cell("h2/h1 × k2/k1", method, width, ratio, self.table(method, punch))

    def narrow_ring(self) -> Iterator[Cell]:
        for width in self.values(1e-9, 0.1, 17):
            for method in METHODS:
                for ratio in self.values(1e-8, 1e8, 9):
                    punch = {"ring_edges": [0.5, 0.5 + width, 1.0], "wear_coefficients": [1.0, ratio]}
                    yield Cell(
                        "ring width/a × k2/k1",
                        method,
                        width,
                        ratio,
                        self.table(method, punch, (0.0,) * (method != "direct")),
                    )

    def narrow_at(self) -> Iterator[Cell]:
        """A narrow ring at the axis and at the rim, and between."""
        for width in self.values(1e-9, 0.1, 9):
            for method in METHODS:
                for place, edges in {"axis": [width, 0.5, 1.0], "rim": [0.5, 1 - width, 1.0]}.items():
                    punch = {"ring_edges": edges, "wear_coefficients": [1.0, 10.0]}
                    yield Cell("ring width/a × ring at", method, width, place, self.table(method, punch))

    def poisson(self) -> Iterator[Cell]:
        for nu in self.some(-0.9, -0.7, -0.5, -0.2, 0.0, 0.2, 0.3, 0.4, 0.45, 0.49, 0.499, 0.4999, 0.49999, 0.4999999, 0.5):
            for name, fem in self.elements():
                table = self.table("fem", {"rings": 3, "wear_coefficients": [1.0, 10.0]}, (0.0, 1.0), rtol=1e-3, fem=fem)
                table["half_space"] = table["half_space"] | {"poisson_ratio": nu}
                yield Cell("Poisson's ratio × elements", "fem", nu, name, table)

    def elements(self) -> Iterator[tuple[str, dict[str, Any]]]:
        """Settings of the finite elements by name: those that users get unasked, and triangles of every degree."""
        yield "default", {}
        for degree in self.some(2, 3, 4):
            for mesher in ("gmsh", "bisection"):
                yield f"P{degree} {mesher}", {"degree": degree, "mesher": mesher}

    def truncation(self) -> Iterator[Cell]:
        for radius in self.some(2.0, 2.5, 3.0, 4.0, 5.0, 7.0, 10.0, 20.0, 50.0, 100.0, 1e3, 1e4, 1e5, 1e6):
            far_fields: dict[str, dict[str, Any]] = {
                "default": {}, "default, fixed": {"far_field": "fixed"}, "P2": {"degree": 2}, "P3": {"degree": 3},
                "P4": {"degree": 4}, "P4, 1 pole": {"degree": 4, "poles": 1}, "P4, 6 poles": {"degree": 4, "poles": 6},
                "P4 bisection": {"mesher": "bisection"}, "P4, fixed": {"degree": 4, "far_field": "fixed"},
            }  # fmt: skip
            for name, fem in far_fields.items():
                punch = {"rings": 3, "wear_coefficients": [1.0, 10.0]}
                table = self.table("fem", punch, (0.0,), rtol=1e-3, fem={"truncation": radius, **fem})
                yield Cell("R/a × far field", "fem", radius, name, table)

    def sizes(self) -> Iterator[Cell]:
        """The smallest elements, at the rim and at ring edges, by degree."""
        punch = {"rings": 3, "wear_coefficients": [1.0, 10.0]}
        for where in ("rim_size", "ring_size"):
            sizes = self.values(1e-12, 0.5, 13)
            for size in sizes:
                for degree in self.some(1, 2, 4, 8, 12, 16):
                    table = self.table("mdr", punch, (0.0, 1.0), mdr={where: size, "degree": degree})
                    yield Cell(f"{where}/a × degree", "mdr", size, float(degree), table)
            for size in sizes:
                for name, fem in self.elements():
                    table = self.table("fem", punch, (0.0, 1.0), rtol=1e-3, fem={where: size, **fem})
                    yield Cell(f"{where}/a × elements", "fem", size, name, table)

    def counts(self) -> Iterator[Cell]:
        """From the fewest elements to many."""
        punch = {"rings": 3, "wear_coefficients": [1.0, 10.0]}
        for grading in self.values(0.05, 0.8, 9):
            for degree in self.some(1, 2, 4, 8, 12, 16):
                if self.quick and grading * degree > 8:  # thousands of unknowns
                    continue
                table = self.table("mdr", punch, (0.0, 1.0), mdr={"grading": grading, "degree": degree})
                yield Cell("grading × degree", "mdr", grading, float(degree), table)
        for growth in self.values(0.12, 2.0, 9):
            for degree in self.some(2, 3, 4):
                table = self.table("fem", punch, (0.0, 1.0), rtol=1e-3, fem={"growth": growth, "degree": degree})
                yield Cell("growth × degree", "fem", growth, f"P{degree}", table)

    def tolerances(self) -> Iterator[Cell]:
        for rtol in self.values(1e-9, 0.1, 9):
            for rings in (1, 2, 3):
                for method in METHODS[1:]:
                    if method == "mdr" or rtol > 5e-7:
                        punch = {"rings": rings, "wear_coefficients": [1.0, 10.0][: rings if rings == 1 else 2]}
                        yield Cell(
                            "rtol × rings", method, rtol, float(rings), self.table(method, punch, (0.0, 1.0), rtol=rtol)
                        )

    def times(self) -> Iterator[Cell]:
        for ratio in self.values(1e-6, 1e6, 7):
            for method in METHODS[1:]:
                for time in self.values(1e-12, 1e12, 25):
                    table = self.table(method, {"rings": 3, "wear_coefficients": [1.0, ratio]}, (time,), rtol=1e-3)
                    yield Cell("t E* k1 v0/a × k2/k1", method, time, ratio, table)

    def marches(self) -> Iterator[Cell]:
        for march in ("implicit", "explicit"):
            for step in self.values(3e-6, 1e2, 13):
                table = self.table("mdr", {"rings": 2, "wear_coefficients": [1.0, 10.0]}, (0.01,), mdr={"grid": 100})
                table["wear"] |= {"march": march, "step": step * self.unit}
                yield Cell("step × march", "mdr", step, march, table)

    def scale(self) -> Iterator[Cell]:
        """Units over many decades, as whole runs: results must scale exactly."""
        for method in METHODS[:2]:
            for length in self.values(1e-9, 1e3, 13):
                for force in self.values(1e-15, 1e15, 11):
                    yield self._scaled("a × F", method, length, force, radius=length, force=force)
            for modulus in self.values(1e-9, 1e15, 13):
                for speed in self.values(1e-15, 1e15, 11):
                    yield self._scaled("E* × v0", method, modulus, speed, modulus=modulus, speed=speed)
        for length in self.values(1e-9, 1e3, 4):
            for modulus in self.values(1e-9, 1e15, 5):
                yield self._scaled("a × E*", "fem", length, modulus, radius=length, modulus=modulus)

    def _scaled(self, family: str, method: str, x: float, y: float, *, radius: float = 1.0, force: float = 1.0,
                modulus: float = 1.0, speed: float = 1.0) -> Cell:  # fmt: skip
        table = {
            "methods": [method],
            "punch": {"radius": radius, "rings": 2, "wear_coefficients": [1.0, 10.0]},
            "half_space": {"youngs_modulus": modulus, "poisson_ratio": 0.3},
            "load": {"normal_force": force, "sliding_speed": speed},
            "wear": {"times": [0.0]},
            "accuracy": {"rtol": 1e-2},
        }
        return Cell(family, method, x, y, table, scaled=True)


def all_cells(scene: Scene, quick: bool) -> Iterator[Cell]:
    """Every family; cells that share a compliance follow one another."""
    families = Families(scene, quick)
    for family in (
        families.wear_and_rings, families.widths_and_wear, families.narrow_ring, families.narrow_at, families.poisson,
        families.truncation, families.sizes, families.counts, families.tolerances, families.times, families.marches,
        families.scale,
    ):  # fmt: skip
        yield from (replace(cell, x=_tidy(cell.x), y=_tidy(cell.y)) for cell in family())


def _tidy(value: Key) -> Key:
    return value if isinstance(value, str) else float(f"{value:.9g}")
