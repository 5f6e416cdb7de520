"""A fault put into one method, or into what all share, is found out.

By the verdict or by what no method can move.
"""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from ringwear import Scene, run
from ringwear.meshes.compliance import Compliance
from ringwear.meshes.pressure_space import PressureSpace
from ringwear.studies.crosscheck.anchors import anchors
from ringwear.studies.methods.fem import Fem
from ringwear.studies.methods.mdr import Mdr
from ringwear.studies.methods.sampler import Sampler
from ringwear.studies.problem.problem import Problem, Rings
from ringwear.studies.wear import full_contact
from ringwear.studies.wear.modes import Modes

Fault = Callable[[pytest.MonkeyPatch], None]


def change_result(owner, name, change):
    """A function returns something else."""

    def put(patch):
        right = getattr(owner, name)
        patch.setattr(owner, name, lambda *given, **named: change(right(*given, **named)))

    return put


def scale_compliance(method, size):
    """The compliance of a method is too great."""

    def soften(compliance):
        return Compliance(compliance.space, compliance.factor * np.sqrt(1 + size))

    def change(ready):
        coarser = ready.coarser
        return replace(
            ready, compliance=soften(ready.compliance), coarser=lambda: soften(coarser())
        )

    return change_result(method, "discretise", change)


def change_rings(change):
    """The finite elements solve another punch."""

    def put(patch):
        right = Fem.solve_all

        def wrong(method, problems, stages):
            changed = [replace(problem, rings=change(problem.rings)) for problem in problems]
            return right(method, changed, stages)

        patch.setattr(Fem, "solve_all", wrong)

    return put


def harden(rings):
    factors = np.where(np.arange(len(rings.widths)) == 2, 1 + 1e-4, 1.0)
    return Rings(rings.ring_edges, rings.wear_coefficients * factors)


def shift(rings):
    shifts = np.where(np.arange(len(rings.ring_edges)) == 2, 3e-6, 0.0)
    return Rings(rings.ring_edges + shifts, rings.wear_coefficients)


def scale_weights(size):
    """Every pressure counts for more force than it has, in all methods."""

    def put(patch):
        right = PressureSpace.weights.func  # type: ignore[attr-defined]
        patch.setattr(PressureSpace, "weights", property(lambda space: (1 + size) * right(space)))

    return put


def scale_both(size):
    def put(patch):
        for method in (Mdr, Fem):
            scale_compliance(method, size)(patch)

    return put


FAULTS = {
    "fem's compliance": (scale_compliance(Fem, 5e-6), 5e-6),
    "fem's compliance, by much": (scale_compliance(Fem, 1e-3), 1e-3),
    "mdr's compliance": (scale_compliance(Mdr, 5e-6), 5e-6),
    "a wear coefficient in one method": (change_rings(harden), 1e-4),
    "a ring edge in one method": (change_rings(shift), 3e-6),
    "both compliances": (scale_both(1e-5), 1e-5),
    "both compliances, by much": (scale_both(0.1), 0.1),
    "pressure weights in both": (scale_weights(1e-3), 1e-3),
}
# without gmsh the finite elements are of lower degree, and reach less
ACCURACIES = [pytest.param(1e-6, marks=pytest.mark.gmsh), 1e-4]


def five_rings(methods, rtol=1e-4):
    times = [0.0, 0.01, 0.1, 1.0]
    scene = Scene.load("five_rings")
    return run(scene.changed(methods=methods, accuracy__rtol=rtol, wear__times=times))


@pytest.mark.parametrize(
    ("fault", "rtol", "methods"),
    [
        pytest.param(fault, rtol, methods, marks=marks)
        for fault, (_, size) in FAULTS.items()
        for rtol, methods, marks in (
            (1e-6, ["mdr", "fem"], pytest.mark.gmsh),
            (1e-4, ["mdr", "fem"], ()),
            (1e-4, ["mdr", "direct", "fem"], ()),
        )
        if size >= rtol
    ],
    ids=str,
)
def test_faults_are_caught(monkeypatch, fault, rtol, methods):
    """Those that are not smaller than the accuracy asked for."""
    FAULTS[fault][0](monkeypatch)
    assert five_rings(methods, rtol).verdict == "disagree"


@pytest.mark.gmsh
@pytest.mark.parametrize("rtol", ACCURACIES)
def test_without_a_fault_nothing_disagrees(rtol):
    result = five_rings(["mdr", "bem", "direct", "fem"], rtol)
    assert rtol < 1e-4 or result.verdict == "agree"
    # pressures at the start, infinite at the rim, and early slopes finite elements do not promise
    # to that
    assert {row.quantity for row in result.agreement if not row.agrees} <= {"pressure", "rms_slope"}
    assert result.verdict != "disagree"
    assert all(anchor.holds for anchor in result.anchors)
    assert {anchor.method for anchor in result.anchors} == {"mdr", "bem", "direct", "fem"}


def lose_mode(number):
    def change(modes):
        others = np.arange(len(modes.relaxation)) != number - 1
        return Modes(
            modes.relaxation[others],
            modes.shapes[:, others],
            modes.amplitudes[others],
            modes.exact - 1,
        )

    return change_result(full_contact, "every_mode", change)


def slow_down(size):
    def change(modes):
        factors = np.where(np.arange(len(modes.relaxation)) == 0, 1 + size, 1.0)
        return replace(modes, relaxation=modes.relaxation * factors)

    return change_result(full_contact, "every_mode", change)


def scale_reported(name, size, start=True, on_face=True):
    """A quantity of all methods is too great.

    From the start or later, on all of the face or at the radii of the output.
    """

    def put(patch):
        for part in ("history", "steady"):
            right = getattr(Sampler, part)

            def wrong(sampler, state, whole_face=False, right=right):
                values = right(sampler, state, whole_face)
                if name not in values or (whole_face and not on_face):
                    return values
                later = True if start else values["time"] > 0
                return values.assign({name: values[name] * (1 + size * later)})

            patch.setattr(Sampler, part, wrong)

    return put


def move_force(size):
    """A part of the force on the second ring is said to be on the third."""
    moved = size * np.array([0, -1, 1, 0, 0])
    return change_result(Sampler, "ring_forces", lambda forces: forces + moved)


def delay(size):
    """Times at the door are too late."""
    return change_result(
        Problem, "posed", lambda problem: replace(problem, times=problem.times * (1 + size))
    )


SMALL = 3e-4
SIZES = (0.1, 1e-2, 1e-3, SMALL)
FIELDS = ("pressure", "profile", "displacement")
NUMBERS = ("displacement_max", "displacement_centre", "rms_slope")
STEADY = ("pressure", "displacement_max", "rms_slope", "wear_rate")
COMMON_FAULTS = {
    **{f"mode {number} lost": lose_mode(number) for number in (1, 3, 6)},
    **{f"slowest tau {size:g}": slow_down(size) for size in SIZES[1:]},
    **{
        f"{name} {size:g}": scale_reported(name, size)
        for name in FIELDS + NUMBERS
        for size in SIZES
    },
    **{
        f"later indentation {size:g}": scale_reported("indentation", size, start=False)
        for size in SIZES[1:]
    },
    **{f"ring force moved {size:g}": move_force(size) for size in (1e-2, SMALL)},
    **{
        f"steady_{name} {size:g}": scale_reported(f"steady_{name}", size)
        for name in STEADY
        for size in (1e-2, SMALL)
    },
    # of the greatest displacement, which is its norm, that is a third
    "steady_profile 1e-3": scale_reported("steady_profile", 1e-3),
    **{f"times {size:g}": delay(size) for size in (1e-2, SMALL)},
    **{
        f"{name} at output radii {size:g}": scale_reported(name, size, on_face=False)
        for name in FIELDS
        for size in (0.1, SMALL)
    },
}


@pytest.mark.parametrize("fault", COMMON_FAULTS)
def test_faults_that_all_methods_share_are_caught(monkeypatch, fault):
    """With nothing to compare with: by what no method can move, at an accuracy of 1e-4."""
    COMMON_FAULTS[fault](monkeypatch)
    assert five_rings(["mdr"]).verdict == "disagree"


@pytest.fixture(scope="module")
def right():
    return five_rings(["mdr"])


@pytest.mark.parametrize(
    ("name", "factor", "anchor"),
    [
        ("indentation", 1.001, "flat start, d = F / (2 a E*)"),
        # no number holds to nothing
        ("indentation", np.nan, "flat start, d = F / (2 a E*)"),
        ("indentation", 1.001, "reciprocity with the flat punch"),
        ("ring_force", 1.001, "ring forces add up to F"),
        ("relaxation_time", 1.001, "slowest relaxation time, by a small problem of its own"),
        ("steady_wear_rate", 1.001, "steady_wear_rate in closed form"),
        ("worn_volume", 1.001, "worn volume of the answer over k, F v0 t"),
        ("indentation_start", 1.001, "flat start of the answer"),
        ("pressure_min", 1.001, "steady pressures of the answer"),
    ],
)
def test_anchors_hold_what_is_written(right, name, factor, anchor):
    """A dataset that is wrong by itself, whatever the method knows."""

    def broken(dataset):
        rows = anchors(right.scene, "mdr", dataset, right.solutions["mdr"])
        return {row.name for row in rows if not row.holds}

    dataset = right.dataset.sel(solver="mdr")
    assert not broken(dataset)
    assert anchor in broken(dataset.assign({name: factor * dataset[name]}))
