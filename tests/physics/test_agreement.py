"""Verdicts: methods agree on sensible scenes, and a wrong result is a disagreement."""

import pickle
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from given import judge

from ringwear import Scene, run

BUNDLED = sorted(
    file.stem for file in (Path(__file__).parents[2] / "studies" / "scenes").glob("*.toml")
)
FLAT = [name for name in BUNDLED if Scene.load(name).problem.full_contact]
ON_LAYERS = [name for name in FLAT if Scene.load(name).half_space.layers]


def undecided(result):
    return {row.quantity: row for row in result.agreement if row.verdict == "undecided"}


def meshed():
    """Yield flat scenes with a mesher; triangles are for the night, but for one scene."""
    for name in FLAT:
        # its 32 rings take as long as all other scenes together, and those on layers longer than
        # most
        slow = [pytest.mark.slow] * (name in (*ON_LAYERS, "washer"))
        night = [pytest.mark.nightly] * (name == "many_rings")
        yield pytest.param(name, "quads", marks=[pytest.mark.gmsh, *slow, *night])
        # layers are meshed in quadrilaterals; gmsh's triangles of 32 rings take two minutes, and
        # test_invariants.py has these
        if name not in (*ON_LAYERS, "many_rings"):
            yield pytest.param(name, "gmsh", marks=[pytest.mark.gmsh, pytest.mark.nightly])
        if name in ("five_rings", "rotating_pin", "rubber"):
            night = [pytest.mark.nightly] * (name != "rotating_pin")
            yield pytest.param(name, "bisection", marks=night)


@pytest.mark.parametrize(("name", "mesher"), [*meshed()])
def test_bundled_scenes_agree(name, mesher):
    scene = Scene.load(name).changed(accuracy__fem__mesher=mesher)
    if mesher == "bisection":
        # at rtol 1e-4, these triangles take most of the time; those of gmsh are tried there
        scene = scene.changed(accuracy__rtol=1e-3)
    result = run(scene)
    assert result.verdict != "disagree"
    # another process can return each of them
    assert pickle.loads(pickle.dumps(result.solutions)).keys() == result.solutions.keys()
    if mesher == "quads":
        # fields of 32 rings may miss rtol because of cost, and a remark says so
        rows = undecided(result)
        fields = {"pressure", "rms_slope", "steady_rms_slope"}
        assert rows.keys() <= (fields if name == "many_rings" else set())
        assert all("so many rings" in row.remark for row in rows.values())


@pytest.mark.slow
@pytest.mark.gmsh
@pytest.mark.parametrize("name", [name for name in BUNDLED if name not in FLAT])
def test_bundled_scenes_of_any_punch_agree(name):
    result = run(Scene.load(name))
    assert result.verdict != "disagree"
    assert pickle.loads(pickle.dumps(result.solutions)).keys() == result.solutions.keys()
    # fields at moving edges are accurate to one cell only and may be undecided
    decided = {"indentation", "normal_force"}
    if name == "duty_cycle":
        decided |= {"ring_force", "ring_worn_volume"}
    assert not undecided(result).keys() & decided
    # methods differ by at most the sum of their estimates
    assert all(row.difference <= row.uncertainty + 1e-12 for row in result.agreement)


@pytest.fixture(scope="module")
def flat():
    scene = Scene.load("flat_punch").changed(methods=["mdr", "fem"], accuracy__rtol=1e-3)
    return run(scene.changed(wear__times=[0.0, 0.1, 1.0]))


def compare(flat, factors, errors=None):
    """Compare MDR with finite elements whose results are scaled or whose estimates are replaced."""
    mdr, fem = flat.solutions["mdr"], flat.solutions["fem"]
    # a height is stored with and without even wear
    without = {"profile": "shape", "indentation": "depth"}
    factors = factors | {without.get(name, name): factor for name, factor in factors.items()}
    wrong = fem.compared | {
        name: factors[name] * fem.compared[name] for name in factors.keys() & fem.compared.keys()
    }
    changed = replace(fem, compared=wrong, errors=fem.errors | (errors or {}))
    rows = judge(flat.scene, mdr=mdr, fem=changed).agreement
    return {row.quantity: row for row in rows}


@pytest.mark.gmsh
@pytest.mark.parametrize("factor", [0.98, 1.02])
def test_a_result_wrong_by_two_per_cent_is_a_disagreement(flat, factor):
    quantities = flat.quantities
    assert len(quantities) == 31
    # the whole face of a flat punch is in contact from the time 0 on
    for wrong in quantities.keys() - {"time_to_full_contact"}:
        rows = compare(flat, {wrong: factor})
        assert [name for name, row in rows.items() if row.verdict == "disagree"] == [wrong]
    assert flat.verdict == "agree"


def test_a_quantity_with_a_large_error_estimate_is_undecided(flat):
    """With an estimate above rtol the methods never agree; beyond the estimate they disagree."""
    unsure = {"profile": np.array([1e-5, 0.2, 1e-5])}
    row = compare(flat, {}, unsure)["profile"]
    assert row.verdict == "undecided"
    assert row.uncertainty == pytest.approx(0.2, rel=0.01)
    # the remark names the method and its error, and says which rtol to give
    assert row.when == "at 1 of 3 times"
    assert "fem states 2.0e-01" in row.remark
    assert "rtol" in row.remark
    assert compare(flat, {"profile": 1.5}, unsure)["profile"].verdict == "disagree"


@pytest.mark.slow
@pytest.mark.gmsh
def test_times_too_early_to_resolve_are_named_and_left_out():
    """As t tends to zero, the slope is that of an ever thinner layer at the rim."""
    scene = Scene.load("flat_punch").changed(
        methods=["mdr", "fem"], accuracy__rtol=1e-6, wear__times=[1e-10, 0.1]
    )
    result = run(scene)
    row = undecided(result)["rms_slope"]
    assert row.when == "at t = 1e-10"
    assert "choose later times" in row.remark
    assert not row.promised
    assert result.verdict == "agree"
    # the first line names the quantity that is left out, and the summary gives the reason
    left_out = "Undecided while the layers that wear has made are thin, at t = 1e-10: RMS slope."
    assert result.verdict_in_words.endswith(f" quantities. {left_out}")
    rows = {row["quantity"]: row for row in result.summary["left_out_of_promise"]}
    assert rows.keys() == {"rms_slope"}
    assert all(row["times"] == [1e-10] for row in rows.values())
    assert "choose later times" in rows["rms_slope"]["reason"]
    # the later time is not affected
    assert result.solutions["mdr"].errors["rms_slope"][1] < 1e-6
