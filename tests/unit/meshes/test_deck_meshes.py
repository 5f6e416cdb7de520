"""Meshes in input decks of Abaqus and CalculiX, and in universal files."""

import numpy as np
import pytest

from ringwear import MeshError, Scene, SizeField, bisection, deck
from ringwear.meshes.decks import read_deck
from ringwear.meshes.files import read

EDGES = np.array([0.0, 0.5, 1.0])


@pytest.fixture(scope="module")
def ours():
    return bisection.mesh(SizeField((0.0, 0.5, 1.0), 0.05, 0.1, 0.6, 4.0))


def with_middles(mesh):
    """Return points and cells with nodes in the middles of sides, after the corners."""
    middles = mesh.p[:, mesh.facets].mean(axis=1)
    return np.hstack([mesh.p, middles]).T, np.vstack([mesh.t, mesh.t2f + mesh.nvertices]).T


def deck_text(points, cells, kind, before="", third=""):
    nodes = (f"{n}, {r:.17g}, {z:.17g}{third}" for n, (r, z) in enumerate(points, 1))
    rows = (", ".join(map(str, [n, *row])) for n, row in enumerate((cells + 1).tolist(), 1))
    return "\n".join([before, "*Node", *nodes, f"*Element, type={kind}, elset=SOIL", *rows, ""])


def same(mesh, ours):
    """Return whether a mesh has the cells of ours, in any order."""
    middles = [
        np.sort_complex(np.round(m.p[:, m.t].mean(axis=1).T @ [1, 1j], 12)) for m in (mesh, ours)
    ]
    return middles[0].shape == middles[1].shape and np.allclose(*middles, atol=1e-11)


@pytest.mark.parametrize("kind", ["CAX3", "CPE3", "CPS3", "CAX6", "CAX6M", "CPE6H", "STRI65"])
def test_plane_elements_of_decks_are_read(tmp_path, ours, kind):
    points, cells = (ours.p.T, ours.t.T) if kind.endswith("3") else with_middles(ours)
    path = tmp_path / "soil.inp"
    path.write_text("** a comment\n*HEADING\n" + deck_text(points, cells, kind))
    assert same(read(path, EDGES), ours)


def test_of_several_parts_the_largest_is_read(tmp_path, ours):
    soil = deck_text(ours.p.T, ours.t.T, "CAX3", "*Part, name=SOIL", ", 0.")
    punch = deck_text(ours.p.T / 8, ours.t.T, "CAX3", "*Part, name=PUNCH")
    rest = "*Element, type=MASS, elset=REF\n1, 1\n*End Part\n*Node, nset=REF\n9999, 0., 1.\n"
    (tmp_path / "nodes.inp").write_text(soil + "*End Part\n")
    for text in (
        f"{punch}*End Part\n{soil}{rest}",
        f"{punch}*End Part\n*Include, Input=nodes.inp\n",
    ):
        (tmp_path / "two.inp").write_text(text)
        assert same(read(tmp_path / "two.inp", EDGES), ours)


def instance(place, text):
    """Return a deck in which a part without nodes has an instance at a place, with its own mesh."""
    head = '*Part, name="my soil"\n*End Part\n*Assembly, name=A\n'
    head += f'*Instance, name=I, part="my soil"\n{place}'
    return f"{head}{text}*End Instance\n*End Assembly\n"


# decks that say the same as one with all nodes and elements in lines
SPELLINGS = {
    "byte order mark": lambda nodes, cells: (nodes + cells).encode("utf-8-sig"),
    "UTF-16": lambda nodes, cells: (nodes + cells).encode("utf-16"),
    "cells go on": lambda nodes, cells: nodes + cells.replace(", ", ",\n "),
    "keyword goes on": lambda nodes, cells: nodes + cells.replace(", elset", ",\n  elset"),
    "coordinates left blank": lambda nodes, cells: nodes.replace("\n1, 0, 0\n", "\n1\n") + cells,
    "empty place": lambda nodes, cells: nodes.replace(", 0, ", ",, ") + cells,
    "exponents of Fortran": lambda nodes, cells: nodes.replace("0.5,", "5.D-1,") + cells,
    "data included": lambda _, cells: "*Node\n*INCLUDE, INPUT='s/lines.txt'\n" + cells,
    "input": lambda _, cells: '*Node, nset=A, INPUT="s/lines.txt"\n' + cells,
    "backslash": lambda _, cells: "*Include, input=s\\nodes.txt\n" + cells,
    "node again": lambda nodes, cells: "*Node\n1, 9., 9.\n" + nodes + cells,
    "system of the deck": lambda nodes, cells: "*System\n" + nodes + cells,
    "instance": lambda nodes, cells: instance("", nodes + cells),
    # a quarter of a turn, and back with the instance
    "rotated": lambda nodes, cells: instance(
        "0., 0., 0.\n0., 0., 0., 0., 0., 1., -90.\n",
        "\n".join(f"{n}, -{z}, {r}" for n, r, z in map(split, lines(nodes))).join(["*Node\n", "\n"])
        + cells,
    ),
    "moved": lambda nodes, cells: instance(
        "0., -3., 0.\n",
        "\n".join(f"{n}, {r}, {float(z) + 3:.17g}" for n, r, z in map(split, lines(nodes))).join(
            ["*Node\n", "\n"]
        )
        + cells,
    ),
}


def lines(nodes):
    return nodes.strip().splitlines()[1:]


def split(line):
    return line.split(", ")


@pytest.mark.parametrize("spelling", SPELLINGS)
def test_the_same_mesh_in_other_spellings(tmp_path, ours, spelling):
    text = deck_text(ours.p.T, ours.t.T, "CAX3")
    nodes, cells = (part.strip("\n") + "\n" for part in text.split("*Element"))
    (tmp_path / "s").mkdir()
    (tmp_path / "s" / "nodes.txt").write_text(nodes)
    (tmp_path / "s" / "lines.txt").write_text("\n".join(lines(nodes)))
    written = SPELLINGS[spelling](nodes, "*Element" + cells)
    path = tmp_path / "soil.inp"
    path.write_bytes(written if isinstance(written, bytes) else written.encode())
    assert same(read(path, EDGES), ours)


@pytest.mark.parametrize("program", ["calculix", "abaqus"])
@pytest.mark.parametrize("element", ["Q1", "Q2S"])
def test_decks_of_ringwear_can_be_read_as_meshes(tmp_path, program, element):
    scene = Scene.load("five_rings").changed(methods=["mdr"], wear__times=[0.0])
    deck(scene, program, tmp_path / "deck", element=element, size=0.3, reach=20.0)
    for path in (tmp_path / "deck").glob("*.inp"):
        edges, radius = scene.problem.ring_edges, scene.punch.radius
        mesh = read(path, edges, radius)
        assert len(mesh.t) == 4
        assert mesh.p.max() == pytest.approx(20.0)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (
            "*Node\n1, 0., 0., 0.\n*Element, type=C3D8\n1, 1,1,1,1,1,1,1,1\n",
            "only C3D8: give .*CAX3",
        ),
        ("*Node\n1, 0., 0.\n*Element, type=CAX3\n1, 1, 1, 7\n", "node 7, which"),
        ("*Node\n1\n*Element, type=CAX3\n1, 1, 1, 1\n", "below \\*NODE"),
        ("*Node\n1, 0., 0.\n*Element, type=CAX4\n1, 1, 1, 1\n", "do not have 4 nodes"),
        ("nothing\n", "no elements in a plane"),
        ("*Element, type=CAX3\n1, 1, 2, 3\n", "defines no nodes"),
        ("*Include, input=bad.inp\n", "includes itself"),
        ("*Include, input=none.inp\n", "none.inp cannot be read"),
        ("*Node\n1, 0, <h>\n", "line 1 of bad.inp: below \\*NODE: .* not a number"),
        ("*Node, system=C\n1, 0, 0\n", "coordinates that are not rectangular"),
        ("*Node\n1, 0, 0\n*Ngen\n1, 9, 1\n", "line 3 of bad.inp: \\*NGEN makes or moves"),
        ("*System\n0, 0, 0, 1, 1, 1\n", "\\*SYSTEM makes or moves"),
        ("*Elcopy, old set=A, element shift=9\n", "\\*ELCOPY makes or moves"),
        ("*Instance, name=A, part=B\n*End Instance\n", "does not contain above"),
        ("*Part, name=B\n*End Part\n*Instance, part=B\n0, 1\n", "place of the \\*INSTANCE"),
    ],
)
def test_faults_of_decks_are_named(tmp_path, text, message):
    path = tmp_path / "bad.inp"
    path.write_text(text)
    with pytest.raises(MeshError, match=message):
        read_deck(path)


@pytest.mark.gmsh
@pytest.mark.parametrize("second_order", [False, True])
def test_universal_files_are_read(tmp_path, ours, second_order):
    points, cells, kind = ours.p.T, ours.t.T, 81
    if second_order:
        points, cells = with_middles(ours)
        # nodes in the middles of sides follow each corner
        cells, kind = cells[:, [0, 3, 1, 4, 2, 5]], 82
    lines = ["    -1", "  2411"]
    for number, (r, z) in enumerate(points, 1):
        lines += [f"{number:10d}{1:10d}{1:10d}{11:10d}"]
        lines += ["".join(f"{x:25.16E}".replace("E", "D") for x in (r, z, 0.0))]
    lines += ["    -1", "    -1", "  2412", f"{1:10d}{11:10d}{0:10d}{0:10d}{7:10d}{2:10d}"]
    lines += [f"{0:10d}{1:10d}{1:10d}", f"{1:10d}{2:10d}"]
    for number, row in enumerate((cells + 1).tolist(), 2):
        lines += [f"{number:10d}{kind:10d}{1:10d}{1:10d}{7:10d}{len(row):10d}"]
        lines += ["".join(f"{node:10d}" for node in row)]
    path = tmp_path / "disc.unv"
    path.write_text("\n".join([*lines, "    -1", ""]))
    assert same(read(path, EDGES), ours)
