"""The study of convergence with meshes, elements, steps and quantities of the user."""

from __future__ import annotations

import csv

import numpy as np
import pytest
import skfem

from ringwear import Scene, SceneError, SizeField, bisection, main, study

EDGES = (0.0, 0.2, 0.4, 0.6, 0.8, 1.0)
PRESSURE_AT_HALF = """
def at_half(result):
    pressure = result.dataset.pressure.isel(solver=0)
    return float(pressure.sel(time=0.1).interp(radius=0.5))


def fails(result):
    return result.no_such_thing
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


def at_half(result):
    pressure = result.dataset.pressure.isel(solver=0)
    return float(pressure.sel(time=0.1).interp(radius=0.5))


def test_a_sequence_of_meshes_an_element_and_a_quantity_from_python(sequence):
    results = study(
        "convergence",
        "five_rings",
        quick=True,
        meshes=sequence,
        elements=[skfem.ElementTriP2(), skfem.ElementTriP3()],
        quantities={"p at .5 a": at_half},
        against="unknowns",
    )
    levels = results.table
    assert list(levels.family.unique()) == ["FEM TriP2, your meshes", "FEM TriP3, your meshes"]
    assert (levels.groupby("family").size() == 3).all()
    for _, rows in levels.groupby("family"):
        assert (np.diff(rows["pressure at start"]) < 0).all()
        assert abs(rows["p at .5 a"].iloc[-1]) < 0.5 * abs(rows["p at .5 a"].iloc[0])
        # values and their errors give the same exact value
        exact = rows["value of p at .5 a"] / (1 + rows["p at .5 a"])
        assert np.ptp(exact) <= 1e-12 * exact.iloc[0]
    reasons = results.orders[results.orders.quantity == "d0"].theory
    assert reasons.str.contains("how your meshes are graded is not known").all()
    (axes, *_) = results.figures["convergence_your_meshes"].axes
    assert axes.get_xlabel() == "number of unknowns"


def test_a_sequence_of_meshes_and_a_quantity_from_the_command_line(files, tmp_path):
    out, options = tmp_path / "out", []
    for file in files:
        options += ["--mesh", file]
    options += ["--quantity", f"{tmp_path / 'mine.py'}:at_half", "--degree", "3", "--quick"]
    assert main(["study", "convergence", "five_rings", *options, "--out", str(out)]) == 0
    rows = list(csv.DictReader((out / "convergence.csv").read_text("utf-8").splitlines()))
    assert [row["setting"] for row in rows] == ["mine_0.msh", "mine_1.msh", "mine_2.msh"]
    assert {row["family"] for row in rows} == {"FEM P3, your meshes"}
    assert 0 < abs(float(rows[-1]["at_half"])) < 1e-3 < abs(float(rows[0]["at_half"]))
    assert (out / "convergence.png").exists()


def test_an_element_from_the_command_line(tmp_path):
    options = ["--element", "ElementTriP2B", "--quick", "--out", str(tmp_path)]
    assert main(["study", "convergence", "flat_punch", *options]) == 0
    rows = list(csv.DictReader((tmp_path / "orders.csv").read_text("utf-8").splitlines()))
    (graded,) = (
        row
        for row in rows
        if (row["refined"], row["quantity"]) == ("FEM TriP2B, graded, scene", "d0")
    )
    # the bubble adds nothing to the degree of P2, whose order is 4
    assert float(graded["least squares"]) == pytest.approx(4, abs=0.3)


def test_time_steps_of_the_user_converge_with_first_order():
    scene = Scene.load("five_rings").changed(wear__times=[0.0, 0.5, 1.0])
    results = study("convergence", scene, quick=True, steps=[0.1, 0.05, 0.025, 0.0125])
    judged = results.orders[results.orders["expected order"] == 1]
    assert set(judged.quantity) >= {"d(t)", "pressure", "profile", "ring forces"}
    assert (judged["within 0.15"] == "yes").all()


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"methods": ["direct"]}, "has no sequence of levels"),
        ({"methods": ["abaqus"]}, "is not a method"),
        ({"elements": [skfem.ElementTriCR()]}, "has to be continuous"),
        ({"quantities": {"q": lambda result: result.nothing}}, "quantity q fails: AttributeError"),
        ({"quantities": {"q": lambda _: np.nan}}, "quantity q is nan"),
        ({"steps": [-1.0]}, "give positive steps"),
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


def test_the_error_of_a_user_function_names_it(files, tmp_path, capsys):
    options = ["--mesh", files[0], "--quantity", f"{tmp_path / 'mine.py'}:fails", "--quick"]
    assert main(["study", "convergence", "five_rings", *options, "--out", str(tmp_path / "o")]) == 2
    assert "quantity fails fails: AttributeError" in capsys.readouterr().err


def test_the_force_of_a_fixed_indentation_is_measured():
    load = {"indentation": 1.0}
    scene = Scene.load("five_rings").changed(load=load, wear__times=[0.0, 0.1, 1.0], punch__rings=2)
    results = study("convergence", scene, quick=True, methods=["mdr"])
    assert "d(t)" not in results.table
    graded = results.table[results.table.family == "MDR degree 2, graded, scene"]
    assert (np.diff(graded["normal force"]) < 0).all()
    assert graded["normal force"].iloc[-1] < 1e-6


@pytest.mark.slow
@pytest.mark.parametrize("scene", ["sphere", "duty_cycle"])
def test_punches_whose_contact_moves_have_all_columns(scene):
    results = study("convergence", scene, quick=True)
    assert not results.table.remark.notna().any()
    columns = {"d(t)", "pressure", "profile", "RMS slope", "contact radius", "stresses inside"}
    # a punch of one ring carries the given force on it
    columns |= {"ring forces", "worn volume"} if scene == "duty_cycle" else {"pressure at start"}
    finest = results.table.groupby("family").last()
    assert {"MDR", "BEM", "FEM P1", "FEM P4", "FEM Q1", "FEM Q2"} <= set(finest.index)
    assert finest[list(columns - {"stresses inside"})].notna().all().all()
    assert (finest["d(t)"] < 0.03).all()
    assert results.orders["expected order"].isna().all()
    assert results.orders.theory.str.contains("edges of the contact lie anywhere").all()
