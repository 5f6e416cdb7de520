"""Stability of pairs of spaces: eigenvalues, errors, elements of the user, and refusals."""

from __future__ import annotations

import csv
import re

import numpy as np
import pytest
from skfem import ElementDG, ElementQuadP, ElementTriP1, ElementTriP1B, ElementTriP2

from ringwear import SceneError, main, study


@pytest.fixture(scope="module")
def results():
    return study("elements", "five_rings", quick=True, elements=[ElementTriP2()])


def name_of(pressure, degree):
    """Return the name of a pressure space under a displacement of degree 2."""
    if pressure == "as in ringwear run":
        return pressure
    if not degree:
        return "constant on facets"
    return f"{pressure}, k" + (f" - {2 - degree}" if degree < 2 else "")


def levels_of(results, pressure, degree, displacement="ElementTriP2"):
    """Return the errors of one pair on three levels, from coarse to fine, by quantity."""
    table = results.table
    rows = table[(table["case"] == displacement) & (table["way"] == name_of(pressure, degree))]
    by_part = {
        f"{quantity} {when}": levels["error"].to_numpy()
        for (quantity, when), levels in rows.groupby(["quantity", "when"])
    }
    assert {len(errors) for errors in by_part.values()} == {3}
    return by_part


STABLE = [
    ("continuous", 1),
    ("continuous", 2),
    ("broken at ring edges", 1),
    ("broken everywhere", 0),
    ("wear rate continuous", 1),
    ("as in ringwear run", 1),
]


# meshes by bisection are not of one shape at all levels
@pytest.mark.slow
@pytest.mark.gmsh
@pytest.mark.parametrize(("pressure", "degree"), STABLE)
def test_eigenvalues_of_stable_pairs_stay_bounded(results, pressure, degree):
    errors = levels_of(results, pressure, degree)
    eigenvalues = errors["least_eigenvalue all"]
    assert 0.1 < eigenvalues.min() <= eigenvalues.max() < 1.3 * eigenvalues.min()
    # the flat start F / (2 a E*), in closed form, and its pressure converge
    assert np.abs(errors["indentation start"]).max() <= 0.01
    assert abs(errors["indentation start"][-1]) <= 1e-3
    assert (np.diff(errors["pressure start"]) < 0).all()


@pytest.mark.slow
@pytest.mark.gmsh
def test_checkerboards_lose_the_pressure_but_not_the_indentation(results):
    errors = levels_of(results, "broken everywhere", 1)
    orders = -np.diff(np.log2(errors["least_eigenvalue all"]))
    np.testing.assert_allclose(orders, 2.0, atol=0.25)
    assert abs(errors["indentation start"][-1]) <= 1e-3
    assert errors["pressure start"].min() > 3
    assert (np.diff(errors["pressure start"]) > 0).all()
    # wear hides the checkerboards
    assert errors["indentation later"][-1] <= 1e-3
    assert errors["pressure later"][-1] <= 0.3
    stable = levels_of(results, "broken at ring edges", 1)
    assert errors["pressure later"][-1] < 2 * stable["pressure later"][-1]


@pytest.mark.slow
@pytest.mark.parametrize("pressure", ["broken at ring edges", "broken everywhere"])
def test_singular_pairs_are_refused(results, pressure):
    table = results.table
    (row,) = table[(table["case"] == "ElementTriP2") & (table["way"] == f"{pressure}, k")].to_dict(
        "records"
    )
    assert row["outcome"] == "refused"
    assert "is singular" in row["message"]


@pytest.mark.slow
def test_the_choice_table_classifies_all_pairs(results):
    choice = results.tables["choice"].set_index(["pressure", "pressure degree"])
    assert {key for key, row in choice.iterrows() if row["stable"] == "yes"} == set(STABLE)
    assert choice.loc[("broken everywhere", 1), "stable"] == "no"
    assert choice.loc[("broken everywhere", 2), "suits"] == "nothing: it is refused"
    assert choice.loc[("continuous", 1), "suits"] == "the start, and punches of one material"
    assert choice.loc[("as in ringwear run", 1), "suits"] == "the start and wear"
    assert any(line.startswith("6 of 9 pairs are stable") for line in results.conclusions)
    assert {"elements", "start_pressure", "locking", "checkerboards"} <= set(results.figures)


@pytest.mark.slow
def test_quadratic_triangles_lock(results):
    locking = results.table[results.table["case"] == "towards nu = 1/2"]
    errors = locking["error"].abs().to_numpy()
    assert errors[-1] > 10 * errors[0]
    assert any("(locking): ElementTriP2" in line for line in results.conclusions)


@pytest.mark.parametrize(
    ("elements", "message"),
    [
        ([ElementDG(ElementTriP2())], "ElementDG cannot carry.*use ElementTriP1 to"),
        ([ElementTriP1(), ElementTriP1()], "given twice"),
    ],
)
def test_elements_that_do_not_fit_are_refused(elements, message):
    with pytest.raises(SceneError, match=message):
        study("elements", "five_rings", quick=True, elements=elements)


@pytest.mark.parametrize(
    ("scene", "message"),
    [
        ("washer", "leave out punch.inner_radius"),
        # meshes by bisection resolve so many rings
        pytest.param("many_rings", "give fewer punch.rings", marks=pytest.mark.gmsh),
    ],
)
def test_hollow_punches_and_punches_of_many_rings_are_refused(scene, message):
    with pytest.raises(SceneError, match=re.escape(message)):
        study("elements", scene, quick=True, elements=[ElementTriP1()])


@pytest.mark.slow
@pytest.mark.gmsh
def test_names_of_elements_of_one_class_have_their_degree():
    elements = [ElementQuadP(2), ElementQuadP(3), ElementTriP1B()]
    results = study("elements", "flat_punch", quick=True, elements=elements)
    names = {"ElementQuadP of degree 2", "ElementQuadP of degree 3", "ElementTriP1B"}
    choice = results.tables["choice"]
    assert set(choice["displacement"]) == names
    # a flat punch of one ring has no edges at which pressures could break
    assert set(choice["pressure"]) == {"continuous", "broken everywhere", "as in ringwear run"}
    assert set(choice["stable"]) == {"yes", "no", "singular"}
    # bubbles inside elements do not change displacements on the contact
    bubbles = choice[(choice["displacement"] == "ElementTriP1B") & (choice["stable"] == "yes")]
    assert (bubbles["least eigenvalue"] > 0.1).all()


OWN = """
from skfem import ElementTriP1


class Mine(ElementTriP1):
    pass


broken = 3
"""


def command(tmp_path, *elements):
    flags = [part for element in elements for part in ("--element", element)]
    out = ["--out", str(tmp_path / "out")]
    return main(["study", "elements", "five_rings", "--quick", *flags, *out])


@pytest.mark.slow
def test_elements_from_the_command_line(tmp_path):
    """One element is named, the other is in a file; both are the same element."""
    (tmp_path / "own.py").write_text(OWN)
    assert command(tmp_path, "ElementTriP1", f"{tmp_path}/own.py:Mine") == 0
    names = {"elements.csv", "choice.csv", "choice.md", "choice.tex", "elements.png"}
    assert names <= {file.name for file in (tmp_path / "out").iterdir()}
    with open(tmp_path / "out" / "choice.csv", encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    values = [
        [row["least eigenvalue"] for row in rows if row["displacement"] == name]
        for name in ("ElementTriP1", "Mine")
    ]
    assert values[0] == values[1]
    assert len(values[0]) == 6


@pytest.mark.parametrize(
    ("element", "message"),
    [
        ("ElementTriCR", "ElementTriCR cannot carry the displacement: it is not continuous"),
        ("ElementTriP9", "is not an element"),
        ("{}/own.py:broken", "is not an element"),
        ("{}/own.py:Missing", "has no Missing"),
    ],
)
def test_the_command_line_refuses_elements_in_one_line(tmp_path, capsys, element, message):
    (tmp_path / "own.py").write_text(OWN)
    assert command(tmp_path, element.format(tmp_path)) == 2
    (line,) = [
        line for line in capsys.readouterr().err.splitlines() if line.startswith("ringwear: ")
    ]
    assert message in line
    assert not (tmp_path / "out").exists()


@pytest.mark.slow
@pytest.mark.gmsh
def test_every_displacement_has_a_stable_pressure():
    """Pressures of runs are stable with each displacement; checkerboards occur as in theory."""
    results = study("elements", "five_rings", quick=True)
    choice = results.tables["choice"]
    assert (choice[choice.pressure == "as in ringwear run"]["stable"] == "yes").all()
    by_degree = choice[choice.pressure == "broken everywhere"]
    for row in by_degree.to_dict("records"):
        less = row["degree"] - row["pressure degree"]
        assert row["stable"] == {0: "singular", 1: "no"}.get(less, "yes"), row
