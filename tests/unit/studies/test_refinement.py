"""The study of refinement: ways to refine, and a mesh of the user's."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from ringwear import Scene
from ringwear.meshes import bisection
from ringwear.meshes.errors import MeshError
from ringwear.meshes.half_space import contact_radii
from ringwear.meshes.sizes import SizeField
from ringwear.studies.numerics import refinement
from ringwear.studies.problem.problem import Rings
from ringwear.studies.study.options import Options

PUNCHES = {"flat": [1.0], "five": [0.2, 0.4, 0.6, 0.8, 1.0], "narrow": [0.2, 0.4, 0.401, 0.8, 1.0]}


@pytest.fixture(scope="module", params=PUNCHES.values(), ids=PUNCHES)
def case(request):
    edges = np.array([0.0, *request.param])
    rings = Rings(edges, np.array([0.1, 1.0, 0.1, 1.0, 0.1])[: len(edges) - 1])
    return replace(Scene.load("five_rings").problem, rings=rings)


def rows_of(case, way):
    families = refinement.families("", case, Options(quick=True))
    (family,) = (family for family in families if family.name == way)
    return [family.solve(setting) for setting in family.sizes]


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


def test_a_mesh_file_is_refused_where_it_does_not_fit(own):
    scene = Scene.load("five_rings")
    with pytest.raises(MeshError, match=r"ring edge at r = 0\.2 a"):
        refinement.own_mesh(scene.problem, str(own))
    fitting = Rings(np.array([0.0, 0.5, 1.0]), np.array([1.0, 0.1]))
    mesh = refinement.own_mesh(replace(scene.problem, rings=fitting), str(own))
    assert 0.5 in contact_radii(mesh)
