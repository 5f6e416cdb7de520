"""Runs without gmsh or CHOLMOD use replacements, which the plan and the result report."""

import sys

import numpy as np
import pytest
from groups import nightly, nightly_but

from ringwear import Scene, main, plan, run


@pytest.fixture(autouse=True)
def _broken_gmsh(monkeypatch, tmp_path):
    """Replace gmsh by one as pip installs it on a system without its libraries."""
    reason = "libGL.so.1: cannot open shared object file"
    (tmp_path / "gmsh.py").write_text(f'raise OSError("{reason}")', "utf-8")
    monkeypatch.syspath_prepend(tmp_path)
    monkeypatch.delitem(sys.modules, "gmsh", raising=False)


def test_the_remedy_is_printed(tmp_path, capsys):
    assert main(["mesh", "flat_punch", "--out", str(tmp_path / "out")]) == 0
    assert "apt-get install" in capsys.readouterr().out


@pytest.mark.slow
@pytest.mark.parametrize("mesher", ["quads", "gmsh", "bisection"])
def test_the_plan_has_the_mesher_of_the_run(mesher, monkeypatch):
    # on triangles, other quantities would be refined, which the plan cannot know
    scene = Scene.load("flat_punch").changed(
        methods=["mdr", "fem"],
        accuracy={"rtol": 1e-3, "fem": {"mesher": mesher}},
        output__quantities=["indentation"],
    )
    monkeypatch.setitem(sys.modules, "kvxopt", None)
    lines, result = plan(scene), run(scene)
    exact, by_elements = result.dataset.indentation
    np.testing.assert_allclose(by_elements, exact, rtol=1e-3)
    notes = [line.removeprefix("note: ") for line in lines if line.startswith("note: ")]
    assert notes == list(result.notes)
    assert list(result.summary["notes"]) == list(result.notes)
    assert bool(notes) == (mesher != "bisection")
    assert all("libGL.so.1" in note and "apt-get install" in note for note in notes)
    settings = result.solutions["fem"].settings
    assert (settings["mesher"], settings["solver"]) == ("bisection", "superlu")
    counted = f"fem: {result.solutions['fem'].unknowns} unknowns, "
    assert any(line.startswith(counted) for line in lines)


BROKEN_KVXOPT = {
    "a library that is missing": "raise ImportError('libblas.so.3: cannot open shared object')",
    "another numpy": "raise ValueError('numpy.dtype size changed')",
    "modules that are missing": "",
}


@pytest.mark.slow
@pytest.mark.parametrize("reason", nightly_but(["a library that is missing"], BROKEN_KVXOPT))
@pytest.mark.parametrize("name", ["flat_punch", *nightly("cone")])
def test_cholmod_that_is_installed_but_cannot_be_loaded_is_replaced(
    name, reason, monkeypatch, tmp_path
):
    """The same numbers follow by SuperLU, and one note of the plan and of the run says so."""
    (tmp_path / "kvxopt").mkdir()
    (tmp_path / "kvxopt" / "__init__.py").write_text(BROKEN_KVXOPT[reason], "utf-8")
    loaded = [each for each in sys.modules if each.partition(".")[0] == "kvxopt"]
    for each in loaded:
        monkeypatch.delitem(sys.modules, each)
    monkeypatch.syspath_prepend(tmp_path)
    scene = Scene.load(name).changed(
        methods=["mdr", "fem"], accuracy={"rtol": 1e-2}, output__quantities=["indentation"]
    )
    lines, result = plan(scene), run(scene)
    for each in [each for each in sys.modules if each.partition(".")[0] == "kvxopt"]:
        del sys.modules[each]
    assert result.verdict == "agree"
    (note,) = [note for note in result.notes if "kvxopt" in note]
    assert "SuperLU" in note
    assert "cannot be loaded" in note
    assert note.endswith("install it again, or uninstall it")
    assert lines.count(f"note: {note}") == 1
