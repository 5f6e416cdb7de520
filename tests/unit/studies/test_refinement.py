"""The mesh that refines itself, and the study that compares it.

Errors fall to the goal, and the estimate says so.
"""

from __future__ import annotations

import argparse
import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from skfem import Basis

from ringwear import Scene
from ringwear.fem.elasticity import AxisymmetricElasticity
from ringwear.fem.stresses import displacements
from ringwear.meshes import bisection
from ringwear.meshes.errors import MeshError, SceneError
from ringwear.meshes.half_space import contact_radii, quality
from ringwear.meshes.sizes import SizeField
from ringwear.studies.refinement import study as refinement
from ringwear.studies.refinement.adaptive import adapted, indicators, solved, uniform
from ringwear.studies.wear.flat_contact import press_flat

FLAT = np.array([0.0, 1.0])


@pytest.fixture(scope="module", params=[0, 1, 2], ids=["flat", "scene", "narrow"])
def case(request: pytest.FixtureRequest) -> refinement.Case:
    return refinement.cases(Scene.load("five_rings").problem)[request.param]


def test_indicators_are_the_energy_that_a_lower_degree_could_not_hold() -> None:
    mesh = uniform(FLAT)
    solid = AxisymmetricElasticity(mesh, 3, 0.3)
    r, z = Basis(mesh, solid.element).doflocs
    smooth = np.stack([2 * r, -3 * z], axis=1)[None]
    rough = np.stack([r**3, z**3], axis=1)[None]
    assert indicators(solid, smooth, np.ones(1)).max() < 1e-20
    assert indicators(solid, rough, np.ones(1)).min() > 1e-6


def test_indicators_do_not_depend_on_the_load_and_are_greatest_at_the_rim() -> None:
    one = solved(Scene.load("flat_punch").problem, uniform(FLAT), 3)
    u, solid = (
        displacements(one.half_space, press_flat(one.wear.compliance).pressure[None]),
        one.half_space.solid,
    )
    values = indicators(solid, u, np.ones(1))
    np.testing.assert_allclose(indicators(solid, 3 * u, np.full(1, 9.0)), values, rtol=1e-10)
    at_rim = np.hypot(solid.mesh.p[0] - 1, solid.mesh.p[1]).argmin()
    assert at_rim in solid.mesh.t[:, values.argmax()]


def test_adaptation_needs_less_than_twice_the_graded_unknowns(
    case: refinement.Case,
) -> None:
    ring_edges = case.problem.merged.ring_edges
    for one in adapted(case.problem, uniform(ring_edges), refinement.GOAL / 2):
        mesh = one.half_space.solid.mesh
        assert set(ring_edges) <= set(contact_radii(mesh))
        assert quality(mesh).min() > 0.2
    row = case.row(one)
    *_, (_, graded) = refinement.families(case.problem, quick=True)["graded triangles"]
    assert row["greatest"] < refinement.GOAL
    assert row["unknowns"] < 2 * graded.half_space.unknowns
    assert 0.3 < row["estimate"] / row["greatest"] < 30


@pytest.mark.parametrize(
    "kind", ["triangles", pytest.param("quadrilaterals", marks=pytest.mark.gmsh)]
)
def test_uniform_refinement_is_of_first_order_and_refines_the_contact(
    kind: str, case: refinement.Case
) -> None:
    rows = [case.row(one) for _, one in refinement.families(case.problem, quick=True)[f"h, {kind}"]]
    errors = [row["d0"] for row in rows]
    assert rows[-1]["multipliers"] > 3 * rows[0]["multipliers"]
    assert np.log2(errors[-2] / errors[-1]) == pytest.approx(1, abs=0.15)
    assert errors[-1] <= 5e-3


@pytest.fixture
def own(tmp_path: Path) -> Path:
    """A user's mesh file, with one ring edge at half the radius."""
    path = tmp_path / "mine.vtu"
    bisection.mesh(SizeField((0.0, 0.5, 1.0), 0.02, 0.05, 0.8, 4.0)).save(path, file_format="vtu")
    return path


def test_the_study_writes_rows_figures_and_a_line_for_the_users_mesh(
    tmp_path: Path, own: Path
) -> None:
    out = tmp_path / "out"
    out.mkdir()
    lines = refinement.conduct(
        Scene.load("flat_punch"), out, argparse.Namespace(quick=True, mesh=str(own))
    )
    assert lines[0].startswith("flat punch: mine.vtu, ")
    assert re.search(r"adaptive triangles \d+ \(round", "".join(lines))
    assert {file.name for file in out.iterdir()} == {
        "refinement.csv",
        "refinement.md",
        "error_against_unknowns.png",
        "meshes_flat_punch.png",
    }


def test_a_mesh_file_is_refused_where_it_does_not_fit(tmp_path: Path, own: Path) -> None:
    problem = Scene.load("five_rings").problem
    with pytest.raises(MeshError, match=r"ring edge at r = 0\.2 a"):
        refinement.own_mesh(problem, str(own))
    fitting = replace(
        problem, rings=refinement.Rings(np.array([0.0, 0.5, 1.0]), np.array([1.0, 0.1]))
    )
    name, _ = refinement.own_mesh(fitting, str(own))
    assert name == "mine.vtu"
    with pytest.raises(SceneError, match="no such file"):
        refinement.conduct(
            Scene.load("five_rings"),
            tmp_path,
            argparse.Namespace(quick=True, mesh=str(tmp_path / "absent")),
        )
