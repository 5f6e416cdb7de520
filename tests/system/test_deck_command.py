"""Decks from the command line, run if CalculiX is installed."""

import os
import re
import shutil
import subprocess

import numpy as np
import pytest

import ringwear
from ringwear import Scene, main
from ringwear.studies.decks.reports import read_dat

RUN = pytest.mark.skipif(shutil.which("ccx") is None, reason="CalculiX (ccx) is not installed")
# keywords of the Abaqus Keywords Reference Guide that decks may have
DOCUMENTED = {
    *("HEADING", "NODE", "ELEMENT", "NSET", "MATERIAL", "ELASTIC", "SOLID SECTION", "BOUNDARY"),
    *("STEP", "STATIC", "NODE PRINT", "OUTPUT", "NODE OUTPUT", "ELEMENT OUTPUT", "END STEP"),
    *("SURFACE", "RIGID BODY", "SURFACE INTERACTION", "FRICTION", "SURFACE BEHAVIOR"),
    *("CONTACT PAIR", "CONTACT PRINT", "CONTACT OUTPUT", "CLOAD"),
}


def run_calculix(folder, job):
    environment = os.environ | {"OMP_NUM_THREADS": "1"}
    call = {"cwd": folder, "check": True, "stdout": subprocess.DEVNULL, "env": environment}
    subprocess.run(["ccx", job], timeout=100, **call)
    return read_dat(folder / f"{job}.dat")


@RUN
def test_decks_for_calculix_run_and_are_read_back(tmp_path, capsys):
    """The flat start is Boussinesq's, F = 2 a E* d, reduced by the effect of the clamped arc."""
    call = ["deck", "flat_punch", "--for", "calculix", "--out", str(tmp_path), "--time", "0"]
    assert main([*call, "--size", "0.08", "--reach", "400"]) == 0
    assert "ringwear check scene.toml prescribed.dat" in capsys.readouterr().out
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


def test_a_scene_without_a_deck_is_refused_in_one_line(tmp_path, capsys):
    assert main(["deck", "recessed_binder", "--for", "calculix", "--out", str(tmp_path / "a")]) == 2
    assert capsys.readouterr().err.count("\n") == 1
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize(
    ("flags", "rows"),
    [
        ([], ["100 ms | 400 N", "14.25 s | 1 kN"]),
        (["--time", "4"], ["100 ms | 400 N", "4 s | 2 kN"]),
        (["--time", "0.05"], ["50 ms | 200 N", "100 ms | 400 N"]),
    ],
)
def test_a_brake_has_decks_of_times_at_which_it_is_applied(flags, rows, tmp_path, capsys):
    """Its force rises from 0 to 2 kN in 0.5 s, and falls from 2 kN at 14 s to 0 at 14.5 s."""
    call = ["deck", "duty_cycle", "--for", "calculix", "--size", "0.005", "--reach", "20"]
    assert main([*call, *flags, "--out", str(tmp_path)]) == 0
    table = re.findall(r"\| - \| (.*?) \|.*\| (.*?) \|$", capsys.readouterr().out, re.MULTILINE)
    assert [f"{time} | {force}" for time, force in table] == rows


def test_a_time_without_load_is_refused_before_anything_is_computed(tmp_path, capsys):
    call = ["deck", "duty_cycle", "--for", "abaqus", "--time", "8", "--out", str(tmp_path / "a")]
    assert main(call) == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert "--time 8: the load is zero then: give times at which the punch is loaded" in line
    assert not list(tmp_path.iterdir())
