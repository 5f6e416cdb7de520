"""The mesh that refines itself, and the study that compares it.

Errors fall to the goal, and the estimate says so.
"""

from __future__ import annotations

import argparse
from dataclasses import replace

import numpy as np
import pytest
from skfem import Basis

from ringwear import Scene
from ringwear.fem.elasticity import AxisymmetricElasticity
from ringwear.meshes import bisection
from ringwear.meshes.errors import MeshError, SceneError
from ringwear.meshes.half_space import contact_radii, quality
from ringwear.meshes.sizes import SizeField
from ringwear.studies.numerics import refinement
from ringwear.studies.numerics.adaptive import indicators, solve_on, uniform_mesh
from ringwear.studies.problem.problem import Rings
from ringwear.studies.wear.flat_contact import press_flat

FLAT = np.array([0.0, 1.0])


PUNCHES = {"flat": [1.0], "five": [0.2, 0.4, 0.6, 0.8, 1.0], "narrow": [0.2, 0.4, 0.401, 0.8, 1.0]}


@pytest.fixture(scope="module", params=PUNCHES.values(), ids=PUNCHES)
def case(request):
    edges = np.array([0.0, *request.param])
    rings = Rings(edges, np.array([0.1, 1.0, 0.1, 1.0, 0.1])[: len(edges) - 1])
    return refinement.Case("", replace(Scene.load("five_rings").problem, rings=rings))


def rows_of(case, way):
    (family,) = (family for family in refinement.families(case, quick=True) if family.name == way)
    return [level.solve() for level in family.levels]


def test_indicators_are_the_energy_that_a_lower_degree_could_not_hold():
    mesh = uniform_mesh(FLAT)
    solid = AxisymmetricElasticity(mesh, 3, 0.3)
    r, z = Basis(mesh, solid.element).doflocs
    smooth = np.stack([2 * r, -3 * z], axis=1)[None]
    rough = np.stack([r**3, z**3], axis=1)[None]
    assert indicators(solid, smooth, np.ones(1)).max() < 1e-20
    assert indicators(solid, rough, np.ones(1)).min() > 1e-6


def test_indicators_do_not_depend_on_the_load_and_are_greatest_at_the_rim():
    solved = solve_on(Scene.load("flat_punch").problem, uniform_mesh(FLAT), 3)
    solid, start = solved.half_space.solid, press_flat(solved.wear.compliance)
    u = solved.half_space.displacements(start.pressure[None])
    values = indicators(solid, u, np.ones(1))
    np.testing.assert_allclose(indicators(solid, 3 * u, np.full(1, 9.0)), values, rtol=1e-10)
    at_rim = np.hypot(solid.mesh.p[0] - 1, solid.mesh.p[1]).argmin()
    assert at_rim in solid.mesh.t[:, values.argmax()]


def test_adaptation_needs_less_than_twice_the_graded_unknowns(case):
    rows = rows_of(case, refinement.ADAPTIVE)
    for row in rows:
        assert set(case.problem.merged.ring_edges) <= set(contact_radii(row["mesh"]))
        assert quality(row["mesh"]).min() > 0.2
    assert rows[-1]["greatest"] < refinement.GOAL
    assert rows[-1]["unknowns"] < 2 * rows_of(case, "graded triangles")[-1]["unknowns"]
    assert 0.3 < rows[-1]["estimate"] / rows[-1]["greatest"] < 30


def test_uniform_refinement_is_of_first_order_and_refines_the_contact(
    case,
):
    first, *_, last_but_one, last = rows_of(case, "uniform triangles")
    assert last["multipliers"] > 3 * first["multipliers"]
    assert np.log2(last_but_one["d0"] / last["d0"]) == pytest.approx(1, abs=0.15)
    assert last["d0"] <= 5e-3


@pytest.fixture
def own(tmp_path):
    """A user's mesh file, with one ring edge at half the radius."""
    path = tmp_path / "mine.vtu"
    bisection.mesh(SizeField((0.0, 0.5, 1.0), 0.02, 0.05, 0.8, 4.0)).save(path, file_format="vtu")
    return path


def test_the_study_writes_rows_figures_and_a_line_for_the_users_mesh(tmp_path, own):
    out = tmp_path / "out"
    out.mkdir()
    options = argparse.Namespace(quick=True, mesh=str(own))
    lines = refinement.conduct(Scene.load("flat_punch"), out, options)
    assert lines[0].startswith("flat punch: mine.vtu, ")
    assert {file.name for file in out.iterdir()} == {
        "refinement.csv",
        "error_against_unknowns.png",
        "adaptive_triangles_of_flat_punch.png",
        "file_of_flat_punch.png",
    }


def test_a_mesh_file_is_refused_where_it_does_not_fit(tmp_path, own):
    scene = Scene.load("five_rings")
    with pytest.raises(MeshError, match=r"ring edge at r = 0\.2 a"):
        refinement.own_mesh(scene.problem, str(own))
    fitting = Rings(np.array([0.0, 0.5, 1.0]), np.array([1.0, 0.1]))
    mesh = refinement.own_mesh(replace(scene.problem, rings=fitting), str(own))
    assert 0.5 in contact_radii(mesh)
    options = argparse.Namespace(quick=True, mesh=str(tmp_path / "absent"))
    with pytest.raises(SceneError, match="no such file"):
        refinement.conduct(scene, tmp_path, options)
