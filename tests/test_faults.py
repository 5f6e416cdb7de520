"""A fault put into one method, or into what all share, is found out: by the verdict or by what no method can move."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from ringwear import Scene, run
from ringwear.meshes.compliance import Compliance
from ringwear.meshes.pressure_space import PressureSpace
from ringwear.studies.crosscheck.run import Result
from ringwear.studies.methods.base import Solution
from ringwear.studies.methods.fem import Fem
from ringwear.studies.methods.mdr import Mdr
from ringwear.studies.problem.problem import Problem, Rings
from ringwear.studies.progress import Stages

Fault = Callable[[pytest.MonkeyPatch], None]


def scaled(method: type, size: float) -> Fault:
    """The compliance of a method is too great."""

    def put(patch: pytest.MonkeyPatch) -> None:
        right = method.discretised

        def wrong(self: Any, *arguments: Any, **named: Any) -> Any:
            def softer(one: Compliance) -> Compliance:
                return Compliance(one.space, one.factor * np.sqrt(1 + size))

            ready = right(self, *arguments, **named)
            pairs = tuple(replace(pair, finer=softer(pair.finer), coarser=softer(pair.coarser)) for pair in ready.pairs)
            return replace(ready, compliance=softer(ready.compliance), pairs=pairs)

        patch.setattr(method, "discretised", wrong)

    return put


def other_rings(change: Callable[[Rings], Rings]) -> Fault:
    """The finite elements solve another punch."""

    def put(patch: pytest.MonkeyPatch) -> None:
        right = Fem.solve_all

        def wrong(self: Fem, problems: Sequence[Problem], stages: Stages) -> list[Solution]:
            return right(self, [replace(problem, rings=change(problem.rings)) for problem in problems], stages)

        patch.setattr(Fem, "solve_all", wrong)

    return put


def harder(rings: Rings) -> Rings:
    factors = np.ones(len(rings.wear_coefficients))
    factors[2] = 1 + 1e-4
    return Rings(rings.ring_edges, rings.wear_coefficients * factors)


def moved(rings: Rings) -> Rings:
    shift = np.zeros(len(rings.ring_edges))
    shift[2] = 1e-6
    return Rings(rings.ring_edges + shift, rings.wear_coefficients)


def heavier(size: float) -> Fault:
    """Every pressure counts for more force than it has, in all methods."""

    def put(patch: pytest.MonkeyPatch) -> None:
        right = PressureSpace.weights.func  # type: ignore[attr-defined]
        patch.setattr(PressureSpace, "weights", property(lambda space: (1 + size) * right(space)))

    return put


def in_both(size: float) -> Fault:
    def put(patch: pytest.MonkeyPatch) -> None:
        for method in (Mdr, Fem):
            scaled(method, size)(patch)

    return put


# the fault, its size, and whether `direct` is needed to see it
FAULTS = {
    "fem's compliance": (scaled(Fem, 1e-6), 1e-6),
    "fem's compliance, by much": (scaled(Fem, 1e-3), 1e-3),
    "mdr's compliance": (scaled(Mdr, 1e-6), 1e-6),
    "a wear coefficient in one method": (other_rings(harder), 1e-4),
    "a ring edge in one method": (other_rings(moved), 1e-6),
    "both compliances": (in_both(1e-5), 1e-5),
    "both compliances, by much": (in_both(0.1), 0.1),
    "pressure weights in both": (heavier(1e-3), 1e-3),
}
# without gmsh the finite elements are of lower degree, and reach less
ACCURACIES = [pytest.param(1e-6, marks=pytest.mark.gmsh), 1e-4]


def verdict(methods: list[str], rtol: float) -> Result:
    return run(Scene.load("five_rings").changed(methods=methods, accuracy__rtol=rtol, wear__times=[0.0, 0.01, 0.1, 1.0]))


@pytest.mark.parametrize("methods", [["mdr", "fem"], ["mdr", "direct", "fem"]], ids=["without direct", "with direct"])
@pytest.mark.parametrize("rtol", ACCURACIES)
@pytest.mark.parametrize("fault", FAULTS)
def test_faults_are_caught(monkeypatch: pytest.MonkeyPatch, fault: str, rtol: float, methods: list[str]) -> None:
    put, size = FAULTS[fault]
    if size < rtol:
        pytest.skip("smaller than the accuracy asked for")
    if rtol < 1e-4 and "direct" in methods:
        pytest.skip("already caught without it")
    put(monkeypatch)
    assert verdict(methods, rtol).verdict == "disagree"


@pytest.mark.gmsh
@pytest.mark.parametrize("rtol", ACCURACIES)
def test_without_a_fault_nothing_disagrees(rtol: float) -> None:
    result = verdict(["mdr", "bem", "direct", "fem"], rtol)
    assert rtol < 1e-4 or result.verdict == "agree"
    # pressures at the start, infinite at the rim, and early slopes finite elements do not promise to that
    assert {row.quantity for row in result.agreement if not row.agrees} <= {"pressure", "rms_slope"}
    assert result.verdict != "disagree"
    assert all(anchor.holds for anchor in result.anchors)
    assert {anchor.method for anchor in result.anchors} == {"mdr", "bem", "direct", "fem"}


@pytest.mark.parametrize(
    ("quantity", "anchor"),
    [
        ("indentation", "flat start, d = F / (2 a E*)"),
        ("ring_force", "ring forces add up to F"),
        ("profile", "worn volume over k, F v0 t"),
        ("steady_wear_rate", "steady wear rate of Eq. 24"),
    ],
)
def test_each_anchor_of_results_holds_them(quantity: str, anchor: str) -> None:
    """A result that is wrong by itself, with nothing to compare it with."""
    from ringwear.studies.crosscheck.anchors import anchors

    result = verdict(["mdr"], 1e-4)
    problem, solution = result.scene.problem, result.solutions["mdr"]
    wrong = replace(solution, checked=solution.checked.assign({quantity: 1.01 * solution.checked[quantity]}))
    assert all(one.holds for one in anchors(problem, "mdr", solution))
    assert anchor in {one.name for one in anchors(problem, "mdr", wrong) if not one.holds}
