"""The study of refinement with meshes of the user."""

import numpy as np
import pandas as pd
import pytest

from ringwear import SceneError, SizeField, bisection, main, study


def make_mesh(path, rim_size, ring_size, growth=0.8):
    """Write a mesh with one ring edge at half the radius."""
    mesh = bisection.mesh(SizeField((0.0, 0.5, 1.0), rim_size, ring_size, growth, 4.0))
    mesh.save(path, file_format="vtu")
    return str(path)


@pytest.fixture
def own_meshes(tmp_path):
    """Return three mesh files, each finer than the one before it."""
    return [
        make_mesh(tmp_path / f"{name}.vtu", size, size)
        for name, size in (("coarse", 0.1), ("middle", 0.03), ("fine", 0.01))
    ]


def test_a_sequence_of_own_meshes_has_an_order_and_a_place_to_refine(tmp_path, own_meshes):
    results = study("refinement", "flat_punch", quick=True, meshes=own_meshes, degree=3)
    rows = results.table[results.table.family == "file"]
    assert list(rows.setting) == ["coarse.vtu", "middle.vtu", "fine.vtu"]
    assert set(rows.degree) == {3}
    assert (np.diff(rows.d0) < 0).all()
    for name, conclusion in zip(rows.setting, results.conclusions, strict=False):
        assert conclusion.startswith(f"flat punch: {name}, ")
        assert "of degree 3" in conclusion
        # the pressure of a flat punch is singular only at the rim
        assert "lies next to r = 1 a" in conclusion
        assert "they are stable" in conclusion
    of_own = results.orders[results.orders.refined == "flat punch, file"]
    assert (of_own["least squares"] > 0).all()
    assert {"uniform", "adaptive", "file"} <= set(results.table.family)
    labels = [
        text.get_text() for text in results.figures["error_against_unknowns"].legends[0].texts
    ]
    assert "coarse.vtu, middle.vtu, fine.vtu: degree 3" in labels
    written = set(results.save(tmp_path / "out"))
    assert {"refinement.csv", "refinement.md", "costs.md", "error_against_unknowns.png"} <= written
    assert {"own_meshes_flat_punch.png", "meshes_flat_punch.png", "indicator.png"} <= written


def test_one_own_mesh_from_the_command_line(tmp_path, own_meshes, capsys):
    arguments = ["study", "refinement", "flat_punch", "--quick", "--degree", "2"]
    out = tmp_path / "out"
    assert main([*arguments, "--mesh", own_meshes[1], "--out", str(out)]) == 0
    printed = capsys.readouterr().out
    assert "flat punch: middle.vtu, " in printed
    assert printed.count("triangles of degree 2 with") == 1
    rows = pd.read_csv(out / "refinement.csv")
    assert rows[rows.family == "file"].setting.tolist() == ["middle.vtu"]


def test_a_mesh_file_that_is_absent_or_a_degree_that_does_not_fit_is_refused(tmp_path, own_meshes):
    with pytest.raises(SceneError, match="no such file"):
        study("refinement", "five_rings", quick=True, meshes=[str(tmp_path / "absent")])
    with pytest.raises(SceneError, match=r"--degree 7.*give 2 to 4"):
        study("refinement", "five_rings", quick=True, meshes=own_meshes, degree=7)
