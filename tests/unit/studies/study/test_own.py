"""What users bring to a study: meshes, elements, quantities and methods; and where meshes err."""

from dataclasses import replace

import numpy as np
import pandas as pd
import pytest
from scipy.linalg import eigh
from skfem import Mesh

from ringwear import Rings, Scene, SceneError, SizeField, bisection, energy
from ringwear.meshes.half_space import contact_radii
from ringwear.studies.study.answer import costs_of, reached
from ringwear.studies.study.errors import EIGENVALUE, values_of
from ringwear.studies.study.own import (
    read_meshes,
    read_quantities,
)
from ringwear.studies.study.way import Case
from ringwear.studies.study.ways.finite_elements import own_meshes

EDGES = np.array([0.0, 0.5, 1.0])


def case_of(times=(0.0, 0.1, 1.0)):
    scene = Scene.load("five_rings").changed(wear__times=list(times))
    case = Case.of(scene)
    problem = replace(
        case.problem, rings=Rings.constant(EDGES, np.array([1.0, 0.1])), compared_on=None
    )
    return replace(case, problem=replace(problem, compared_on=problem.face))


def make_mesh(path, rim_size, ring_size, growth=0.8):
    """Write a mesh with one ring edge at half the radius."""
    mesh = bisection.mesh(SizeField(tuple(EDGES), rim_size, ring_size, growth, 4.0))
    mesh.save(path, file_format="vtu")
    return str(path)


def test_files_of_one_name_get_different_names(tmp_path):
    paths = []
    for folder in ("one", "two"):
        (tmp_path / folder).mkdir()
        paths.append(make_mesh(tmp_path / folder / "mesh.vtu", 0.1, 0.1))
    other = make_mesh(tmp_path / "other.vtu", 0.1, 0.1)
    names = list(read_meshes(case_of().problem, [*paths, other, Mesh.load(other)]))
    assert names == [f"{paths[0]} (1)", f"{paths[1]} (2)", "other.vtu", "mesh 4"]


def test_a_mesh_file_fits_if_its_ring_edges_are_vertices(tmp_path):
    file = make_mesh(tmp_path / "mine.vtu", 0.1, 0.1)
    with pytest.raises(SceneError, match=r"ring edge at r = 0\.2 a"):
        read_meshes(Scene.load("five_rings").problem, file)
    (mesh,) = read_meshes(case_of().problem, file).values()
    assert 0.5 in contact_radii(mesh)
    with pytest.raises(SceneError, match="give mesh files"):
        read_meshes(case_of().problem, [3])


def test_the_least_eigenvalue_is_the_least_ratio_of_energies_on_the_same_pressures():
    case = case_of()
    mesh = bisection.mesh(SizeField(tuple(EDGES), 0.1, 0.1, 0.5, 4.0))
    (level,), way = own_meshes({"mine": mesh}, 3).levels, own_meshes({"mine": mesh}, 3)
    solution = way.solve(case.problem, level)
    values = values_of(case, solution, (EIGENVALUE,))
    compliance = solution.wear.compliance
    ratios = eigh(compliance.matrix, energy.compliance(compliance.space).matrix, eigvals_only=True)
    assert float(values[EIGENVALUE]) == pytest.approx(ratios.min(), rel=1e-6)


@pytest.mark.parametrize(
    ("errors", "cost"),
    [
        # halfway on both logarithmic scales
        ([1e-1, 1e-3], 200),
        # already the coarsest level
        ([1e-3, 1e-4], 100),
        ([1e-1, 2e-2], np.nan),
        # an error that is small by chance does not count
        ([1e-3, 1e-1], np.nan),
        # the solution is the reference itself
        ([1e-1, 0.0], 400),
    ],
)
def test_the_cost_of_an_accuracy_is_interpolated(errors, cost):
    found = reached(np.array([100.0, 400.0]), np.array(errors), 1e-2)
    assert found == pytest.approx(cost, nan_ok=True)


def test_costs_have_each_quantity_and_the_worst_one():
    table = pd.DataFrame({"error": [0.1, -0.001], "unknowns": [100, 400], "seconds": [1.0, 2.0]})
    table = table.assign(case="scene", way="uniform", quantity="indentation", when="start")
    table = table.assign(level=["0", "1"], estimate=np.nan, reference=1e-9)
    both = pd.concat([table, table.assign(quantity="pressure", error=[1.0, 0.1])])
    costs = costs_of(both.reset_index()).set_index(["quantity", "goal"])
    # halfway on logarithmic scales; the pressure does not reach it, nor the worst quantity
    assert costs.unknowns["indentation", 1e-2] == 200
    assert np.isnan(costs.unknowns["pressure", 1e-2])
    assert np.isnan(costs.unknowns["worst quantity", 1e-2])
    assert costs.of["worst quantity", 1e-2] == "pressure, start"
    assert np.isnan(costs.seconds["indentation", 1e-4])
    # one quantity has no worst one
    assert set(costs_of(table)["quantity"]) == {"indentation"}


def test_quantities_are_names_and_functions():
    def mean(result):
        return float(result.dataset.pressure.mean())

    known = ("pressure", "indentation")
    assert read_quantities(None, known) == ((), {})
    assert read_quantities(["pressure", mean], known) == (("pressure",), {"mean": mean})
    assert read_quantities({"p": mean}, known) == ((), {"p": mean})
    assert read_quantities(mean, known) == ((), {"mean": mean})
    with pytest.raises(SceneError, match="did you mean pressure"):
        read_quantities("presure", known)
