"""Read the meshes of input decks of Abaqus and CalculiX, and of universal files (UNV).

Only the corners of plane and axisymmetric cells are read: the elements of ringwear have their own
nodes between them.
"""

import re
from collections.abc import Iterator
from itertools import islice
from pathlib import Path
from typing import NamedTuple

import numpy as np

from .errors import MeshError
from .radial import Array, Indices

PLANE_TYPE = re.compile(r"(?:CAX|CGAX|CPEG|CPE|CPS|DCAX|DC2D|AC2D|ACAX|STRI|S|M3D)(\d)\w*")
"""Types of elements in a plane, and the number of their nodes."""
CORNERS = {3: 3, 6: 3, 4: 4, 8: 4, 9: 4}
"""Number of corners by number of nodes; the corners come first."""
UNV_CORNERS = {1: 3, 2: 3, 4: 4, 5: 4}
"""Number of corners by the last digit of an element type in a universal file."""
UNV_PLANE = range(41, 100)
"""Element types of a universal file that lie in a plane: plane, axisymmetric and shells."""
UNV_BEAMS = (11, 21, 22, 23, 24)
"""Those of lines that have a record more."""


class CornerMesh(NamedTuple):
    """The corners of a mesh in a plane.

    Parameters
    ----------
    points : (n, 3) coordinates
    triangles, quads : (m, 3) and (m, 4) rows of `points`
    subdomains : numbers of cells by the names of their sets
    """

    points: Array
    triangles: Indices
    quads: Indices
    subdomains: dict[str, Indices] | None = None

    @property
    def size(self) -> int:
        """Number of cells."""
        return len(self.triangles) + len(self.quads)


def read_deck(path: Path) -> CornerMesh:
    """Read the nodes and the plane elements of an input deck; of several parts, the largest.

    Raises
    ------
    MeshError
        if there are no such elements, or if an element has a node that is not defined
    """
    parts = [part for part in _parts(path) if any(map(len, part.cells.values()))]
    if not parts:
        found = sorted({name for part in _parts(path) for name in part.others})
        raise MeshError(
            f"it has no elements in a plane{', only ' + ', '.join(found) if found else ''}: give "
            "axisymmetric or plane ones, CAX3, CAX4, CAX6, CAX8, CPE, CPS"
        )
    return max((part.corners() for part in parts), key=lambda mesh: np.ptp(mesh.points))


class _Part:
    """The nodes and elements of one part of a deck."""

    def __init__(self) -> None:
        self.nodes = list[Array]()
        self.cells: dict[int, list[Indices]] = {3: [], 4: []}
        self.others = set[str]()

    def corners(self) -> CornerMesh:
        """Return the mesh.

        Raises
        ------
        MeshError
            if an element has a node that is not defined
        """
        table = np.concatenate(self.nodes)
        numbers = table[:, 0].astype(np.int64)
        order = np.argsort(numbers, kind="stable")
        cells = {}
        for corners, blocks in self.cells.items():
            wanted = np.concatenate(blocks or [np.empty((0, corners), dtype=np.int64)])
            rows = np.searchsorted(numbers, wanted, sorter=order).clip(max=len(numbers) - 1)
            found = order[rows]
            if (numbers[found] != wanted).any():
                missing = wanted[numbers[found] != wanted][0]
                raise MeshError(f"an element has the node {missing}, which *NODE does not define")
            cells[corners] = found
        return CornerMesh(table[:, 1:4], cells[3], cells[4])


def _parts(path: Path) -> list[_Part]:
    """Return the parts of a deck; a deck without parts is one."""
    parts = [_Part()]
    for keyword, options, lines in _blocks(path):
        if keyword == "PART" or keyword == "END PART":
            parts.append(_Part())
        elif keyword == "NODE" and lines:
            parts[-1].nodes.append(_nodes(lines))
        elif keyword == "ELEMENT" and lines:
            name = options.get("TYPE", "").upper()
            found = PLANE_TYPE.fullmatch(name)
            # STRI65 has six nodes
            count = 6 if name == "STRI65" else int(found[1]) if found else 0
            if count not in CORNERS:
                parts[-1].others.add(name)
                continue
            numbers = np.fromstring(",".join(lines), dtype=np.int64, sep=",")
            if len(numbers) % (count + 1):
                raise MeshError(f"elements of type {name} do not have {count} nodes each")
            corners = CORNERS[count]
            parts[-1].cells[corners].append(numbers.reshape(-1, count + 1)[:, 1 : corners + 1])
    return parts


def _nodes(lines: list[str]) -> Array:
    """Return number and coordinates (n, 4) of nodes; a missing third coordinate is 0."""
    text = ",".join(line.rstrip(", ") for line in lines)
    numbers = np.fromstring(text.translate(FORTRAN), sep=",")
    count = len(lines[0].rstrip(", ").split(","))
    if count < 3 or len(numbers) != count * len(lines):
        raise MeshError("a line below *NODE has no number and coordinates: give them as 1, 0., 0.")
    table = np.zeros((len(lines), 4))
    table[:, : min(count, 4)] = numbers.reshape(-1, count)[:, :4]
    return table


FORTRAN = str.maketrans("dD", "ee")
"""Exponents of Fortran."""


def _blocks(path: Path) -> Iterator[tuple[str, dict[str, str], list[str]]]:
    """Yield each keyword of a deck with its options and the lines below it."""
    keyword, options, lines = "", dict[str, str](), list[str]()
    for line in path.read_text("utf-8", "replace").splitlines():
        text = line.strip()
        if not text or text.startswith("**"):
            continue
        if not text.startswith("*"):
            lines.append(text)
            continue
        if keyword:
            yield keyword, options, lines
        name, *given = text[1:].split(",")
        keyword, lines = name.strip().upper(), []
        pairs = (each.partition("=") for each in given)
        options = {key.strip().upper(): value.strip() for key, _, value in pairs}
        if keyword == "INCLUDE" and (file := options.get("INPUT")):
            yield from _blocks(path.parent / file)
            keyword = ""
    if keyword:
        yield keyword, options, lines


def read_universal(path: Path) -> CornerMesh:
    """Read the nodes (2411) and the plane elements (2412) of a universal file.

    Raises
    ------
    MeshError
        if the file has no such elements, or if an element has a node that is not defined
    """
    nodes, cells = np.empty((0, 4)), dict[int, list[list[int]]]({3: [], 4: []})
    for number, lines in _datasets(path):
        if number in (781, 2411):
            text = " ".join(lines).translate(FORTRAN)
            nodes = np.fromstring(text, sep=" ").reshape(-1, 7)[:, [0, 4, 5, 6]]
        elif number in (780, 2412):
            for kind, numbers in _universal_elements(lines):
                corners = UNV_CORNERS.get(kind % 10, 0)
                if kind in UNV_PLANE and corners:
                    # nodes in the middles of sides follow each corner
                    cells[corners].append(numbers[:: len(numbers) // corners][:corners])
    if not any(cells.values()):
        raise MeshError("it has no elements in a plane: give triangles or quadrilaterals")
    part = _Part()
    part.nodes.append(nodes)
    for corners, rows in cells.items():
        part.cells[corners].append(np.array(rows, dtype=np.int64).reshape(-1, corners))
    return part.corners()


def _datasets(path: Path) -> Iterator[tuple[int, list[str]]]:
    """Yield the number and the lines of each dataset of a universal file."""
    lines = iter(path.read_text("utf-8", "replace").splitlines())
    for line in lines:
        if line.strip() != "-1":
            continue
        number = next(lines, "").split()
        content = list[str]()
        for inner in lines:
            if inner.strip() == "-1":
                break
            content.append(inner)
        if number and number[0].isdigit():
            yield int(number[0]), content


def _universal_elements(lines: list[str]) -> Iterator[tuple[int, list[int]]]:
    """Yield the type and the nodes of each element."""
    rest = iter(lines)
    for head in rest:
        fields = [int(field) for field in head.split()]
        if len(fields) < 6:
            raise MeshError(f"the element record {head.strip()!r} has too few numbers")
        kind, count = fields[1], fields[5]
        if kind in UNV_BEAMS:
            next(rest, "")
        records = islice(rest, -(-count // 8))
        yield kind, [int(field) for record in records for field in record.split()]
