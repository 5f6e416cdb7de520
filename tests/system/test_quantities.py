"""`output.quantities`: only these are computed, to the accuracy of `rtol`."""

from functools import cache

import numpy as np
import pytest
from groups import nightly
from independent import true_errors

from ringwear import Scene, run
from ringwear.studies.crosscheck import ANSWER

FIVE = Scene.load("five_rings").changed(methods=["mdr", "fem"])
PAIR = ["indentation", "relaxation_time"]


@cache
def whole(rtol):
    """Return the run of all quantities."""
    return run(FIVE.changed(accuracy__rtol=rtol))


def stored(result):
    """Return the quantities of a result, without numbers of the answer."""
    return {name for name in result.dataset if not name.endswith("_error")} - ANSWER.keys()


def in_group(name, result):
    """Return the quantities of a group, of all quantities in a result."""
    quantities, dataset = stored(result), result.dataset
    fields = {each for each in quantities if {"time", "radius"} <= set(dataset[each].dims)}
    over_time = {each for each in quantities if "time" in dataset[each].dims}
    groups = {
        "all": quantities,
        "fields": fields,
        "history": over_time - fields | {"relaxation_time"},
        "steady": {each for each in quantities if each.startswith("steady_")},
    }
    return groups.get(name, {name})


@pytest.mark.gmsh
@pytest.mark.parametrize(
    "names",
    [["history"], ["fields"], ["steady"], ["all"], PAIR, ["ring_force"]],
    ids=str,
)
def test_a_run_has_only_the_quantities_of_the_scene(names):
    everything = whole(1e-2)
    result = run(FIVE.changed(accuracy__rtol=1e-2, output__quantities=names))
    wanted = set().union(*(in_group(name, everything) for name in names))
    assert result.verdict == "agree"
    assert stored(result) == wanted
    assert result.quantities.keys() - ANSWER.keys() == wanted - {"contact", "contact_edge"}
    along_radius = {name for name in wanted if "radius" in everything.dataset[name].dims}
    assert result.has_inside == bool(along_radius - {"steady_pressure"})
    if names != ["all"]:
        assert "all other quantities" in result.summary["left_out"]


@pytest.mark.slow
@pytest.mark.gmsh
@pytest.mark.parametrize("names", [PAIR, ["indentation"]], ids=str)
@pytest.mark.parametrize("rtol", [1e-4, *nightly(1e-1, 1e-6)])
def test_energies_alone_take_fewer_unknowns(rtol, names):
    """Their true errors are within their estimates and within `rtol`."""
    alone = run(FIVE.changed(accuracy__rtol=rtol, output__quantities=names))
    for name, errors in true_errors(alone).items():
        assert alone.solutions[name].unknowns <= whole(rtol).solutions[name].unknowns
        assert {*names} <= errors.keys()
        for error, estimate in errors.values():
            assert (error <= np.minimum(estimate, rtol)).all()
    if rtol <= 1e-4:
        # the eighth relaxation time needs elements of nearly the same degree as fields do
        fewer = 2 if names == ["indentation"] else 1
        assert fewer * alone.solutions["fem"].unknowns < whole(rtol).solutions["fem"].unknowns


@pytest.mark.slow
@pytest.mark.gmsh
@pytest.mark.parametrize(
    ("scene", "name"),
    [
        ("sphere", "pressure"),
        *nightly(("sphere", "indentation"), ("sphere", "steady")),
        ("recessed_binder", "contact_radius"),
    ],
)
def test_a_shaped_punch_has_only_the_quantities_of_the_scene(scene, name):
    scene = Scene.load(scene)
    # the start and two times
    scene = scene.changed(accuracy__rtol=1e-2, wear__times=scene.wear.times[:3])
    names = {
        *("steady_pressure", "steady_profile", "steady_displacement_max"),
        *("steady_rms_slope", "steady_wear_rate"),
    }
    wanted = names if name == "steady" else {name}
    assert stored(run(scene.changed(output__quantities=[name]))) == wanted


def test_the_option_quantities_of_the_command(command, tmp_path):
    command(f"run five_rings --methods mdr --rtol 1e-2 --out . --quantities {','.join(PAIR)}")
    assert not {"history.png", "profiles_and_pressures.png"} & {p.name for p in tmp_path.iterdir()}
    assert (tmp_path / "report.html").exists()
