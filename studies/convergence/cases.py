"""Levels of the study of convergence: what is computed on each, and how levels make sequences and a table."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping

import numpy as np
from ringwear.mdr import direct
from ringwear.mdr.energy import compliance as mdr_compliance
from ringwear.meshes.compliance import Compliance
from ringwear.meshes.errors import RingwearError
from ringwear.meshes.pressure_space import PressureSpace
from ringwear.meshes.radial import Array, graded_breakpoints
from ringwear.studies.convergence.levels import Sequence, Table
from ringwear.studies.methods.quads import FACTOR, GROWTH
from ringwear.studies.methods.radial import edge_weight
from ringwear.studies.problem.problem import NaturalScene
from ringwear.studies.progress import Report
from ringwear.studies.refinement.subdivision import condensed, subdivided
from ringwear.studies.wear.archard import Wear
from ringwear.studies.wear.contact import flat_start
from skfem import MeshTri

FLAT = np.array([0.0, 1.0])
TRUNCATION = 1e4
QUADS_TRUNCATION, QUADS_POLES = 2.5, tuple(range(0, 16, 2))
TIME = 1.0  # of the history, in natural units
SMOOTH_QUANTITY = "energy of a smooth pressure"
# sizes of the smallest elements: by MDR at the rim of the flat punch; at edges and rim of rings
PUNCH_RIM, RING_EDGE = 1e-13, 1e-7
LEVEL_FIELDS = ("refined", "quantity", "size", "degree", "unknowns", "value", "error", "remark")
Level = tuple[dict[str, float], int]  # quantities, unknowns
Orders = Mapping[str, float]


class Recorder:
    """Levels into sequences, and into the table as they come; a level that fails is a row, too.

    Parameters
    ----------
    table : with `LEVEL_FIELDS`
    exact : value of each quantity
    """

    def __init__(self, table: Table, exact: dict[str, float], report: Report) -> None:
        self.table, self.exact, self.report = table, exact, report
        self.sequences: dict[tuple[str, str], Sequence] = {}

    def level(
        self,
        refined: str,
        size: float,
        orders: Orders,
        compute: Callable[[], Level],
        floors: Orders,
        degree: int | None = None,
    ) -> None:
        """Compute one level; `orders` are expected, below `floors` errors do not count; those of "" are for all others.

        Where the degree is raised, it stands in the table for the size.
        """
        told = {"size": size} if degree is None else {"degree": degree}
        self.report(f"  level  {refined}, {', '.join(f'{name} {value:.3g}' for name, value in told.items())} ...")
        try:
            values, unknowns = compute()
        except RingwearError as error:
            self.table.add(refined=refined, **told, remark=f"failed: {error}")
            return
        for quantity, value in values.items():
            exact = self.exact[quantity]
            order, floor = (known.get(quantity, known[""]) for known in (orders, floors))
            sequence = self.sequences.setdefault((refined, quantity), Sequence(refined, quantity, order, exact, floor))
            sequence.add(size, value)
            row = {"refined": refined, "quantity": quantity, "unknowns": unknowns, "value": value, **told}
            self.table.add(**row, error=(value - exact) / (exact or 1.0))

    def of(self, quantity: str, *names: str) -> Iterator[Sequence]:
        """Sequences of a quantity whose name begins with one of the names."""
        return (s for (refined, what), s in self.sequences.items() if what == quantity and refined.startswith(names))


class Quantities:
    """The quantities of a scene that are refined, and their exact values: closed form, or a fine MDR."""

    def __init__(self, natural: NaturalScene) -> None:
        self.edges, self.wear = natural.phases
        slope = direct.rms_slope(self.edges, direct.steady_pressures(self.edges, self.wear))
        known = {"d0": 0.5, SMOOTH_QUANTITY: 0.0, "RMS gradient": slope}
        self.exact = self(by_mdr(self.edges, RING_EDGE, 10, 0.15)) | known

    def __call__(self, compliance: Compliance) -> dict[str, float]:
        """Every quantity of a compliance, in natural units."""
        wear, space = Wear(compliance, self.wear, TIME), compliance.space
        state, history = wear.steady, wear.modal(np.array([TIME]))
        slopes = space.slope_gram(edge_weight(space, "line"))
        steady = compliance.factor @ state.pressure
        return {
            f"d({TIME:g})": float(history.indentation[0]),
            "slowest relaxation time": float(wear.relaxation_times[0]),
            f"force on the outer ring at {TIME:g}": float(space.ring_forces(self.edges)[-1] @ history.pressure[0]),
            "mean steady displacement": float(steady @ steady),
            "RMS gradient": float(np.sqrt(state.displacement @ slopes @ state.displacement)),
        }

    def by_mdr(self, degree: int, grading: float) -> Level:
        """The quantities by MDR on a radial mesh whose neighbouring sizes have the ratio `grading`."""
        found = by_mdr(self.edges, RING_EDGE, degree, grading)
        values = self(found)
        # the factor holds q exactly: the energy of a known pressure has no error to refine
        del values["mean steady displacement"]
        return values, found.space.size

    def by_elements(self, base: MeshTri, degree: int, poisson_ratio: float, count: int) -> Level:
        """The quantities by finite elements on a subdivided mesh."""
        found, unknowns = condensed(subdivided(base, count, self.edges[1:]), self.edges, degree, poisson_ratio)
        return self(found), unknowns

    def by_quads(self, poisson_ratio: float, degree: int) -> Level:
        """The quantities by finite elements on quadrilaterals.

        What is worn is blunt: the smallest elements cost the square of their size, and still smaller ones would have
        gradients of roundoff.
        """
        found, unknowns = by_quads(self.edges, max(0.1 ** (degree + 1), RING_EDGE), degree, poisson_ratio)
        return self(found), unknowns


def by_quads(edges: Array, smallest: float, degree: int, poisson_ratio: float) -> tuple[Compliance, int]:
    """Compliance and number of unknowns of the finite-element half-space on quadrilaterals down to one size."""
    from ringwear.meshes.quads import graded

    mesh = graded(edges, smallest, smallest, FACTOR, GROWTH, QUADS_TRUNCATION).mesh
    return condensed(mesh, edges, degree, poisson_ratio, QUADS_POLES)


def by_mdr(edges: Array, size: float, degree: int, grading: float) -> Compliance:
    """Compliance by MDR on a radial mesh graded to `size` at ring edges and rim."""
    breakpoints = graded_breakpoints(edges, size, size, grading)
    return mdr_compliance(PressureSpace(breakpoints, np.full(len(breakpoints) - 1, degree), edges))


def punch_by_mdr(degree: int, grading: float) -> Level:
    """The flat start, singular at the rim, on a mesh graded to it."""
    found = by_mdr(FLAT, PUNCH_RIM, degree, grading)
    return {"d0": flat_start(found).indentation}, found.space.size


def smooth_by_mdr(degree: int, count: int) -> Level:
    """Share of the energy of the pressure ``exp(-2 r^2)`` that equal elements cannot hold.

    Galerkin's error is at right angles to what the space holds, so the share is a sum of squares and meets no roundoff.
    """
    fine = mdr_compliance(PressureSpace(np.linspace(0, 1, count + 1), np.full(count, degree + 6), FLAT))
    radii = (np.arange(16 * count) + 0.5) / (16 * count)
    pressure, *_ = np.linalg.lstsq(fine.space.matrix(radii).toarray(), np.exp(-2 * radii**2), rcond=None)
    energy, held = fine.factor @ pressure, fine.factor[:, fine.space.order <= degree]
    best, *_ = np.linalg.lstsq(held, energy, rcond=None)
    return {SMOOTH_QUANTITY: float(np.sum((energy - held @ best) ** 2) / np.sum(energy**2))}, held.shape[1]


def punch_by_elements(base: MeshTri, tips: Array, degree: int, poisson_ratio: float, count: int) -> Level:
    """The flat start by finite elements on a subdivided mesh."""
    found, unknowns = condensed(subdivided(base, count, tips), FLAT, degree, poisson_ratio)
    return {"d0": flat_start(found).indentation}, unknowns


def punch_by_quads(poisson_ratio: float, degree: int) -> Level:
    """The flat start by finite elements on quadrilaterals.

    Of d0 the smallest elements cost about 0.06 of their size: some per cent of what the degree does, if it
    shrinks tenfold with each.
    """
    found, unknowns = by_quads(FLAT, 0.1 ** (degree + 1), degree, poisson_ratio)
    return {"d0": flat_start(found).indentation}, unknowns
