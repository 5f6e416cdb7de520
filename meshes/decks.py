"""Read the meshes of input decks of Abaqus and CalculiX.

Only the corners of plane and axisymmetric cells are read: the elements of ringwear have their own
nodes between them. A keyword that would give or change nodes or elements in another way is refused
by its name.
"""

import codecs
import math
import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import NamedTuple

import numpy as np
from scipy.spatial.transform import Rotation

from .errors import MeshError
from .radial import Array, Indices

PLANE_TYPE = re.compile(r"(?:CAX|CGAX|CPEG|CPE|CPS|DCAX|DC2D|AC2D|ACAX|STRI|S|M3D)(\d)\w*")
"""Types of elements in a plane, and the number of their nodes."""
CORNERS = {3: 3, 6: 3, 4: 4, 8: 4, 9: 4}
"""Number of corners by number of nodes; the corners come first."""
REFUSED = re.compile(
    r"SYSTEM|NGEN|NFILL|NCOPY|NMAP|ELGEN|ELCOPY|IMPERFECTION|IMPORT|SYMMETRIC MODEL GENERATION"
)
"""Keywords that would make or move nodes and elements."""
FORTRAN = str.maketrans("dD", "ee")
"""Exponents of Fortran."""


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


class _Block(NamedTuple):
    """A keyword of a deck with its options, and the lines below it."""

    keyword: str
    options: dict[str, str]
    lines: list[str]
    place: str


@dataclass
class _Body:
    """The nodes and elements of a part, of an instance of a part, or of the rest of a deck.

    An instance is translated, and then rotated about an axis that goes through a point.
    """

    nodes: list[Array] = field(default_factory=list)
    cells: dict[int, list[Indices]] = field(default_factory=lambda: {3: [], 4: []})
    others: set[str] = field(default_factory=set)
    translation: Array = field(default_factory=lambda: np.zeros(3))
    rotation: Rotation = field(default_factory=Rotation.identity)
    axis_point: Array = field(default_factory=lambda: np.zeros(3))

    @property
    def in_a_plane(self) -> bool:
        """Whether there are elements in a plane."""
        return any(map(len, self.cells.values()))

    def corners(self) -> CornerMesh:
        """Return the mesh.

        Raises
        ------
        MeshError
            if an element has a node that is not defined
        """
        if not self.nodes:
            raise MeshError("it has elements, but *NODE defines no nodes: include their file")
        table = np.concatenate(self.nodes)
        numbers = table[:, 0].astype(np.int64)
        order = np.argsort(numbers, kind="stable")
        cells = {}
        for corners, blocks in self.cells.items():
            wanted = np.concatenate(blocks or [np.empty((0, corners), dtype=np.int64)])
            # the last definition of a node is the valid one
            rows = np.searchsorted(numbers, wanted, side="right", sorter=order) - 1
            found = order[rows.clip(min=0)]
            if (numbers[found] != wanted).any():
                missing = wanted[numbers[found] != wanted][0]
                raise MeshError(f"an element has the node {missing}, which *NODE does not define")
            cells[corners] = found
        points = table[:, 1:] + self.translation - self.axis_point
        return CornerMesh(self.rotation.apply(points) + self.axis_point, cells[3], cells[4])


def read_deck(path: Path) -> CornerMesh:
    """Read the nodes and the plane elements of an input deck; of several bodies, the largest.

    Bodies are the instances of parts, at their places in the assembly. A deck without instances has
    its parts instead, and nodes outside of all parts are a body, too.

    Raises
    ------
    MeshError
        if there are no such elements, if an element has a node that is not defined, if a line or an
        included file cannot be read, or if a keyword makes nodes or elements in another way
    """
    bodies = _bodies(path)
    if not (plane := [body for body in bodies if body.in_a_plane]):
        found = sorted(set[str]().union(*(body.others for body in bodies)))
        raise MeshError(
            f"it has no elements in a plane{', only ' + ', '.join(found) if found else ''}: give "
            "axisymmetric or plane ones, CAX3, CAX4, CAX6, CAX8, CPE, CPS"
        )
    return max((body.corners() for body in plane), key=lambda mesh: np.ptp(mesh.points))


def _bodies(path: Path) -> list[_Body]:
    """Return the bodies of a deck."""
    rest, parts, instances = _Body(), dict[str, _Body](), list[_Body]()
    body = rest
    for block in _blocks(path):
        if block.keyword == "PART":
            body = parts[block.options.get("NAME", "").upper()] = _Body()
        elif block.keyword == "INSTANCE":
            body = _instance(block, parts)
            instances.append(body)
        elif block.keyword in ("END PART", "END INSTANCE"):
            body = rest
        elif block.keyword == "NODE":
            if block.options.get("SYSTEM", "R").upper() != "R":
                raise MeshError(
                    f"{block.place}: *NODE gives coordinates that are not rectangular: write the "
                    "nodes in rectangular ones, without SYSTEM"
                )
            body.nodes.append(_nodes(block))
        elif block.keyword == "ELEMENT":
            _add_elements(body, block)
        # *SYSTEM without lines is the rectangular system of the deck
        elif REFUSED.fullmatch(block.keyword) and (block.lines or block.keyword != "SYSTEM"):
            raise MeshError(
                f"{block.place}: *{block.keyword} makes or moves nodes or elements, which is not "
                "done here: write all nodes and elements out, as a preprocessor exports them"
            )
    return [*(instances or parts.values()), rest]


def _instance(block: _Block, parts: dict[str, _Body]) -> _Body:
    """Return an instance of a part with the elements and the nodes of the part."""
    if (part := parts.get(block.options.get("PART", "").upper())) is None:
        raise MeshError(
            f"{block.place}: *INSTANCE is of a part that the deck does not contain above: write "
            "the part into the same deck"
        )
    cells = {corners: list(rows) for corners, rows in part.cells.items()}
    instance = _Body(list(part.nodes), cells, set(part.others))
    moves = [_numbers(line, block.place) for line in block.lines]
    try:
        if moves:
            instance.translation = moves[0].reshape(3)
        if len(moves) > 1:
            start, end = moves[1][:3], moves[1][3:6]
            turn = float(moves[1][6]) / math.dist(start, end) * (end - start)
            instance.axis_point, instance.rotation = start, Rotation.from_rotvec(turn, degrees=True)
    except (ValueError, IndexError, ZeroDivisionError):
        raise MeshError(
            f"{block.place}: give the place of the *INSTANCE as three components of a translation, "
            "and in a second line two points of an axis and an angle in degrees"
        ) from None
    return instance


def _nodes(block: _Block) -> Array:
    """Return number and coordinates (n, 4) of nodes; coordinates that are left out are 0."""
    lines = [line.rstrip(", ") for line in block.lines]
    lengths = {line.count(",") + 1 for line in lines}
    place = f"{block.place}: below *NODE"
    table = np.zeros((len(lines), 4))
    try:
        (count,) = lengths
        numbers = np.fromstring(",".join(lines).translate(FORTRAN), sep=",")
        table[:, : min(count, 4)] = numbers.reshape(len(lines), count)[:, :4]
    except ValueError:
        # lines of several lengths, or with empty places
        for row, line in zip(table, lines, strict=True):
            entries = _numbers(line, place)[:4]
            row[: len(entries)] = entries
    if lengths == {1} or (table[:, 0] != np.rint(table[:, 0])).any():
        raise MeshError(f"{place} a line has no number and coordinates: give them as 1, 0., 0.")
    return table


def _numbers(line: str, place: str) -> Array:
    """Return the numbers of a line; empty places are 0.

    Raises
    ------
    MeshError
        if an entry is not a number
    """
    entries = [entry.strip() for entry in line.rstrip(", ").translate(FORTRAN).split(",")]
    try:
        return np.array([float(entry) if entry else 0.0 for entry in entries])
    except ValueError:
        raise MeshError(f"{place}: {line!r} has an entry that is not a number") from None


def _add_elements(body: _Body, block: _Block) -> None:
    """Add the corners of elements in a plane to a body, or the name of another type."""
    name = block.options.get("TYPE", "").upper()
    found = PLANE_TYPE.fullmatch(name)
    # STRI65 has six nodes
    count = 6 if name == "STRI65" else int(found[1]) if found else 0
    if count not in CORNERS:
        if block.lines:
            body.others.add(name)
        return
    lines = [line.rstrip(", ") for line in block.lines]
    try:
        numbers = np.fromstring(",".join(lines), dtype=np.int64, sep=",")
    except ValueError:
        numbers = np.concatenate(
            [_numbers(line, f"{block.place}: below *ELEMENT") for line in lines]
        )
    if len(numbers) % (count + 1):
        raise MeshError(
            f"{block.place}: elements of type {name} do not have {count} nodes each below *ELEMENT"
        )
    corners = CORNERS[count]
    rows = numbers.astype(np.int64).reshape(-1, count + 1)
    body.cells[corners].append(rows[:, 1 : corners + 1])


def _blocks(path: Path) -> Iterator[_Block]:
    """Yield the keywords of a deck and of the files that it includes."""
    block = None
    for place, text in _lines(path, ()):
        if text.startswith("*"):
            if block:
                yield block
            block = _block(text, place)
        elif block:
            block.lines.append(text)
    if block:
        yield block


def _lines(path: Path, including: Sequence[Path]) -> Iterator[tuple[str, str]]:
    """Yield the lines of keywords and of data, with those of other files in their places.

    Raises
    ------
    MeshError
        if a file cannot be read, or if it includes itself
    """
    if path.resolve() in including:
        raise MeshError(f"{path} includes itself: remove this line *INCLUDE")
    head, place = "", ""
    for number, line in enumerate(_text(path).splitlines(), 1):
        text = line.strip()
        if not text or text.startswith("**"):
            continue
        # the line of a keyword that ends with a comma goes on
        if head := head + text if head or text.startswith("*") else "":
            place = place or f"line {number} of {path.name}"
            if head.endswith(","):
                continue
            block = _block(head, place)
            if block.keyword != "INCLUDE":
                yield place, head
            if file := block.options.get("INPUT"):
                yield from _lines(
                    path.parent / file.replace("\\", "/"), (*including, path.resolve())
                )
            head, place = "", ""
        else:
            yield "", text


def _block(head: str, place: str) -> _Block:
    """Return a keyword without lines from its line, such as ``*NODE, NSET="ALL"``."""
    name, *given = head[1:].split(",")
    pairs = (each.partition("=") for each in given)
    options = {key.strip().upper(): value.strip().strip("\"'") for key, _, value in pairs}
    return _Block(" ".join(name.upper().split()), options, [], place)


def _text(path: Path) -> str:
    """Return the text of a file in UTF-8, or in UTF-16 with a byte order mark."""
    try:
        content = path.read_bytes()
    except OSError as error:
        raise MeshError(f"{path} cannot be read: {error.strerror}") from None
    marked = content.startswith((codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE))
    return content.decode("utf-16" if marked else "utf-8-sig", "replace")
