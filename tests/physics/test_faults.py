"""A fault put into one method, or into what all share, is found out.

By the verdict or by what no method can move.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
import xarray

from ringwear import Scene, run
from ringwear.meshes.compliance import Compliance
from ringwear.meshes.pressure_space import PressureSpace
from ringwear.studies.crosscheck.anchors import anchors
from ringwear.studies.crosscheck.run import Result
from ringwear.studies.methods.base import Solution
from ringwear.studies.methods.fem import Fem
from ringwear.studies.methods.mdr import Mdr
from ringwear.studies.methods.sampler import Sampler
from ringwear.studies.problem.problem import Problem, Rings
from ringwear.studies.progress import Stages
from ringwear.studies.wear import archard
from ringwear.studies.wear.modes import Modes

Fault = Callable[[pytest.MonkeyPatch], None]


def scaled(method: type, size: float) -> Fault:
    """The compliance of a method is too great."""

    def put(patch: pytest.MonkeyPatch) -> None:
        right = method.discretised

        def wrong(self: Any, *arguments: Any, **named: Any) -> Any:
            def softer(one: Compliance) -> Compliance:
                return Compliance(one.space, one.factor * np.sqrt(1 + size))

            ready = right(self, *arguments, **named)
            return replace(
                ready, compliance=softer(ready.compliance), coarser=softer(ready.coarser)
            )

        patch.setattr(method, "discretised", wrong)

    return put


def other_rings(change: Callable[[Rings], Rings]) -> Fault:
    """The finite elements solve another punch."""

    def put(patch: pytest.MonkeyPatch) -> None:
        right = Fem.solve_all

        def wrong(self: Fem, problems: Sequence[Problem], stages: Stages) -> list[Solution]:
            return right(
                self,
                [replace(problem, rings=change(problem.rings)) for problem in problems],
                stages,
            )

        patch.setattr(Fem, "solve_all", wrong)

    return put


def harder(rings: Rings) -> Rings:
    factors = np.ones(len(rings.wear_coefficients))
    factors[2] = 1 + 1e-4
    return Rings(rings.ring_edges, rings.wear_coefficients * factors)


def moved(rings: Rings) -> Rings:
    shift = np.zeros(len(rings.ring_edges))
    shift[2] = 3e-6
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
    "fem's compliance": (scaled(Fem, 5e-6), 5e-6),
    "fem's compliance, by much": (scaled(Fem, 1e-3), 1e-3),
    "mdr's compliance": (scaled(Mdr, 5e-6), 5e-6),
    "a wear coefficient in one method": (other_rings(harder), 1e-4),
    "a ring edge in one method": (other_rings(moved), 3e-6),
    "both compliances": (in_both(1e-5), 1e-5),
    "both compliances, by much": (in_both(0.1), 0.1),
    "pressure weights in both": (heavier(1e-3), 1e-3),
}
# without gmsh the finite elements are of lower degree, and reach less
ACCURACIES = [pytest.param(1e-6, marks=pytest.mark.gmsh), 1e-4]


def verdict(methods: list[str], rtol: float) -> Result:
    return run(
        Scene.load("five_rings").changed(
            methods=methods, accuracy__rtol=rtol, wear__times=[0.0, 0.01, 0.1, 1.0]
        )
    )


@pytest.mark.parametrize(
    "methods", [["mdr", "fem"], ["mdr", "direct", "fem"]], ids=["without direct", "with direct"]
)
@pytest.mark.parametrize("rtol", ACCURACIES)
@pytest.mark.parametrize("fault", FAULTS)
def test_faults_are_caught(
    monkeypatch: pytest.MonkeyPatch, fault: str, rtol: float, methods: list[str]
) -> None:
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
    # pressures at the start, infinite at the rim, and early slopes finite elements do not promise
    # to that
    assert {row.quantity for row in result.agreement if not row.agrees} <= {"pressure", "rms_slope"}
    assert result.verdict != "disagree"
    assert all(anchor.holds for anchor in result.anchors)
    assert {anchor.method for anchor in result.anchors} == {"mdr", "bem", "direct", "fem"}


def of_modes(change: Callable[[Modes], Modes]) -> Fault:
    """The modes of all methods are wrong."""

    def put(patch: pytest.MonkeyPatch) -> None:
        right = archard.every_mode
        patch.setattr(archard, "every_mode", lambda *of: change(right(*of)))

    return put


def lost(number: int) -> Fault:
    def without(modes: Modes) -> Modes:
        kept = np.arange(len(modes.relaxation)) != number - 1
        return Modes(
            modes.relaxation[kept], modes.shapes[:, kept], modes.amplitudes[kept], modes.exact - 1
        )

    return of_modes(without)


def slower(size: float) -> Fault:
    def with_slower(modes: Modes) -> Modes:
        factors = np.where(np.arange(len(modes.relaxation)) == 0, 1 + size, 1.0)
        return replace(modes, relaxation=modes.relaxation * factors)

    return of_modes(with_slower)


def reported(name: str, size: float, start: bool = True, everywhere: bool = True) -> Fault:
    """A quantity of all methods is too great.

    From the start or later, on all of the face or at the radii of the output.
    """

    def put(patch: pytest.MonkeyPatch) -> None:
        for part in ("history", "steady"):
            right = getattr(Sampler, part)

            def wrong(
                self: Sampler, state: Any, on_face: bool = False, right: Any = right
            ) -> xarray.Dataset:
                found = right(self, state, on_face)
                if name not in found or (on_face and not everywhere):
                    return found
                factor = 1 + size
                if not start:
                    factor = xarray.where(found["time"] > 0, factor, 1.0)
                return found.assign({name: found[name] * factor})

            patch.setattr(Sampler, part, wrong)

    return put


def moved_force(size: float) -> Fault:
    """A part of the force on the second ring is said to be on the third."""

    def put(patch: pytest.MonkeyPatch) -> None:
        right = Sampler._ring_forces

        def wrong(self: Sampler, history: Any) -> Any:
            forces = right(self, history)
            forces[:, 1] -= size
            forces[:, 2] += size
            return forces

        patch.setattr(Sampler, "_ring_forces", wrong)

    return put


def later_times(size: float) -> Fault:
    """Times at the door are too late."""

    def put(patch: pytest.MonkeyPatch) -> None:
        right = Scene._posed

        def wrong(self: Scene) -> Problem:
            problem = right(self)
            return replace(problem, times=problem.times * (1 + size))

        patch.setattr(Scene, "_posed", wrong)

    return put


SMALL = 3e-4
COMMON_FAULTS = {
    **{f"mode {number} lost": lost(number) for number in (1, 3, 6)},
    **{f"slowest tau {size:g}": slower(size) for size in (1e-2, 1e-3, SMALL)},
    **{
        f"{name} {size:g}": reported(name, size)
        for name in (
            "pressure",
            "displacement_max",
            "displacement_centre",
            "profile",
            "displacement",
        )
        for size in (0.1, 1e-2, 1e-3, SMALL)
    },
    **{f"rms_slope {size:g}": reported("rms_slope", size) for size in (0.1, 1e-2, 1e-3, SMALL)},
    **{
        f"later indentation {size:g}": reported("indentation", size, start=False)
        for size in (1e-2, 1e-3, SMALL)
    },
    **{f"ring force moved {size:g}": moved_force(size) for size in (1e-2, SMALL)},
    **{
        f"{name} {size:g}": reported(name, size)
        for name in (
            "steady_pressure",
            "steady_displacement_max",
            "steady_rms_slope",
            "steady_wear_rate",
        )
        for size in (1e-2, SMALL)
    },
    # of the greatest displacement, which is its norm, that is a third
    "steady_profile 1e-3": reported("steady_profile", 1e-3),
    **{f"times {size:g}": later_times(size) for size in (1e-2, SMALL)},
    **{
        f"{name} at output radii {size:g}": reported(name, size, everywhere=False)
        for name in ("pressure", "profile", "displacement")
        for size in (0.1, SMALL)
    },
}


@pytest.mark.parametrize("fault", COMMON_FAULTS)
def test_faults_that_all_methods_share_are_caught(
    monkeypatch: pytest.MonkeyPatch, fault: str
) -> None:
    """With nothing to compare with: by what no method can move, at an accuracy of 1e-4."""
    COMMON_FAULTS[fault](monkeypatch)
    assert verdict(["mdr"], 1e-4).verdict == "disagree"


@pytest.mark.parametrize(
    ("name", "anchor"),
    [
        ("indentation", "flat start, d = F / (2 a E*)"),
        ("indentation", "reciprocity with the flat punch"),
        ("ring_force", "ring forces add up to F"),
        ("relaxation_time", "slowest relaxation time, by a small problem of its own"),
        ("steady_wear_rate", "steady_wear_rate in closed form"),
        ("worn_volume", "worn volume of the answer over k, F v0 t"),
        ("indentation_start", "flat start of the answer"),
        ("pressure_min", "steady pressures of the answer"),
    ],
)
def test_anchors_hold_what_is_written(name: str, anchor: str) -> None:
    """A dataset that is wrong by itself, whatever the method knows."""
    result = verdict(["mdr"], 1e-4)
    dataset, solution = result.dataset.sel(solver="mdr"), result.solutions["mdr"]
    wrong = dataset.assign({name: 1.001 * dataset[name]})
    assert all(one.holds for one in anchors(result.scene, "mdr", dataset, solution))
    assert anchor in {
        one.name for one in anchors(result.scene, "mdr", wrong, solution) if not one.holds
    }


def test_no_number_holds_to_nothing() -> None:
    result = verdict(["mdr"], 1e-4)
    dataset, solution = result.dataset.sel(solver="mdr"), result.solutions["mdr"]
    lost = dataset.assign(indentation=dataset["indentation"] * np.nan)
    broken = {one.name for one in anchors(result.scene, "mdr", lost, solution) if not one.holds}
    assert "flat start, d = F / (2 a E*)" in broken
