"""Regimes of contact and load of a problem, and tables that must contain every regime."""

import pytest

from ringwear import Scene, SceneError, method
from ringwear.studies.anchors.checks import CONTACT_ANCHORS, RESPONSE_ANCHORS
from ringwear.studies.methods.fem import DISCRETISED, HALF_SPACES
from ringwear.studies.methods.pipeline import PIPELINES
from ringwear.studies.methods.spaces import SPACES
from ringwear.studies.predictions.plan import DENSE_WORK
from ringwear.studies.problem.quantities import ANSWER, QUANTITIES
from ringwear.studies.problem.regimes import (
    FALLING_FORCE,
    FIXED_INDENTATION,
    FULL_CONTACT,
    INDENTATION_AT_VARYING_SPEED,
    LOADS,
    MOVING_CONTACT,
    ONE_FORCE,
    VARYING_FORCE,
)
from ringwear.studies.sampling.sampler import FIELDS, WORN_VOLUMES

RISING = {"times": [0.0, 1.0], "values": [1.0, 2.0]}
FALLING = {"times": [0.0, 1.0], "values": [2.0, 0.2]}
FALLING_SLOWLY = {"times": [0.0, 1.0], "values": [2.0, 1.0]}


def pressed_by(**load):
    return Scene.from_table(Scene.load("five_rings").table() | {"load": load}).problem


@pytest.mark.parametrize(
    ("load", "contact", "regime"),
    [
        ({"normal_force": 1.0}, FULL_CONTACT, ONE_FORCE),
        ({"normal_force": RISING}, FULL_CONTACT, VARYING_FORCE),
        ({"normal_force": FALLING}, MOVING_CONTACT, VARYING_FORCE),
        ({"normal_force": FALLING_SLOWLY}, FULL_CONTACT, FALLING_FORCE),
        ({"normal_force": 1.0, "sliding_speed": FALLING}, FULL_CONTACT, VARYING_FORCE),
        ({"indentation": 1.0}, FULL_CONTACT, FIXED_INDENTATION),
        (
            {"indentation": 1.0, "sliding_speed": FALLING},
            FULL_CONTACT,
            INDENTATION_AT_VARYING_SPEED,
        ),
    ],
    ids=[
        *("force", "rising", "falling", "falling slowly"),
        *("speed", "indentation", "indentation and speed"),
    ],
)
def test_contact_and_load_of_a_flat_punch(load, contact, regime):
    problem = pressed_by(**load)
    assert (problem.contact, problem.load_regime) == (contact, regime)
    assert not problem.merged.linear


def test_contact_of_a_sphere_and_wear_along_the_radius():
    assert Scene.load("sphere").problem.contact is MOVING_CONTACT
    wear = {"radii": [0.0, 1.0], "values": [1.0, 2.0]}
    punch = {"radius": 1.0, "wear_coefficient": wear}
    graded = Scene.from_table(Scene.load("five_rings").table() | {"punch": punch}).problem
    assert graded.merged.linear


def test_every_table_has_every_regime():
    for table in (
        *(PIPELINES, SPACES, DISCRETISED, HALF_SPACES, DENSE_WORK),
        *(CONTACT_ANCHORS, FIELDS, WORN_VOLUMES),
    ):
        assert set(table) == {FULL_CONTACT, MOVING_CONTACT}
    assert set(RESPONSE_ANCHORS) == {regime.response for regime in LOADS.values()}


def test_names_of_quantities_and_numbers_are_known():
    for contact in (FULL_CONTACT, MOVING_CONTACT):
        assert contact.quantities_missing <= QUANTITIES.keys()
        assert contact.compared_numbers <= ANSWER.keys()
    for load in LOADS.values():
        assert load.added_quantities | load.decaying <= QUANTITIES.keys()
        assert {
            *load.remaining_fractions,
            *load.reported_forces,
        } | load.numbers_missing <= ANSWER.keys()


@pytest.mark.parametrize(
    ("load", "missing"),
    [
        ({"normal_force": 1.0}, {"normal_force", "ring_worn_volume", "contact_radius"}),
        ({"normal_force": RISING}, {"ring_worn_volume", "contact_radius"}),
        ({"indentation": 1.0}, {"contact_radius"}),
        ({"normal_force": FALLING}, {"relaxation_time"}),
        ({"normal_force": FALLING_SLOWLY}, set()),
    ],
    ids=["force", "rising", "indentation", "falling", "falling slowly"],
)
def test_each_load_has_its_missing_quantities(load, missing):
    problem = pressed_by(**load)
    assert problem.quantities_missing - {"contact", "contact_edge"} == missing
    if missing:
        with pytest.raises(SceneError, match="has none of them"):
            problem.with_quantities(frozenset(missing))


def test_methods_refuse_the_regimes_of_their_tables():
    varying, fixed = pressed_by(normal_force=RISING), pressed_by(indentation=1.0)
    assert "constant force" in method("mdr-grid").refusal(varying)
    assert "nothing presses in the end" in method("direct").refusal(fixed)
    assert not method("mdr").refusal(varying)
