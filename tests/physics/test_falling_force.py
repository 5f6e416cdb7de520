"""Flat punches whose force falls: contact stays full, or is lost where wear is too slow.

Whether contact stays full is predicted by a small solution. If it does, the relaxation modes solve
the problem, and the independent solution is valid.
"""

from dataclasses import replace

import pytest
from independent import solved
from random_scenes import draw, hold, loses_contact

from ringwear import Scene, SolverError, Stages, method

FIVE = Scene.load("five_rings")


def under(values, times=(0.0, 1.0), **changes):
    """Return five rings under a force over time, by dimensionality reduction."""
    force = {"times": list(times), "values": list(values)}
    return FIVE.changed(methods=["mdr"], load__normal_force=force, **changes)


@pytest.mark.nightly
def test_the_prediction_agrees_with_the_independent_solution():
    kept = []
    for number in range(25):
        problem = draw("load", 8, number).problem
        if problem.loading.rising:
            continue
        *_, punch = solved(problem, min(problem.rtol, 1e-3))
        assert problem.keeps_contact != loses_contact(problem, punch)
        kept.append(problem.keeps_contact)
    # both cases occur
    assert 2 <= sum(kept) <= len(kept) - 2


@pytest.mark.parametrize(("last", "kept"), [(0.5, True), (0.3, False)])
def test_wear_along_the_radius_is_predicted(last, kept):
    """With the mean wear coefficient all over the face, contact would be lost at both forces."""
    scene = under(
        [1.0, 1.0, last],
        [0.0, 1.0, 2.0],
        punch={"radius": 1.0, "wear_coefficient": {"radii": [0.0, 1.0], "values": [1.0, 0.02]}},
        wear__times=[0.0, 3.0],
    )
    *_, punch = solved(scene.problem, 1e-3)
    assert loses_contact(scene.problem, punch) == (not kept)
    assert scene.problem.keeps_contact == kept


@pytest.mark.slow
@pytest.mark.parametrize(("seed", "number"), [(8, 12), (8, 24), (11, 16)])
def test_histories_by_modes_agree_with_the_independent_solution(seed, number):
    """By steps, pressures and slopes of thin layers were left out, as known to a cell only."""
    scene = draw("load", seed, number)
    assert scene.problem.keeps_contact
    row = hold(scene, "mdr", "bem")
    assert row.verdict == "agree"
    assert not row.lost_contact
    assert not row.excluded
    assert not row.beyond


WHOLE = FIVE.wear.times


@pytest.mark.parametrize(
    ("values", "times", "shown", "keeps_contact"),
    [
        ([2.0, 1.0], [0.0, 1.0], WHOLE, True),
        # hardly anything has worn yet
        ([2.0, 1.0], [0.0, 1e-4], WHOLE, True),
        ([2.0, 2.0, 1.0], [0.0, 0.5, 0.501], WHOLE, False),
        ([2.0, 0.0], [0.0, 1.0], WHOLE, False),
        ([2.0, 2.0, 1.0, 1.5], [0.0, 0.5, 5.0, 6.0], WHOLE, True),
        # the history may end before the fall
        ([2.0, 2.0, 0.0], [0.0, 50.0, 50.1], [1.0, 40.0], True),
        ([2.0, 2.0, 0.0], [0.0, 50.0, 50.1], [1.0, 60.0], False),
    ],
)
def test_contact_is_lost_if_the_force_falls_too_fast(values, times, shown, keeps_contact):
    assert under(values, times, wear__times=shown).problem.full_contact == keeps_contact


def test_contact_is_lost_if_the_force_falls_while_the_punch_stands_still():
    speed = {"times": [0.0, 1.0, 1.1, 2.0, 2.1], "values": [1.0, 1.0, 0.0, 0.0, 1.0]}
    falls = under([2.0, 2.0, 1.9, 1.9], [0.0, 1.2, 1.8, 3.0], load__sliding_speed=speed)
    assert not falls.problem.full_contact
    # before it slides for the first time, the face is flat, and any force presses everywhere
    speed = {"times": [0.0, 1.0, 1.1], "values": [0.0, 0.0, 1.0]}
    before = under([2.0, 1.0, 1.0], [0.0, 0.8, 1.0], load__sliding_speed=speed)
    assert before.problem.full_contact
    # nor does a stop matter after the end of the history
    speed = {"times": [0.0, 1.0, 1.01, 1.2, 1.21], "values": [1.0, 1.0, 0.0, 0.0, 1.0]}
    force = [2.0, 1.9, 1.9, 1.8], [0.0, 0.5, 1.02, 1.1]
    assert not under(*force, load__sliding_speed=speed).problem.keeps_contact
    ends = under(*force, load__sliding_speed=speed, wear__times=[0.1, 0.8])
    assert ends.problem.keeps_contact


def test_punches_with_layers_or_a_profile_are_marched():
    elastic = {"youngs_modulus": 1.0, "poisson_ratio": 0.3}
    half_space = elastic | {"layers": [elastic | {"thickness": 0.5}]}
    layered = Scene.from_table(under([2.0, 1.0]).table() | {"half_space": half_space})
    assert not layered.problem.full_contact
    cone = under([2.0, 1.0], punch__profile={"kind": "cone", "slope": 0.1})
    assert not cone.problem.full_contact


def test_relaxation_times_alone_can_be_requested():
    scene = under([2.0, 1.0], output__quantities=["relaxation_time"])
    assert scene.problem.keeps_contact
    assert scene.problem.quantities == {"relaxation_time"}


def test_a_wrong_prediction_raises_instead_of_returning_tension():
    fast = under([2.0, 0.2], [0.0, 1e-3])
    assert not fast.problem.keeps_contact
    wrong = replace(fast.problem, keeps_contact=True)
    with pytest.raises(SolverError, match=r"pressure becomes negative by t = .*falls"):
        method("mdr").solve(wrong, Stages("mdr"))
