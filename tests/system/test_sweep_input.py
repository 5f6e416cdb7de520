"""Input of sweeps: functions, files of profiles, units, and axes that contradict each other.

No input is ignored, read twice or misunderstood; impossible input is refused.
"""

import json
import os
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np
import pytest
import tomli_w
import xarray

from ringwear import Scene, SceneError, main, run, sweep

FLAT = Scene.load("flat_punch").changed(
    methods=["mdr"], accuracy__rtol=1e-2, wear__times=[0.0], wear__steady=False, units=""
)
KEEP = ["indentation"]
FORCES = {"load.normal_force": [1.0, 2.0]}


def bowl(radii):
    """Return heights that a scene file cannot express."""
    return radii**2


@pytest.mark.slow
def test_functions_of_the_face_are_in_every_scene():
    """Each scene has the heights that `with_heights` has given to the base."""
    scene = FLAT.with_heights(bowl)
    dataset = sweep(scene, FORCES, keep=KEEP)
    for force in (1.0, 2.0):
        alone = run(scene.changed(load__normal_force=force)).dataset["indentation"].item()
        there = dataset["indentation"].sel(normal_force=force).item()
        assert there == pytest.approx(alone, rel=1e-12)
        # F / (2 a E*) of a flat punch
        assert there > 1.5 * force / 2


@pytest.mark.parametrize(
    "options", [{"store": "out"}, {"workers": 2}, {"executor": ThreadPoolExecutor(1)}], ids=" ".join
)
def test_functions_are_refused_with_a_store_or_workers(tmp_path, monkeypatch, options):
    monkeypatch.chdir(tmp_path)
    with pytest.raises(SceneError, match=r"with_heights.*punch\.profile") as refusal:
        sweep(FLAT.with_heights(bowl), FORCES, keep=KEEP, **options)
    assert "\n" not in str(refusal.value)
    assert os.listdir() == []
    with pytest.raises(SceneError, match=r"punch\.heights"):
        sweep(FLAT, {"punch.heights": [[bowl]]}, keep=KEEP)


def write_profile(path, height):
    np.savetxt(path, [[0.0, 0.0], [0.5, height / 4], [1.0, height]], delimiter=",")


BASE = {
    "methods": ["mdr"],
    "punch": {"radius": 1.0, "rings": 1, "wear_coefficients": [1.0, 1.0]},
    "half_space": {"plane_strain_modulus": 1.0},
    "load": {"normal_force": 1.0},
    "wear": {"times": [0.0], "steady": False},
    "accuracy": {"rtol": 1e-2},
}
BY_FILE = {"kind": "table", "file": "profile.csv"}
PROFILES = {
    "base": (BASE | {"punch": BASE["punch"] | {"profile": BY_FILE}}, FORCES),
    "tables": (BASE, {"punch.profile": [BY_FILE, {"kind": "cone", "slope": 0.1}]}),
    "files": (
        BASE | {"punch": BASE["punch"] | {"profile": BY_FILE}},
        {"punch.profile.file": ["profile.csv", "other.csv"]},
    ),
}


@pytest.mark.slow
@pytest.mark.parametrize("given", PROFILES)
def test_an_edited_profile_makes_another_sweep(tmp_path, monkeypatch, given):
    """The store has the heights, not the name of a file that may change."""
    base, axes = PROFILES[given]
    monkeypatch.chdir(tmp_path)
    write_profile("profile.csv", 0.5)
    write_profile("other.csv", 0.3)
    first = sweep(base, axes, "out", keep=KEEP)["indentation"].load()
    # the store has all input that is needed to compute the scenes again
    stored_table = json.loads(xarray.open_zarr("out/sweep.zarr").attrs["sweep"])
    Path("stored.toml").write_text(tomli_w.dumps(stored_table))
    os.remove("profile.csv")
    os.remove("other.csv")
    assert main(["sweep", "stored.toml", "--out", "again"]) == 0
    xarray.testing.assert_identical(
        xarray.open_zarr("again/sweep.zarr")["indentation"].load(), first
    )
    write_profile("other.csv", 0.3)
    write_profile("profile.csv", 0.9)
    with pytest.raises(SceneError, match="begun with another sweep file"):
        sweep(base, axes, "out", keep=KEEP, resume=True)
    write_profile("profile.csv", 0.5)
    xarray.testing.assert_identical(
        sweep(base, axes, "out", keep=KEEP, resume=True)["indentation"].load(), first
    )


def test_whole_numbers_stay_whole():
    axes = {"punch.rings": {"geomspace": [2, 32, 5]}}
    five = Scene.load("five_rings").changed(methods=["direct"])
    counts = sweep(five, axes, keep=["steady_rms_slope"])["rings"]
    assert counts.values.tolist() == [2, 4, 8, 16, 32]
    assert counts.dtype.kind == "i"


@pytest.mark.parametrize(("units", "size"), [("SI", 1.0), ("", 1.0), ("mm, N, MPa, s", 1e3)])
def test_axes_with_units_are_numbers(tmp_path, units, size):
    """Their unit is that of the axis, which the store has; plain numbers are in it already."""
    table = Scene.load("five_rings").changed(methods=["direct"]).table()
    table |= {"units": units} if units else {}
    if not units:
        table.pop("units", None)
    for radii in (["20 mm", "3 cm", 0.04 * size], {"linspace": ["20 mm", "40 mm", 3]}):
        folder = tmp_path / type(radii).__name__
        sweep(table, {"punch.radius": radii}, folder, keep=["steady_wear_rate"])
        dataset = xarray.open_zarr(folder / "sweep.zarr", decode_timedelta=False)
        there = dataset["punch_radius"]
        assert there.dtype == float
        np.testing.assert_allclose(there, size * np.array([0.02, 0.03, 0.04]), rtol=1e-12)
        assert there.attrs["units"] == ("m" if size == 1 else "mm")
        # dh/dt of the steady state falls with the square of the radius
        rate = dataset["steady_wear_rate"].values.ravel() * there.values**2
        np.testing.assert_allclose(rate, rate[0], rtol=1e-9)


def test_an_axis_with_the_name_of_a_quantity_gets_its_section_in_the_name():
    """The quantity keeps its name."""
    table = {"punch": {"profile": {"kind": "cone", "slope": 0.1}}}
    scene = Scene.from_table(BASE | {"punch": BASE["punch"] | table["punch"]})
    dataset = sweep(scene, FORCES, keep=["normal_force", "indentation"])
    assert dataset["normal_force"].dims == ("load_normal_force", "solver", "time")
    np.testing.assert_allclose(dataset["normal_force"].values.ravel(), [1.0, 2.0], rtol=1e-2)
