"""Ways to refine a mesh: orders of their errors, their cost, and the worst place of a mesh."""

from dataclasses import replace

import numpy as np
import pandas as pd
import pytest
from scipy.linalg import eigh
from skfem import Mesh

from ringwear import MeshError, Rings, Scene, SizeField, Stages, bisection, energy
from ringwear.meshes.half_space import contact_radii
from ringwear.studies.crosscheck.problem.sections import FemAccuracy
from ringwear.studies.refinement import case as cases
from ringwear.studies.refinement import ways
from ringwear.studies.refinement.case import POLES_RTOL, Case, Level
from ringwear.studies.refinement.conclusions import costs
from ringwear.studies.refinement.own_meshes import OwnMeshes, least_eigenvalue, worst_place
from ringwear.studies.study.options import Options
from ringwear.studies.study.own_mesh import own_mesh

PUNCHES = {"flat": [1.0], "five": [0.2, 0.4, 0.6, 0.8, 1.0], "narrow": [0.2, 0.4, 0.401, 0.8, 1.0]}


def case_of(edges, degree=4):
    (*_, case) = Case.all_of(Scene.load("five_rings"))
    wear_coefficients = np.array([0.1, 1.0, 0.1, 1.0, 0.1])[: len(edges)]
    rings = Rings.constant(np.array([0.0, *edges]), wear_coefficients)
    fem = FemAccuracy.model_validate({"degree": degree, "mesher": "gmsh"})
    return Case("test", replace(case.problem, rings=rings, fem=fem))


def family_of(case, way, quick=True):
    families = ways.Ways(case, Options(quick=quick), []).families()
    (family,) = (family for family in families if family.name == way)
    return family


@pytest.mark.parametrize("punch", ["flat", "five", pytest.param("narrow", marks=pytest.mark.slow)])
def test_uniform_refinement_is_of_first_order_and_refines_the_contact(punch, monkeypatch):
    monkeypatch.setattr(cases, "REFERENCE_RTOL", 1e-3)  # d0 has a closed form
    # the quick study leaves out levels that are larger because of a narrow ring
    family = family_of(case_of(PUNCHES[punch]), "uniform", quick=punch != "narrow")
    first, last_but_one, last = map(family.solve, list(family.sizes)[:3])
    assert last["multipliers"] > 3 * first["multipliers"]
    assert np.log2(last_but_one["d0"] / last["d0"]) == pytest.approx(1, abs=0.15)
    assert last["d0"] <= 5e-3


@pytest.mark.parametrize("degree", [2, 3, pytest.param(4, marks=pytest.mark.slow)])
def test_adaptive_energy_errors_fall_at_the_best_order_and_are_indicated(degree):
    case = case_of(PUNCHES["five"], degree)
    start = ways.Ways(case, Options(), [])
    adaptive = ways.AdaptiveTriangles(case, start._coarsest, start.degree)
    unknowns, errors = [], []
    while not unknowns or unknowns[-1] < (45_000 if degree == 4 else 9_000):
        solved = adaptive.solve_next("")
        unknowns.append(solved.half_space.unknowns)
        errors.append(np.sqrt(solved.relative_energy_errors.max()))
        assert solved.effectivities["least effectivity"] > 1
        assert solved.effectivities["greatest effectivity"] < 10
    finer = slice(len(unknowns) // 2, None)
    order = -np.polyfit(np.log(unknowns[finer]), np.log(errors[finer]), 1)[0]
    # N^(-1/2) is the size of elements in the plane, and the energy norm of the error its power k
    assert order == pytest.approx(degree / 2, abs=0.25)


@pytest.mark.slow
@pytest.mark.gmsh
def test_adaptive_meshes_need_at_most_twice_the_unknowns_of_graded_ones():
    (*_, case) = Case.all_of(Scene.load("five_rings"))
    needed = {}
    for way in ("graded", "adaptive", "uniform"):
        family = family_of(case, way, quick=way != "graded")
        rows = (family.solve(setting) for setting in family.sizes)
        needed[way] = next((row["unknowns"] for row in rows if row["pressure"] <= 1e-3), np.inf)
    assert needed["adaptive"] <= 2 * needed["graded"]
    assert np.isinf(needed["uniform"])


def make_mesh(path, rim_size, ring_size, growth=0.8):
    """Write a mesh with one ring edge at half the radius."""
    mesh = bisection.mesh(SizeField((0.0, 0.5, 1.0), rim_size, ring_size, growth, 4.0))
    mesh.save(path, file_format="vtu")
    return str(path)


def test_files_of_one_name_get_different_labels(tmp_path):
    case = case_of([0.5, 1.0])
    paths = []
    for folder in ("one", "two"):
        (tmp_path / folder).mkdir()
        paths.append(make_mesh(tmp_path / folder / "mesh.vtu", 0.1, 0.1))
    mesh = Mesh.load(paths[0])
    names = list(OwnMeshes(case, Options(meshes=(*paths, mesh))).meshes)
    assert names == [f"{paths[0]} (1)", f"{paths[1]} (2)", "mesh 3"]


@pytest.mark.parametrize(("rim_size", "ring_size", "edge"), [(1e-4, 0.2, 0.5), (0.2, 1e-4, 1.0)])
def test_the_worst_place_is_where_the_mesh_is_coarse(rim_size, ring_size, edge):
    case = case_of([0.5, 1.0])
    mesh = bisection.mesh(SizeField((0.0, 0.5, 1.0), rim_size, ring_size, 0.5, 4.0))
    solved = case.solve(case.half_space_on(mesh, 3, 1e-6), Stages("file"))
    place = worst_place(case, Level.of(case, "file", "mine", solved))
    assert place.edge == edge
    assert edge in place.facet
    assert 0.5 < place.share <= 1
    # both are ratios of energies on the same pressures
    exact = energy.compliance(solved.compliance.space).matrix
    ratios = eigh(solved.compliance.matrix, exact, eigvals_only=True)
    assert least_eigenvalue(solved) == pytest.approx(ratios.min(), rel=1e-6)


def test_costs_are_those_of_the_first_level_that_reaches_a_goal():
    family = family_of(case_of(PUNCHES["flat"]), "uniform")
    rows = pd.DataFrame(
        [{"family": "uniform"} | dict(family.solve(setting)) for setting in list(family.sizes)[:2]]
    )
    rows["d0"] = [0.02, 0.005]
    table = costs(rows).set_index(["quantity", "goal"])
    assert table.unknowns["d0", 1e-2] == rows.unknowns[1]
    assert np.isnan(table.unknowns["d0", 1e-3])
    assert table["least error"]["d0", 1e-3] == 0.005


def test_poles_make_the_truncation_negligible():
    case = case_of(PUNCHES["flat"])
    mesh = ways.Ways(case, Options(), [])._coarsest
    assert len(case.half_space_on(mesh, 4, POLES_RTOL).poles) > 4


def test_a_mesh_file_fits_if_its_ring_edges_are_vertices(tmp_path):
    problem, file = Scene.load("five_rings").problem, make_mesh(tmp_path / "mine.vtu", 0.1, 0.1)
    with pytest.raises(MeshError, match=r"ring edge at r = 0\.2 a"):
        own_mesh(problem, file)
    fitting = Rings.constant(np.array([0.0, 0.5, 1.0]), np.array([1.0, 0.1]))
    assert 0.5 in contact_radii(own_mesh(replace(problem, rings=fitting), file))
