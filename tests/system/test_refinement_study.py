"""The study of refinement with meshes of the user."""

import numpy as np
import pytest

from ringwear import SceneError, SizeField, bisection, study


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


@pytest.mark.slow
def test_a_sequence_of_own_meshes_has_an_order_and_a_place_to_refine(tmp_path, own_meshes):
    results = study("refinement", "flat_punch", quick=True, meshes=own_meshes, degree=3)
    rows = results.table[results.table["way"] == "your meshes"]
    names = ["coarse.vtu", "middle.vtu", "fine.vtu"]
    assert rows["level"].unique().tolist() == names
    start = rows[(rows["quantity"] == "indentation") & (rows["when"] == "start")]["error"].abs()
    assert (np.diff(start) < 0).all()
    assert any(line.endswith(": stable.") for line in results.conclusions)
    assert "your meshes" in set(results.answer["way"])
    of_own = results.orders[results.orders["way"] == "your meshes"]
    assert (of_own["order"] > 0).any()
    assert {"uniform triangles", "adaptive triangles", "your meshes"} <= set(results.table["way"])
    written = set(results.save(tmp_path / "out"))
    assert {"refinement.csv", "answer.md", "costs.csv", "refinement.png"} <= written


def test_a_mesh_file_that_is_absent_or_a_degree_that_does_not_fit_is_refused(tmp_path, own_meshes):
    with pytest.raises(SceneError, match="no such file"):
        study("refinement", "five_rings", quick=True, meshes=[str(tmp_path / "absent")])
    with pytest.raises(SceneError, match=r"--degree 7.*give 2 to 4"):
        study("refinement", "flat_punch", quick=True, meshes=own_meshes, degree=7)
