"""The mesh that refines itself, and the study that compares it: errors fall to the goal, and the estimate says so."""

from __future__ import annotations

import argparse
from pathlib import Path

import numpy as np
import pytest
from ringwear.fem.elasticity import AxisymmetricElasticity
from ringwear.fem.stresses import displacements
from ringwear.meshes import bisection
from ringwear.meshes.errors import MeshError
from ringwear.meshes.half_space import contact_radii, quality
from ringwear.meshes.size_field import SizeField
from ringwear.studies.progress import silent
from ringwear.studies.refinement import adaptive
from ringwear.studies.refinement import study as refinement
from ringwear.studies.wear.contact import flat_start
from skfem import Basis

from ringwear import Scene

FIVE_WITH_A_NARROW_ONE = np.array([0.0, 0.2, 0.4, 0.401, 0.8, 1.0])


@pytest.mark.parametrize("edges", [np.array([0.0, 1.0]), FIVE_WITH_A_NARROW_ONE])
def test_the_uniform_start_has_every_ring_edge_and_stays_a_valid_mesh_when_refined(edges: np.ndarray) -> None:
    nested = adaptive.uniform(edges, 4.0, 1.0)
    for _ in range(3):
        assert {float(e) for e in edges} <= set(contact_radii(nested.mesh))
        assert quality(nested.mesh).min() > 0.2
        nested = nested.refined(np.arange(0, len(nested.corners), 5))


def test_indicators_are_the_energy_that_a_lower_degree_could_not_hold() -> None:
    mesh = adaptive.uniform(np.array([0.0, 1.0]), 4.0, 1.0).mesh
    solid = AxisymmetricElasticity(mesh, 3, 0.3)
    r, z = Basis(mesh, solid.element).doflocs
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
    at_rim = np.hypot(round_.mesh.p[0] - 1, round_.mesh.p[1]).argmin()
    assert at_rim in round_.mesh.t[:, one.argmax()]


@pytest.mark.parametrize("narrow", [False, True], ids=["flat", "narrow"])
def test_adaptation_reaches_the_goal_with_less_than_twice_the_graded_unknowns(narrow: bool) -> None:
    case = refinement._cases(Scene.load("five_rings"))[2 if narrow else 0]
    coarse = adaptive.uniform(case.phases[0], 5.0, refinement.START)
    *_, (row, _) = refinement._adaptive(case, coarse, refinement.GOAL / 2)
    *_, (graded, _) = refinement._graded(case, (refinement.GOAL,))
    assert row["greatest"] < refinement.GOAL
    assert row["unknowns"] < 2 * graded["unknowns"]
    assert 0.3 < row["estimate"] / row["greatest"] < 30


@pytest.mark.parametrize("number", [0, 1, 2], ids=["flat", "scene", "narrow"])
@pytest.mark.parametrize("kind", ["triangles", pytest.param("quadrilaterals", marks=pytest.mark.gmsh)])
def test_uniform_refinement_is_of_first_order_and_refines_the_contact(kind: str, number: int) -> None:
    case = refinement._cases(Scene.load("five_rings"))[number]
    if kind == "triangles":
        mesh = adaptive.uniform(case.phases[0], 5.0, refinement.START).mesh
    else:
        mesh = refinement._coarse_quads(case)
    rows = [row for row, _ in refinement._refined(case, kind, mesh, 4, 4)]
    facets = [row["multipliers"] for row in rows]
    assert facets[-1] > 6 * facets[0]
    errors = np.array([row["d0"] for row in rows])
    assert np.log2(errors[-2] / errors[-1]) == pytest.approx(1, abs=0.1)
    assert errors[-1] <= 3e-3


def test_the_study_writes_rows_figures_and_a_line_for_the_users_mesh(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    mesh = bisection.mesh(SizeField((0.0, 0.5, 1.0), 0.02, 0.05, 0.8, 4.0))
    path = tmp_path / "mine.vtu"
    mesh.save(path, file_format="vtu")
    monkeypatch.setattr(refinement, "GOAL", 1e-3)

    def few(case: refinement.Case, _: object) -> dict[str, refinement.Rows]:
        coarse = adaptive.uniform(case.phases[0], 5.0, 1.0)
        made = {"graded triangles": refinement._graded(case, (1e-3,))}
        made["adaptive triangles"] = refinement._adaptive(case, coarse, 3e-4)
        for name in ("h, triangles", "h, quadrilaterals"):
            made[name] = refinement._refined(case, name, coarse.mesh, 4, 2)
        for name in ("p, triangles", "p, quadrilaterals"):
            made[name] = refinement._degrees(case, name, coarse.mesh, range(3, 5))
        return made

    monkeypatch.setattr(refinement, "_families", few)
    (tmp_path / "out").mkdir()
    options = argparse.Namespace(quick=True, mesh=str(path))
    conclusions = refinement.conduct(Scene.load("flat_punch"), tmp_path / "out", options, silent)
    assert any("adaptation from a uniform mesh reaches" in line for line in conclusions)
    assert any(line.startswith("flat punch: mine.vtu, ") for line in conclusions)
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
