"""Input decks: their meshes, pressures computed from forces, and readers of output files."""

import numpy as np
import pytest

from ringwear import Scene, SceneError, deck
from ringwear.meshes.structured import growing_distances
from ringwear.studies.check.tables import read
from ringwear.studies.decks.deck import refusal
from ringwear.studies.decks.mesh import deck_mesh
from ringwear.studies.decks.reports import pressures_of, read_dat, read_rpt
from ringwear.studies.tables.numbers import fortran_number

RINGS = np.array([0.0, 0.3, 0.35, 1.0])
# the part of a deck that readers use: one ring of two linear elements, radii 0, 1 and 2, two steps
DECK = """*HEADING
** times: 0, 0.5
** ring edges: 0, 2
** wear at inner edges: 1
** wear at outer edges: 1
** displacements times: 1
** lowest height: 0
*NODE, NSET=ALL
1, 0, 0, 0.
2, 1, 0, 0.
3, 2, 0, 0.
4, 2, -1, 0.
*ELEMENT, TYPE=CAX4, ELSET=SOLID
*NSET, NSET=CONTACT
1, 2, 3
"""
# nodal forces of the pressure 1: int N 2 pi r dr
FORCES = 2 * np.pi * np.array([1 / 6, 1.0, 5 / 6])
DAT = """
 forces (fx,fy,fz) for set CONTACT and time  0.{end}000000E+01

"""
# a report of reaction forces in the format shown in "Getting Started with Abaqus"
RPT = """Field Output Report

Source 1
---------

   ODB: prescribed.odb
   Step: STEP-{step}
   Frame: Increment      1: Step Time =    1.000

Loc 1 : Nodal values from source 1

Output sorted by column "Node Label".

Field Output reported at nodes for part: PART-1-1

            Node       RF.RF2
           Label       @Loc 1
-----------------------------
{rows}

  Minimum                -1.
         At Node           2
           Total          -5.
"""


def write(folder, ending, text):
    (folder / "job.inp").write_text(DECK, "utf-8")
    (folder / f"job{ending}").write_text(text, "utf-8")
    return folder / f"job{ending}"


@pytest.mark.parametrize("quadratic", [False, True])
def test_meshes_are_what_programs_ask_for(quadratic):
    mesh = deck_mesh(RINGS[1:], 0.2, 50.0, quadratic)
    points = mesh.points * [1, -1]
    corners = points[mesh.cells[:, :4]]
    sides = np.roll(corners, -1, axis=1)
    # corners are anticlockwise, and midside nodes lie between them in this order
    turns = corners[..., 0] * sides[..., 1] - sides[..., 0] * corners[..., 1]
    assert (turns.sum(axis=1) > 0).all()
    if quadratic:
        np.testing.assert_allclose(points[mesh.cells[:, 4:]], (corners + sides) / 2)
    contact = points[mesh.contact]
    assert (np.diff(contact[:, 0]) > 0).all()
    assert not contact[:, 1].any()
    assert set(RINGS[1:]) <= set(contact[:, 0])
    assert contact[0, 0] == 0.3
    for cell, side in mesh.faces:
        assert not points[mesh.cells[cell, [side - 1, side % 4]], 1].any()
    assert not points[mesh.axis, 0].any()
    np.testing.assert_allclose(np.hypot(*points[mesh.far].T).max(), 50)


def test_sizes_grow_with_the_distance():
    steps = np.diff(growing_distances(2.0, 0.01, 0.1, 0.5))
    assert steps.sum() == pytest.approx(2)
    assert steps[0] == pytest.approx(0.01, rel=0.3)
    assert steps.max() <= 0.1 * (1 + 1e-9)
    assert (steps[1:] / steps[:-1] < 1.7).all()


@pytest.mark.parametrize("degree", [1, 2])
def test_pressures_of_the_functions_of_elements_are_exact(degree):
    """Nodal forces of p = 1 + r^degree, by an independent Gauss rule, give p back."""
    radii = np.array([0.0, 0.5, 1.0, 1.2, 1.4])
    places, weights = np.polynomial.legendre.leggauss(12)
    forces = np.zeros(5)
    for first in range(0, 4, degree):
        nodes = radii[first : first + degree + 1]
        at = nodes[0] + (nodes[-1] - nodes[0]) * (1 + places) / 2
        for number in range(degree + 1):
            others = np.delete(nodes, number)
            function = np.prod([(at - of) / (nodes[number] - of) for of in others], axis=0)
            shares = weights * (nodes[-1] - nodes[0]) / 2 * 2 * np.pi * at
            forces[first + number] += function @ (shares * (1 + at**degree))
    pressures = pressures_of(radii, forces, degree == 2, np.ones_like)
    np.testing.assert_allclose(pressures, 1 + radii**degree)


def dat(forces):
    """Return the report of CalculiX, of a sector of two degrees; pressing forces are negative."""
    rows = "".join(f" {n}  0.0E+00 {-f / 180:.9E}  0.0E+00\n" for n, f in enumerate(forces, 1))
    return "".join(DAT.format(end=end) + rows for end in (1, 2))


@pytest.mark.parametrize("exponent", ["D", "d", "E", "e"])
def test_the_dat_of_calculix(exponent, tmp_path):
    table = read_dat(write(tmp_path, ".dat", dat(FORCES).replace("E", exponent)))
    assert table.time.tolist() == [0.0] * 3 + [0.5] * 3
    assert table.radius.tolist() == [0.0, 1.0, 2.0] * 2
    # at the start, the pressure at the rim is left out
    np.testing.assert_allclose(table.pressure, [1, 1, np.nan, 1, 1, 1], rtol=1e-5)
    np.testing.assert_allclose(table.normal_force, 4 * np.pi, rtol=1e-5)


@pytest.mark.parametrize(
    ("text", "number"),
    [("1.0D-03", 1e-3), ("-2.5d+1", -25.0), ("1.0-103", 1e-103), ("4", 4.0), (".5+101", 5e100)],
)
def test_numbers_of_fortran(text, number):
    """Fortran leaves out the letter if the exponent has three digits."""
    assert fortran_number(text) == number


def test_a_run_that_stopped_is_refused(tmp_path):
    path = write(tmp_path, ".dat", DAT.format(end=1) + " 1  0.0E+00 -1.0E+00  0.0E+00\n" * 3)
    with pytest.raises(SceneError, match="step 2 of 2 is missing"):
        read_dat(path)
    lines = DAT.format(end=1) + " 1  0.0E+00  NaN  0.0E+00\n" * 3
    with pytest.raises(SceneError, match="a force of step 1 is not a number"):
        read_dat(write(tmp_path, ".dat", lines + lines.replace("1.0", "2.0")))
    (tmp_path / "job.inp").unlink()
    with pytest.raises(SceneError, match=r"put the deck job\.inp"):
        read_dat(path)


def test_the_report_of_abaqus(tmp_path):
    """Abaqus reports forces of the whole circumference, with numbers such as -1047.2E-03."""
    rows = "\n".join(f"{n:16}  {-1e3 * f:.6g}E-03" for n, f in enumerate(FORCES, 1))
    path = write(tmp_path, ".rpt", "".join(RPT.format(step=n, rows=rows) for n in (1, 2)))
    table = read_rpt(path)
    assert table.time.tolist() == [0.0] * 3 + [0.5] * 3
    np.testing.assert_allclose(table.pressure, [1, 1, np.nan, 1, 1, 1], rtol=1e-5)
    pressures = RPT.replace("RF.RF2", "CPRESS").format(step=2, rows="1 2.5E+00\n2 2.\n3 1.")
    path.write_text(pressures, "utf-8")
    assert read_rpt(path).pressure.tolist() == [2.5, 2.0, 1.0]


def test_scenes_without_a_deck_are_refused():
    rings = Scene.load("five_rings")
    assert not refusal(rings, "calculix")
    assert "recess" in refusal(Scene.load("recessed_binder"), "abaqus")
    soft = rings.changed(half_space__poisson_ratio=0.5)
    assert "lock" in refusal(soft, "calculix")
    assert not refusal(soft, "abaqus")
    with pytest.raises(SceneError, match="--reach"):
        deck_mesh(RINGS, 0.1, 2.0, False)


def test_results_of_a_deck_of_another_scene_are_reported(tmp_path, caplog):
    """One line names the keys that change what is modelled; methods and accuracy do not."""
    flat = Scene.load("flat_punch").changed(methods=["mdr"], punch__radius=2.0, wear__times=[0.0])
    path = write(tmp_path, ".dat", dat(FORCES))
    other = flat.changed(half_space__poisson_ratio=0.4, punch__radius=3.0, accuracy__rtol=1e-3)
    for modelled, keys in ((other, "half_space.poisson_ratio, punch.radius"), (flat, "")):
        (tmp_path / "scene.toml").write_text(modelled.to_toml(), "utf-8")
        caplog.clear()
        with caplog.at_level("WARNING", logger="ringwear"):
            read(path, "theirs", flat, {}, "")
        lines = [line for line in caplog.messages if "scene.toml" in line]
        assert len(lines) == bool(keys)
        assert all(line.endswith(f"differs in {keys}") and str(path) in line for line in lines)


@pytest.mark.parametrize(
    ("name", "instead"),
    [
        ("mine.toml", "give the scene first"),
        ("prescribed.inp", r"give the \.dat of CalculiX"),
        ("prescribed.FRD", r"give the \.dat of the same name"),
        ("prescribed.odb", r"ends in \.rpt"),
    ],
)
def test_files_that_are_no_results_are_refused_with_the_right_one(name, instead, tmp_path):
    (tmp_path / name).write_text("*HEADING\n", "utf-8")
    with pytest.raises(SceneError, match=instead) as refused:
        read(str(tmp_path / name), "theirs", Scene.load("flat_punch"), {}, "")
    assert "\n" not in str(refused.value)
    assert name in str(refused.value)


@pytest.mark.parametrize("program", ["Abaqus", "CalculiX"])
def test_names_of_programs_may_be_in_upper_and_lower_case(program, tmp_path):
    files = deck("flat_punch", program, tmp_path / "deck", size=0.4, reach=50, times=[0])
    assert "prescribed.inp" in {file.name for file in files}
