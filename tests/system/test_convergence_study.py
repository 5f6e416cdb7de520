"""Studies of convergence and refinement with meshes, elements and quantities of the user."""

from dataclasses import replace

import numpy as np
import pandas as pd
import pytest
import skfem
from groups import nightly

from ringwear import Method, Scene, SceneError, SizeField, bisection, method, study
from ringwear.meshes import as_half_space, structured

EDGES = (0.0, 0.2, 0.4, 0.6, 0.8, 1.0)
PRESSURE_AT_HALF = """
def at_half(result):
    pressure = result.dataset.pressure.isel(solver=0)
    return float(pressure.sel(time=0.1).interp(radius=0.5))
"""


@pytest.fixture(scope="module")
def sequence():
    """Return three meshes of a user, from coarse to fine."""
    return [
        bisection.mesh(SizeField(EDGES, size, size, 0.5, 5.0, 1.0)) for size in (0.2, 0.05, 0.01)
    ]


@pytest.fixture
def files(sequence, tmp_path):
    names = []
    for number, mesh in enumerate(sequence):
        names.append(str(tmp_path / f"mine_{number}.msh"))
        skfem.MeshTri(mesh.p, mesh.t).save(names[-1], file_format="gmsh22", binary=False)
    (tmp_path / "mine.py").write_text(PRESSURE_AT_HALF, "utf-8")
    return names


def errors(rows, quantity, when="all"):
    """Return the errors of a quantity, from coarse to fine."""
    return rows[(rows["quantity"] == quantity) & (rows["when"] == when)]["error"].to_numpy()


@pytest.mark.slow
def test_a_sequence_of_meshes_and_a_quantity_from_the_command_line(files, command, tmp_path):
    meshes, out = " ".join(f"--mesh {file}" for file in files), tmp_path / "out"
    options = "--quantity mine.py:at_half --degree 3 --quick --against unknowns --out out"
    command(f"study convergence five_rings {meshes} {options}")
    rows = pd.read_csv(out / "convergence.csv")
    assert rows["level"].unique().tolist() == ["mine_0.msh", "mine_1.msh", "mine_2.msh"]
    assert rows["way"].unique().tolist() == ["your meshes"]
    first, *_, last = np.abs(errors(rows, "at_half"))
    assert 0 < last < 1e-3 < first
    assert (np.diff(errors(rows, "pressure", "start")) < 0).all()
    # values and their errors give the same exact value
    own = rows[rows["quantity"] == "at_half"]
    exact = own["computed"] / (1 + own["error"])
    assert np.ptp(exact) <= 1e-12 * exact.iloc[0]
    remarks = pd.read_csv(out / "orders.csv")["remark"]
    assert remarks.str.contains("how your meshes are graded is not known").any()
    assert (out / "convergence.png").exists()
    # what a user takes away comes first: a row for the meshes, a column for the quantity
    head, _, row = (out / "answer.md").read_text("utf-8").splitlines()[:3]
    assert "at half" in head
    assert row.startswith("| your meshes |")


@pytest.mark.slow
def test_meshes_of_the_user_are_refined_beside_ours(sequence, tmp_path):
    results = study("refinement", "flat_punch", quick=True, meshes=sequence, degree=3)
    rows = results.table[results.table["way"] == "your meshes"]
    assert rows["level"].nunique() == 3
    assert (np.diff(np.abs(errors(rows, "indentation", "start"))) < 0).all()
    assert any(line.endswith(": stable.") for line in results.conclusions)
    assert "your meshes" in set(results.answer["way"])
    of_own = results.orders[results.orders["way"] == "your meshes"]
    assert (of_own["order"] > 0).any()
    assert {"uniform triangles", "adaptive triangles", "your meshes"} <= set(results.table["way"])
    written = set(results.save(tmp_path))
    assert {"refinement.csv", "answer.md", "costs.csv", "refinement.png"} <= written
    with pytest.raises(SceneError, match=r"--degree 7.*give 2 to 4"):
        study("refinement", "flat_punch", quick=True, meshes=sequence, degree=7)


def test_chosen_quantities_are_tabulated_and_drawn(sequence):
    results = study("convergence", "flat_punch", True, ["pressure"], meshes=sequence[:2])
    assert set(results.table["quantity"]) == {"pressure"}


def test_elements_of_the_user_are_taken_on_meshes_of_the_user(sequence):
    given = {"quantities": ["indentation"], "meshes": sequence[:2], "quick": True}
    table = study("convergence", "flat_punch", elements=["P2", "ElementTriP2B"], **given).table
    # a bubble inside of elements adds unknowns, which are eliminated there
    assert table["way"].unique().tolist() == ["your meshes, TriP2", "your meshes, TriP2B"]
    assert (table["error"].abs() < 0.02).all()
    with pytest.raises(SceneError, match="--element QuadP: your meshes consist of triangles"):
        study("convergence", "flat_punch", elements=[skfem.ElementQuadP(3)], **given)
    quads = structured.below_nodes(np.linspace(0, 1, 5), 20.0)
    mixed = [*sequence[:1], as_half_space(quads, np.array([0.0, 1.0]))]
    with pytest.raises(SceneError, match="all triangles or all quadrilaterals"):
        study("convergence", "flat_punch", True, meshes=mixed)


@pytest.mark.slow
def test_an_element_from_the_command_line(command):
    command("study convergence flat_punch --element ElementTriP2B --quick --out out")
    rows = pd.read_csv("out/orders.csv").set_index(["way", "quantity", "when"])
    # the bubble adds nothing to the degree of P2, whose order is 4
    graded = rows.loc["TriP2B, graded", "indentation", "start"]
    assert float(graded["order"]) == pytest.approx(4, abs=0.3)


class Halved(Method):
    """Half of the indentation of MDR: a method of a user that errs by 50 %."""

    name = "halved"

    def solve(self, problem, stages):
        solution = method("mdr").solve(problem, stages)
        changed = solution.compared | {"indentation": solution.compared["indentation"] / 2}
        return replace(solution, compared=changed)


@pytest.mark.slow
def test_a_method_of_the_user_enters_every_study_that_has_methods():
    scene = Scene.load("flat_punch").changed(wear__times=[0.0, 0.1], accuracy__rtol=1e-3)
    for name in ("convergence", "refinement", "tradeoff", "extremes"):
        more = {"vary": {"punch.radius": [1.0]}} if name == "extremes" else {}
        results = study(name, scene, quick=True, methods=[Halved()], **more)
        rows = results.table[results.table["way"] == "halved"]
        assert errors(rows, "indentation", "start") == pytest.approx(-0.5, abs=1e-3), name
    assert (rows["verdict"] == "wrong").any()


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"methods": ["direct"]}, "has no sequence of levels"),
        ({"methods": ["abaqus"]}, "is not a method"),
        ({"quantities": "presure"}, "did you mean pressure"),
        ({"elements": [skfem.ElementTriCR()]}, "has to be continuous"),
        ({"quantities": {"q": lambda result: result.nothing}}, "quantity q fails: AttributeError"),
        ({"quantities": {"q": lambda _: np.nan}}, "quantity q is nan"),
        ({"steps": [-1.0]}, "give steps above 0"),
        ({"against": "time"}, "give one of size, unknowns, seconds"),
        ({"meshes": ["no_such.msh"]}, "--mesh no_such.msh"),
    ],
)
def test_options_that_do_not_fit_are_refused(options, message):
    with pytest.raises(SceneError, match=message):
        study("convergence", "flat_punch", quick=True, **options)


def test_a_punch_whose_contact_moves_needs_times():
    with pytest.raises(SceneError, match=r"give wear\.times"):
        study("convergence", Scene.load("sphere").changed(wear__times=[]), quick=True)


@pytest.mark.slow
def test_the_force_of_a_fixed_indentation_is_measured():
    load = {"indentation": 1.0}
    scene = Scene.load("five_rings").changed(load=load, wear__times=[0.0, 0.1, 1.0], punch__rings=2)
    results = study("convergence", scene, quick=True, methods=["mdr"])
    rows = results.table[results.table["case"] == "scene"]
    assert "indentation" not in set(rows["quantity"])
    graded = np.abs(errors(rows[rows["way"] == "MDR degree 2, graded"], "normal_force", "later"))
    assert (np.diff(graded) < 0).all()
    assert graded[-1] < 1e-6


@pytest.mark.slow
@pytest.mark.parametrize("scene", ["sphere", *nightly("duty_cycle")])
def test_punches_whose_contact_moves_have_all_quantities(scene):
    results = study("convergence", scene, quick=True)
    table = results.table
    assert (table["outcome"] == "solved").all()
    names = {"indentation", "pressure", "profile", "rms_slope", "contact_radius", "stress_on_axis"}
    # a punch of one ring carries the given force on it
    names |= {"ring_force", "ring_worn_volume"} if scene == "duty_cycle" else set()
    assert names <= set(table["quantity"])
    assert {"MDR", "BEM", "P1 below cells", "P4 below cells", "Q2 below cells"} <= set(table["way"])
    finest = table[(table["quantity"] == "indentation") & (table["when"] == "later")]
    assert (finest.groupby("way")["error"].last().abs() < 0.03).all()
    assert results.orders["theory"].isna().all()
    assert results.orders["remark"].str.contains("edges of the contact lie anywhere").all()
