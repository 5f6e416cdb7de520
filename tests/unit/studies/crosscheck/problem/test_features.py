"""Features of problems that methods may refuse, and the quantities that every problem has."""

import pytest
from loads import LOADS, pressed_by

from ringwear import Scene, SceneError
from ringwear.studies.crosscheck.methods.evaluation import FullContact
from ringwear.studies.crosscheck.methods.moving_evaluation import MovingContact
from ringwear.studies.crosscheck.problem.quantities import ANSWER, DESCRIBED, HISTORIES, QUANTITIES

FEATURES = {
    "force": (),
    "rising": ("varying load",),
    "falling": ("moving contact", "varying load"),
    "falling slowly": ("varying load",),
    "speed": ("varying load",),
    "indentation": ("fixed indentation",),
    "indentation and speed": ("fixed indentation", "varying load"),
}


@pytest.mark.parametrize("name", LOADS)
def test_features_of_a_flat_punch_follow_from_its_load(name):
    problem = pressed_by(**LOADS[name]).problem
    assert problem.features == FEATURES[name]
    assert {problem.prescribed, problem.response} == {"normal_force", "indentation"}
    assert ("fixed indentation" in problem.features) == (problem.prescribed == "indentation")
    assert problem.remaining_parts.keys() <= ANSWER.keys()
    for time, part in problem.remaining_parts.items():
        assert ANSWER[time].remaining == part


def test_features_of_a_sphere_of_layers_and_of_wear_along_the_radius():
    assert Scene.load("sphere").problem.features == ("moving contact",)
    assert Scene.load("hard_film").problem.features == ("layers",)
    wear = {"radii": [0.0, 1.0], "values": [1.0, 2.0]}
    punch = {"radius": 1.0, "wear_coefficient": wear}
    graded = Scene.from_table(Scene.load("five_rings").table() | {"punch": punch}).problem
    assert graded.features == ("wear along the radius",)


def test_names_of_quantities_are_known():
    assert FullContact.floors.keys() | MovingContact.floors.keys() <= DESCRIBED.keys()
    assert {number.at[0] for number in ANSWER.values() if number.at} <= QUANTITIES.keys()


def test_a_punch_that_loses_contact_has_no_relaxation_times():
    problem = pressed_by(**LOADS["falling"]).problem
    with pytest.raises(SceneError, match="has none of them"):
        problem.with_quantities(frozenset({"relaxation_time"}))
    assert problem.with_quantities(frozenset(DESCRIBED)).quantities >= HISTORIES
