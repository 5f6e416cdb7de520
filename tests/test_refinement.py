"""The mesh that refines itself, and the study that compares it: errors fall to the goal, and the estimate says so."""

from __future__ import annotations

import argparse
from pathlib import Path

import meshio
import numpy as np
import pytest

from fem.elasticity import AxisymmetricElasticity
from fem.fields import displacements
from meshes import bisection
from meshes.errors import MeshError
from meshes.half_space import SizeField
from studies import Scene, adaptive, refinement
from studies.contact import flat_start
from studies.stages import silent

FIVE_WITH_A_NARROW_ONE = np.array([0.0, 0.2, 0.4, 0.401, 0.8, 1.0])


@pytest.mark.parametrize("edges", [np.array([0.0, 1.0]), FIVE_WITH_A_NARROW_ONE])
def test_the_uniform_start_has_every_ring_edge_and_stays_a_valid_mesh_when_refined(edges: np.ndarray) -> None:
    nested = adaptive.uniform(edges, 4.0, 1.0)
    for _ in range(3):
        assert {float(e) for e in edges} <= set(nested.mesh.contact_radii)
        assert nested.mesh.quality.min() > 0.2
        nested = nested.refined(np.arange(0, len(nested.corners), 5))


def test_indicators_are_the_energy_that_a_lower_degree_could_not_hold() -> None:
    mesh = adaptive.uniform(np.array([0.0, 1.0]), 4.0, 1.0).mesh
    solid = AxisymmetricElasticity(mesh, 3, 0.3)
    r, z = solid.positions.T
    # in equilibrium, so that the insides of triangles, which follow from their sides, are those of this field
    smooth = np.stack([2 * r, -3 * z], axis=1)[None]
    rough = np.stack([r**3, z**3], axis=1)[None]
    assert adaptive.indicators(solid, smooth, np.ones(1)).max() < 1e-20
    assert adaptive.indicators(solid, rough, np.ones(1)).min() > 1e-3


def test_indicators_sum_squares_of_states_apart_and_scale_with_their_energy() -> None:
    edges = np.array([0.0, 1.0])
    round_ = adaptive.solved(adaptive.uniform(edges, 4.0, 1.0).mesh, edges, np.ones(1), 0.3, degree=3)
    half_space = round_.half_space
    pressure = flat_start(round_.compliance).pressure
    u = displacements(half_space, pressure[None])
    one = adaptive.indicators(round_.solid, u, np.ones(1))
    np.testing.assert_allclose(adaptive.indicators(round_.solid, 3 * u, np.full(1, 9.0)), one, rtol=1e-10)
    at_rim = np.hypot(*(round_.mesh.points - [1, 0]).T).argmin()
    assert at_rim in round_.mesh.triangles[one.argmax()]


@pytest.mark.parametrize("narrow", [False, True], ids=["flat", "narrow"])
def test_adaptation_reaches_the_goal_with_less_than_twice_the_graded_unknowns(narrow: bool) -> None:
    five = Scene.load("five_rings")
    case = refinement._cases(five)[2 if narrow else 0]
    *_, last = refinement._adaptive(case, refinement.GOAL / 2)
    row, _ = last
    *_, (graded, _) = refinement._graded(case, (refinement.GOAL,))
    assert row["greatest"] < refinement.GOAL
    assert row["unknowns"] < 2 * graded["unknowns"]
    assert 0.3 < row["estimate"] / row["greatest"] < 30


def test_the_study_writes_rows_figures_and_a_line_for_the_users_mesh(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    mesh = bisection.mesh(SizeField((0.0, 0.5, 1.0), 0.02, 0.05, 0.8, 4.0))
    lines = np.concatenate(list(mesh.boundaries.values()))
    marks = {
        name: [np.isin(np.arange(len(lines)), start + np.arange(len(part))).astype(int), np.zeros(len(mesh.triangles), int)]
        for (name, part), start in zip(
            mesh.boundaries.items(), np.cumsum([0, *(len(part) for part in mesh.boundaries.values())])[:-1], strict=True
        )
    }
    points = np.column_stack([mesh.points, np.zeros(len(mesh.points))])
    path = tmp_path / "mine.vtu"
    meshio.Mesh(points, [("line", lines), ("triangle", mesh.triangles)], cell_data=marks).write(path)
    monkeypatch.setattr(refinement, "GOAL", 1e-3)
    flat = Scene.load("flat_punch")
    (tmp_path / "out").mkdir()
    monkeypatch.setattr(refinement, "_families", lambda case, _: {
        "uniform": refinement._uniform(case, (1.0,)),
        "graded": refinement._graded(case, (1e-3,)),
        "adaptive": refinement._adaptive(case, 3e-4),
    })  # fmt: skip
    options = argparse.Namespace(quick=True, mesh=str(path))
    conclusions = refinement.conduct(flat, tmp_path / "out", options, silent)
    assert any("adaptation from a uniform mesh reaches" in line for line in conclusions)
    assert any("file mine.vtu, with" in line for line in conclusions)
    names = {file.name for file in (tmp_path / "out").iterdir()}
    assert names == {
        "refinement.csv", "refinement.md", "error_against_unknowns.png", "quality.png", "meshes_flat_punch.png",
    }  # fmt: skip


def test_a_mesh_file_that_fits_no_case_is_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(refinement, "_families", lambda *_: {})
    monkeypatch.setattr(refinement, "_conclusion", lambda *_: "")
    options = argparse.Namespace(quick=True, mesh=str(tmp_path / "absent.msh"))
    with pytest.raises(MeshError, match="no such file"):
        refinement.conduct(Scene.load("flat_punch"), tmp_path, options, silent)
