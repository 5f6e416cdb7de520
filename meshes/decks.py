"""Read the meshes of input decks of Abaqus and CalculiX.

Only the corners of plane and axisymmetric cells are read: the elements of ringwear have their own
nodes between them. A keyword that would give or change nodes or elements in another way is refused
by its name.
"""

import codecs
import io
import re
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from .errors import MeshError
from .radial import Array, Indices

if TYPE_CHECKING:
    from pandas import DataFrame

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
NO_TURN = np.array([0.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0])
"""Two points of an axis, and the angle, of an instance that is only translated."""


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


class DeckBlock(NamedTuple):
    """A keyword of a deck with its options, and the lines below it.

    Parameters
    ----------
    keyword : in upper case, without the asterisk
    options : values by names, which are in upper case
    lines : below the keyword
    place : line and file of the keyword, for messages
    """

    keyword: str
    options: dict[str, str]
    lines: list[str]
    place: str

    def numbers(self) -> "DataFrame":
        """Return the numbers in each line; NaN in places that are empty or left out.

        Raises
        ------
        MeshError
            if an entry is not a number
        """
        import pandas as pd

        width = max((line.count(",") for line in self.lines), default=0) + 1
        try:
            return pd.read_csv(
                io.StringIO("\n".join(self.lines).translate(FORTRAN)),
                names=range(width),
                dtype=float,
                keep_default_na=False,
                na_values=[""],
                skipinitialspace=True,
            )
        except ValueError as error:
            raise MeshError(
                f"{self.place}: below *{self.keyword}: an entry is not a number: {error}"
            ) from None

    def nodes(self) -> "DataFrame":
        """Return number and coordinates of nodes; coordinates that are left out are 0."""
        table = self.numbers().reindex(columns=range(4))
        if table[1].isna().all() or (table[0] % 1 != 0).any():
            raise MeshError(
                f"{self.place}: below *NODE a line has no number and coordinates: give them as 1, "
                "0., 0."
            )
        return table.fillna(0.0)

    @property
    def node_count(self) -> int:
        """The number of nodes of each element; 0 if the elements are not in a plane."""
        name = self.options.get("TYPE", "").upper()
        found = PLANE_TYPE.fullmatch(name)
        # STRI65 has six nodes
        count = 6 if name == "STRI65" else int(found[1]) if found else 0
        return count if count in CORNERS else 0

    def corners(self) -> Array:
        """Return the numbers of the corners of each element in a plane."""
        numbers, count = self.numbers().to_numpy(), self.node_count
        numbers = numbers[~np.isnan(numbers)]
        if len(numbers) % (count + 1):
            raise MeshError(
                f"{self.place}: elements of type {self.options['TYPE'].upper()} do not have "
                f"{count} nodes each below *ELEMENT"
            )
        return numbers.reshape(-1, count + 1)[:, 1 : CORNERS[count] + 1]


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
    meshes = [mesh for mesh in map(_mesh_of, bodies) if mesh.size]
    if not meshes:
        elements = (block for body in bodies for block in body if block.keyword == "ELEMENT")
        found = sorted({each.options.get("TYPE", "").upper() for each in elements if each.lines})
        raise MeshError(
            f"it has no elements in a plane{', only ' + ', '.join(found) if found else ''}: give "
            "axisymmetric or plane ones, CAX3, CAX4, CAX6, CAX8, CPE, CPS"
        )
    return max(meshes, key=lambda mesh: np.ptp(mesh.points))


def _bodies(path: Path) -> list[list[DeckBlock]]:
    """Return the keywords of each body of a deck; that of an instance has its place."""
    parts, instances = dict[str, list[DeckBlock]](), list[list[DeckBlock]]()
    rest = body = list[DeckBlock]()
    for block in deck_blocks(path):
        if block.keyword == "PART":
            body = parts[block.options.get("NAME", "").upper()] = []
        elif block.keyword == "INSTANCE":
            name = block.options.get("PART", "").upper()
            if name not in parts:
                raise MeshError(
                    f"{block.place}: *INSTANCE is of a part that the deck does not contain above: "
                    "write the part into the same deck"
                )
            body = [*parts[name], block]
            instances.append(body)
        elif block.keyword in ("END PART", "END INSTANCE"):
            body = rest
        elif block.keyword == "NODE" and block.options.get("SYSTEM", "R").upper() != "R":
            raise MeshError(
                f"{block.place}: *NODE gives coordinates that are not rectangular: write the nodes "
                "in rectangular ones, without SYSTEM"
            )
        # *SYSTEM without lines is the rectangular system of the deck
        elif REFUSED.fullmatch(block.keyword) and (block.lines or block.keyword != "SYSTEM"):
            raise MeshError(
                f"{block.place}: *{block.keyword} makes or moves nodes or elements, which is not "
                "done here: write all nodes and elements out, as a preprocessor exports them"
            )
        else:
            body.append(block)
    return [*(instances or parts.values()), rest]


def _mesh_of(body: list[DeckBlock]) -> CornerMesh:
    """Return the mesh of a body.

    Raises
    ------
    MeshError
        if an element has a node that is not defined
    """
    import pandas as pd

    none = pd.DataFrame(columns=range(4), dtype=float)
    nodes = pd.concat([none, *(block.nodes() for block in body if block.keyword == "NODE")])
    # the last definition of a node is the valid one
    nodes = nodes.drop_duplicates(0, keep="last")
    elements = [block for block in body if block.keyword == "ELEMENT" and block.node_count]
    if elements and nodes.empty:
        raise MeshError("it has elements, but *NODE defines no nodes: include their file")
    cells = []
    for corners in (3, 4):
        blocks = [each.corners() for each in elements if CORNERS[each.node_count] == corners]
        wanted = np.concatenate([np.empty((0, corners)), *blocks])
        found = pd.Index(nodes[0]).get_indexer(wanted.ravel())
        if (found < 0).any():
            missing = wanted.ravel()[found < 0][0]
            raise MeshError(f"an element has the node {missing:g}, which *NODE does not define")
        cells.append(found.reshape(-1, corners))
    points = nodes.to_numpy()[:, 1:]
    for block in body:
        if block.keyword == "INSTANCE" and block.lines:
            points = _moved(points, block)
    return CornerMesh(points, *cells)


def _moved(points: Array, instance: DeckBlock) -> Array:
    """Return the points (n, 3) of an instance, translated and then rotated about an axis."""
    from scipy.spatial.transform import Rotation

    numbers = instance.numbers().reindex(columns=range(7)).to_numpy()
    move, turn = [*numbers, NO_TURN][:2]
    translation, start, axis = move[:3], turn[:3], turn[3:6] - turn[:3]
    if np.isnan([*translation, *turn]).any() or not axis.any():
        raise MeshError(
            f"{instance.place}: give the place of the *INSTANCE as three components of a "
            "translation, and in a second line two points of an axis and an angle in degrees"
        )
    rotation = Rotation.from_rotvec(turn[6] * axis / np.linalg.norm(axis), degrees=True)
    return start + rotation.apply(points + translation - start)


def deck_blocks(path: Path) -> Iterator[DeckBlock]:
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


def _block(head: str, place: str) -> DeckBlock:
    """Return a keyword without lines from its line, such as ``*NODE, NSET="ALL"``."""
    name, *given = head[1:].split(",")
    pairs = (each.partition("=") for each in given)
    options = {key.strip().upper(): value.strip().strip("\"'") for key, _, value in pairs}
    return DeckBlock(" ".join(name.upper().split()), options, [], place)


def _text(path: Path) -> str:
    """Return the text of a file in UTF-8, or in UTF-16 with a byte order mark."""
    try:
        content = path.read_bytes()
    except OSError as error:
        raise MeshError(f"{path} cannot be read: {error.strerror}") from None
    marked = content.startswith((codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE))
    return content.decode("utf-16" if marked else "utf-8-sig", "replace")
