"""Decks from the command line, run if CalculiX is installed."""

import os
import re
import shutil
import subprocess

import numpy as np
import pytest
from groups import slow

import ringwear
from ringwear import Scene
from ringwear.studies.decks.reports import read_dat

RUN = pytest.mark.skipif(shutil.which("ccx") is None, reason="CalculiX (ccx) is not installed")
# keywords of the Abaqus Keywords Reference Guide that decks may have
DOCUMENTED = {
    *("HEADING", "NODE", "ELEMENT", "NSET", "ELSET", "MATERIAL", "ELASTIC", "SOLID SECTION"),
    *("BOUNDARY", "STEP", "STATIC", "NODE PRINT", "OUTPUT", "NODE OUTPUT", "ELEMENT OUTPUT"),
    *("END STEP", "SURFACE", "RIGID BODY", "SURFACE INTERACTION", "FRICTION", "SURFACE BEHAVIOR"),
    *("CONTACT PAIR", "CONTACT PRINT", "CONTACT OUTPUT", "CLOAD"),
}


def run_calculix(folder, job):
    environment = os.environ | {"OMP_NUM_THREADS": "1"}
    call = {"cwd": folder, "check": True, "stdout": subprocess.DEVNULL, "env": environment}
    subprocess.run(["ccx", job], timeout=100, **call)
    return read_dat(folder / f"{job}.dat")


@pytest.mark.slow
@RUN
def test_decks_for_calculix_run_and_are_read_back(command, tmp_path):
    """The flat start is Boussinesq's, F = 2 a E* d, reduced by the effect of the clamped arc."""
    printed = command("deck flat_punch --for calculix --out . --time 0 --size 0.08 --reach 400").out
    assert "ringwear check scene.toml prescribed.dat" in printed
    scene = Scene.load(tmp_path / "scene.toml")
    force, modulus = scene.load_.normal_force, scene.half_space.modulus
    radius, clamped = scene.punch.radius, 1.1 / 400
    depth = force / (2 * radius * modulus)
    given = run_calculix(tmp_path, "prescribed").dropna()
    # quadratic elements of this size add 1e-3
    assert given.normal_force[0] / force == pytest.approx(1 + clamped, abs=2e-3)
    exact = force / (2 * np.pi * radius**2 * np.sqrt(1 - (given.radius / radius) ** 2))
    errors = given.pressure / exact - 1
    assert np.sqrt((errors**2).mean()) < 0.02
    pressed = run_calculix(tmp_path, "contact_1")
    assert pressed.normal_force[0] / force == pytest.approx(1, abs=1e-3)
    assert pressed.indentation[0] / depth == pytest.approx(1 - clamped, abs=0.02)
    np.testing.assert_allclose(pressed.displacement, pressed.indentation, rtol=5e-3)


@pytest.mark.slow
@RUN
@pytest.mark.gmsh
def test_decks_of_layers_run_and_are_read_back(tmp_path):
    """The force on a bonded layer is that of dimensionality reduction, at the start and later."""
    scene = Scene.load("polishing_pad")
    ringwear.deck(scene, "calculix", tmp_path, reach=50)
    checked = ringwear.check(
        scene, {"deck": str(written(tmp_path, "prescribed"))}, methods=["mdr"], within=0.02
    )
    errors = checked.errors[checked.errors.quantity == "normal_force"]
    assert len(errors) == 2
    assert (errors.error.abs() < 2e-3).all()
    assert checked.passes


def written(folder, job):
    """Run a job of CalculiX, and return the file of its results."""
    run_calculix(folder, job)
    return folder / f"{job}.dat"


@pytest.mark.gmsh
@pytest.mark.parametrize("scene", ["polishing_pad", *slow("hard_film")])
def test_the_layers_of_a_deck_are_sets_of_elements(scene, tmp_path):
    """Each element belongs to one set, whose material is that of the layer at its depth."""
    scene = Scene.load(scene)
    ringwear.deck(scene, "abaqus", tmp_path, size=0.2 * scene.punch.radius, reach=30)
    deck = (tmp_path / "prescribed.inp").read_text()
    count = deck.partition("*NSET")[0].partition("*ELEMENT")[2].count("\n") - 1
    names = ["LAYER_1"] if scene.half_space.rigid else ["LAYER_1", "SUBSTRATE"]
    members = [
        re.findall(r"\d+", deck.partition(f"*ELSET, ELSET={name}\n")[2].partition("*")[0])
        for name in names
    ]
    assert sorted(int(number) for of_set in members for number in of_set) == [*range(1, count + 1)]
    layers = [*scene.half_space.layers]
    moduli = [layer.youngs_modulus for layer in layers]
    if not scene.half_space.rigid:
        moduli.append(scene.half_space.youngs_modulus)
    given = [float(line.split(",")[0]) for line in re.findall(r"\*ELASTIC\n(.*)", deck)]
    assert given == pytest.approx(moduli, rel=1e-9)
    assert ("BASE, 1, 2" in deck) == scene.half_space.rigid


def test_elements_too_small_for_calculix_are_refused(tmp_path):
    with pytest.raises(ringwear.SceneError, match="give the scene in smaller units, such as mm"):
        ringwear.deck(
            Scene.load("hard_film").changed(half_space={"layers": [], "youngs_modulus": 2e11}),
            "calculix",
            tmp_path / "deck",
        )


def test_a_deck_states_the_stable_step_of_its_own_mesh(tmp_path):
    """Loops on such meshes show that the limit is right (`physics/test_wear_step.py`)."""
    size = {"element": "Q1", "size": 0.4, "reach": 50}
    ringwear.deck("five_rings", "calculix", tmp_path, times=[0], **size)
    lines = ringwear.plan("five_rings", mesh=str(tmp_path / "prescribed.inp"), element="Q1")
    (stable,) = [line for line in lines if line.startswith("stable")]
    # comments of a deck are broken into lines
    assert stable in (tmp_path / "prescribed.inp").read_text().replace("\n** ", " ")
    assert f"- {stable}\n" in (tmp_path / "README.md").read_text()


def test_the_comments_of_a_worn_deck_give_the_indentation(tmp_path):
    """By them reports are read back: displacements are scaled, and the foremost point has worn."""
    ringwear.deck("five_rings", "calculix", tmp_path, "Q1", times=[0.5], size=0.2, reach=20)
    text = (tmp_path / "contact_2.inp").read_text()
    scale, lowest, pressed = (
        float(re.search(rf"{name} (\S+)", text)[1])
        for name in ("displacements times:", "lowest height:", "PAD, 2, 2,")
    )
    scene = Scene.load("five_rings").changed(methods=["mdr"], wear__times=[0.0, 0.5])
    depth = float(ringwear.run(scene).dataset.indentation[0, 1])
    assert lowest - scale * pressed == pytest.approx(depth, rel=1e-6)
    assert min(scale, 10 * lowest) > 1


def test_decks_for_abaqus_have_documented_keywords(tmp_path):
    files = ringwear.deck("washer", "abaqus", tmp_path, size=0.008, reach=50)
    names = {file.name for file in files}
    assert names == {
        *("README.md", "contact_1.inp", "contact_2.inp", "prescribed.inp", "scene.toml")
    }
    for file in tmp_path.glob("*.inp"):
        text = file.read_text("utf-8")
        keywords = set(re.findall(r"^\*([A-Z][A-Z ]*)", text, re.MULTILINE))
        assert {keyword.strip() for keyword in keywords} <= DOCUMENTED
        # steps of the washer: the start and a worn face, or the indentation and then the force
        assert text.count("*STEP") == text.count("*END STEP") == 2
        assert max(map(len, text.splitlines())) <= 256
    assert "not run" in (tmp_path / "README.md").read_text("utf-8")


def test_a_scene_without_a_deck_is_refused_in_one_line(command, tmp_path):
    assert command("deck recessed_binder --for calculix --out a", 2).err.count("\n") == 1
    assert not list(tmp_path.iterdir())


@pytest.mark.slow
@pytest.mark.parametrize(
    ("flags", "rows"),
    [
        ("", ["100 ms | 400 N", "14.25 s | 1 kN"]),
        ("--time 4", ["100 ms | 400 N", "4 s | 2 kN"]),
        ("--time 0.05", ["50 ms | 200 N", "100 ms | 400 N"]),
    ],
)
def test_a_brake_has_decks_of_times_at_which_it_is_applied(flags, rows, command):
    """Its force rises from 0 to 2 kN in 0.5 s, and falls from 2 kN at 14 s to 0 at 14.5 s."""
    printed = command(f"deck duty_cycle --for calculix --size 0.005 --reach 20 --out . {flags}").out
    table = re.findall(r"\| - \| (.*?) \|.*\| (.*?) \|$", printed, re.MULTILINE)
    assert [f"{time} | {force}" for time, force in table] == rows


def test_a_time_without_load_is_refused_before_anything_is_computed(command, tmp_path):
    printed = command("deck duty_cycle --for abaqus --time 8 --out a", 2)
    (line,) = printed.err.splitlines()
    assert "--time 8: the load is zero then: give times at which the punch is loaded" in line
    assert not list(tmp_path.iterdir())
