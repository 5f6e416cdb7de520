"""Scenes with recesses, profiles and fixed indentations: keys, refusals and results."""

import numpy as np
import pytest
from closed_forms import PowerPunch
from groups import nightly_but
from natural import natural

from ringwear import Scene, SceneError, run, sweep

LENGTH, MODULUS, FORCE = 2.0, 5.0, 0.3
SCENE = natural(
    {"radius": LENGTH, "ring_edges": [0.8, 1.4, LENGTH], "wear_coefficients": [1, 10]},
    [0.0, 0.1, 1.0],
    methods="mdr",
    half_space={"plane_strain_modulus": MODULUS},
    load={"normal_force": FORCE},
)
# for the plane strain modulus 1: forces are to be divided by MODULUS
EXACT_SPHERE = PowerPunch(1 / (2 * 8.0), 2)


@pytest.mark.slow
def test_all_ways_to_give_a_profile_agree(tmp_path):
    radii = np.linspace(0.0, LENGTH, 41)
    rows = np.column_stack([radii, radii**2 / 16])
    np.savetxt(tmp_path / "profile.csv", rows, delimiter=",", header="radius,height", comments="")
    flat = SCENE.changed(wear__times=[0.0])
    file = tmp_path / "scene.toml"
    profile = "[punch.profile]\nkind = 'table'\nfile = 'profile.csv'\n"
    file.write_text(f"{flat.to_toml()}\n{profile}", "utf-8")
    power = {"kind": "power", "coefficient": LENGTH**2 / 16, "exponent": 2.0}
    ways = {
        "power": flat.changed(punch__profile=power),
        "function": flat.with_heights(lambda r: r**2 / 16),
        "sum": flat.with_heights(lambda r: r**2 / 32, lambda r: r**2 / 32),
        "table": Scene.load(file),
    }
    depth = EXACT_SPHERE.indentation(EXACT_SPHERE.contact_radius(FORCE / MODULUS))
    for name, scene in ways.items():
        tolerance = 2e-3 if name == "table" else 1e-8
        value = float(run(scene).dataset.indentation.squeeze())
        assert value == pytest.approx(depth, rel=tolerance), name
    # a scene keeps the heights of its file when written, and its functions when changed
    assert Scene.from_toml(ways["table"].to_toml()) == ways["table"]
    assert ways["function"].changed(accuracy__rtol=1e-2).punch.heights


def test_recesses_and_profiles_add():
    assert SCENE.problem.full_contact
    assert SCENE.changed(punch__recess=[0.0, 0.0, 0.0]).problem.full_contact
    problem = SCENE.changed(punch__recess=[0.0, 0.02, 0.01]).with_heights(lambda r: 0.1 * r).problem
    assert not problem.full_contact
    heights = problem.profile(np.array([0.1, 0.5, 0.9])) * SCENE.problem.units.displacement
    assert heights == pytest.approx([0.02, 0.12, 0.19])


def table(radii, heights):
    return {"punch__profile": {"kind": "table", "radii": radii, "heights": heights}}


def test_negative_heights_are_refused():
    with pytest.raises(SceneError, match="missing, 0 or more"):
        _ = SCENE.with_heights(lambda r: r - 0.5).problem


def test_an_indentation_that_does_not_touch_is_refused():
    with pytest.raises(SceneError, match=r"the nearest point of the punch is 0\.01 from"):
        run(SCENE.changed(punch__recess=[0.01, 0.02, 0.01], load={"indentation": 0.005}))


def test_a_sweep_over_spheres_agrees_with_hertz():
    axes = {"punch.profile.curvature_radius": [1.0, 2.0], "load.indentation": [0.01, 0.04]}
    data = sweep(Scene.load("sphere").changed(methods=["mdr"], wear__times=[0.0, 1e-3]), axes)
    assert data["indentation"].dims == ("indentation",)
    start = data.sel(solver="mdr", time=0.0)
    radius, depth = data["curvature_radius"], data["indentation"]
    force = 4 / 3 * np.sqrt(radius) * depth**1.5
    np.testing.assert_allclose(start["normal_force"], force, rtol=1e-6)
    np.testing.assert_allclose(start["contact_radius"], np.sqrt(radius * depth), rtol=1e-6)
    assert (data["status"] == 1).all()


@pytest.mark.slow
def test_a_sweep_takes_flat_and_recessed_punches():
    scene = SCENE.changed(methods=["mdr"], wear__times=[0.0, 0.1], accuracy__rtol=1e-3)
    recesses = [[0.0, 0.0, 0.0], [0.0, 0.1, 0.0]]
    keep = ["worn_volume", "contact_radius", "relaxation_time", "force_share"]
    data = sweep(scene, {"punch.recess": recesses}, keep=keep).sel(solver="mdr")
    # shaped punches have no relaxation times while their contact may change
    assert data["relaxation_time"][:, 0].isnull().values.tolist() == [False, True]
    assert data["contact_radius"][0].values == pytest.approx(SCENE.problem.units.length)
    assert not data["contact_radius"].isnull().any()
    for recess, worn, share in zip(recesses, data["worn_volume"], data["force_share"], strict=True):
        alone = run(scene.changed(punch__recess=recess)).answers["mdr"]
        np.testing.assert_allclose(worn, alone["worn_volume"], rtol=1e-3)
        np.testing.assert_allclose(share, alone["force_share"], atol=1e-3)


DEGENERATE = {
    "never touches": SCENE.changed(punch__recess=[0.0, 10.0, 0.0]),
    "plateau": SCENE.changed(**table([0.0, 0.7, 0.8, 2.0], [0.01, 0.01, 0.0, 0.0])),
    "noise": SCENE.with_heights(lambda r: 1e-3 * (1 + np.sin(1e4 * r) * np.cos(3e3 * r**2))),
    "far apart": SCENE.changed(punch__recess=[5.0, 5.0, 0.0]),
    "no width": SCENE.changed(punch__profile={"kind": "cone", "slope": 1e3}),
    "one point": SCENE.changed(punch__profile={"kind": "parabola", "curvature_radius": 1e-3}),
}


@pytest.mark.slow
@pytest.mark.parametrize(
    "face",
    nightly_but(("one point", "noise"), DEGENERATE),
)
def test_degenerate_faces_converge(face):
    data = run(DEGENERATE[face].changed(wear__steady=False)).dataset
    assert (data.pressure >= -1e-6 * data.pressure.max()).all()
    assert np.array(data.normal_force) == pytest.approx(FORCE, rel=1e-8)
    assert np.isfinite(data.indentation).all()
