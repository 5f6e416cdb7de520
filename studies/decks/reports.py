"""Read the results of decks: the .dat file of CalculiX, and field reports (.rpt) of Abaqus.

Both refer to nodes by their numbers. The deck in the same folder contains the positions of the
nodes; its comments contain the times, the rings and the scale.
"""

import re
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from itertools import groupby
from pathlib import Path

import numpy as np
import pandas as pd

from ...meshes import Array, MeshError, SceneError, deck_blocks
from ..crosscheck import LOG, Scene
from ..tables.frame import Frame
from ..tables.numbers import fortran_number
from ..wear_step.contact_nodes import contact_mass

WEDGE = 180.0
"""The whole circumference over the wedge of 2 degrees by which CalculiX models axial symmetry."""
NEAR_RIM = 0.05
"""Part of the face, at the rim and at a hole, in which pressures at the start are ignored: they are
infinite at the edge, and those of polynomial elements oscillate there."""
DAT_TITLE = re.compile(
    r"(?P<name>displacements|forces) .*for set (?P<set>\w+) and time\s+"
    r"(?P<time>[\d.]+([DE][-+]?\d+)?)\s*$",
    re.IGNORECASE | re.MULTILINE,
)
RPT_STEP = re.compile(r"Step: STEP-(\d+)", re.IGNORECASE)
RPT_HEADINGS = re.compile(r"^Node (.+)$", re.MULTILINE)
NOTES = {
    "times",
    "ring edges",
    "wear at inner edges",
    "wear at outer edges",
    "displacements times",
    "lowest height",
}
"""Names of the comments that a deck must have."""
NOTE = re.compile(rf"^\*\* ({'|'.join(NOTES)}): (.+)$", re.MULTILINE)
NO_RESULTS = {
    ".toml": "is a scene, not results: give the scene first, and then a file of results, such as "
    "CSV, or the .dat of CalculiX",
    ".inp": "is an input file, not results: run it, and give the .dat of CalculiX or the .rpt of "
    "Abaqus, of the same name",
    ".frd": "has fields for figures: give the .dat of the same name, to which CalculiX writes the "
    "forces on nodes",
    ".odb": "is a binary file of Abaqus: give a field report of it in a file of the same name that "
    "ends in .rpt",
}
"""What files are that have no results that can be read, and which to give instead, by ending."""
MODELLED_TABLES = ("units", "punch", "half_space", "load")
"""Tables and keys of a scene that change what a deck models."""


@dataclass(frozen=True, eq=False)
class Deck:
    """The nodes and steps of a deck by `ringwear deck`.

    Parameters
    ----------
    contact : numbers (k,) of the contact nodes
    contact_radii : their radii (k,)
    reach : greatest radius of a node
    quadratic : whether elements have nodes in the middles of their sides
    notes : numbers in the comments, by the name of the comment
    """

    contact: Array
    contact_radii: Array
    reach: float
    quadratic: bool
    notes: dict[str, Array]

    @classmethod
    def of_results(cls, results: Path) -> "Deck":
        """Return the deck of a file of results: the file of the same name that ends in .inp.

        Raises
        ------
        SceneError
            if it does not exist, or was not written by `ringwear deck`
        """
        path = results.with_suffix(".inp")
        if not path.is_file():
            raise SceneError(
                f"{results} refers to nodes by their numbers: put the deck {path.name}, which has "
                "their positions, into the same folder"
            )
        notes = dict[str, Array]()
        try:
            blocks = [*deck_blocks(path)]
            nodes = [block.nodes() for block in blocks if block.keyword == "NODE"]
            sets = [block for block in blocks if block.keyword == "NSET"]
            contact = [each.numbers() for each in sets if each.options.get("NSET") == "CONTACT"]
            for name, values in NOTE.findall(path.read_text("utf-8", "replace")):
                notes[name] = np.append(notes.get(name, []), [*map(float, values.split(","))])
            radii = pd.concat(nodes).set_index(0)[1]
            members = pd.concat(contact).stack().to_numpy()
            contact_radii = radii.loc[members].to_numpy()
        except (MeshError, ValueError, KeyError):
            contact_radii = np.empty(0)
        in_order = len(contact_radii) > 1 and (np.diff(contact_radii) > 0).all()
        if NOTES - notes.keys() or not in_order:
            raise SceneError(
                f"{path} was not written by `ringwear deck`, or was changed: give results as a "
                "table of time, radius and pressure"
            )
        quadratic = any(block.node_count == 8 for block in blocks)
        return cls(members, contact_radii, radii.max(), quadratic, notes)

    @property
    def times(self) -> Array:
        """The time of each step."""
        return self.notes["times"]

    @property
    def scale(self) -> float:
        """Factor that turns displacements of the deck into those of the scene."""
        return float(self.notes["displacements times"][0])

    def pressures(self, time: float, forces: Array) -> Array:
        """Return pressures (k,) at a time from the nodal forces (k,) on the whole circumference.

        They are NaN at ring edges where wear coefficients jump, and at the start near the rim.
        """
        edges, radii = self.notes["ring edges"], self.contact_radii
        inner, outer = self.notes["wear at inner edges"], self.notes["wear at outer edges"]
        jumps = edges[1:-1][inner[1:] != outer[:-1]]

        def wear(radii: Array) -> Array:
            if time == 0:
                return np.ones_like(radii)
            # both ends of each ring
            ends, wear_at_ends = np.repeat(edges, 2)[1:-1], np.column_stack([inner, outer])
            at_jumps = np.abs(radii[..., None] - jumps) <= 1e-9 * edges[-1]
            values = np.interp(radii, ends, wear_at_ends.ravel())
            return np.where(at_jumps.any(axis=-1), np.nan, values)

        pressures = pressures_of(radii, forces, self.quadratic, wear)
        margin = NEAR_RIM * (edges[-1] - edges[0])
        # first pressures are infinite at the rim and at a hole
        near = (radii > edges[-1] - margin) | ((radii < edges[0] + margin) & (edges[0] > 0))
        return np.where(near & (time == 0), np.nan, pressures)

    def rows(self, time: float, results: dict[str, Array]) -> pd.DataFrame:
        """Return a table of results (k,) at the contact nodes at a time."""
        return pd.DataFrame({"time": time, "radius": self.contact_radii} | results)


def results_of_deck(path: Path, scene: Scene) -> pd.DataFrame | None:
    """Return the results of a deck, or None if a file has none, but perhaps a table.

    A scene that differs from that of the deck is reported.

    Raises
    ------
    SceneError
        if another file of the same program has the results; it names that
    """
    ending = path.suffix.lower()
    if ending in NO_RESULTS:
        raise SceneError(f"{path} {NO_RESULTS[ending]}")
    if ending not in READERS or not path.is_file():
        return None
    text = path.read_text("utf-8", "replace")
    # columns of numbers, as of an XY plot
    if ending == ".rpt" and "node" not in text.lower():
        return None
    if ending == ".dat" and not (path.with_suffix(".inp").is_file() or DAT_TITLE.search(text)):
        return None
    results = READERS[ending](path)
    if keys := differing_keys(path, scene):
        LOG.warning(
            "%s has the results of another scene: %s differs in %s",
            path,
            path.parent / "scene.toml",
            ", ".join(keys),
        )
    return results


def read_dat(path: Path) -> pd.DataFrame:
    """Return the results of CalculiX: pressures from reaction forces, the force, displacements.

    Raises
    ------
    SceneError
        if the deck is not in the same folder, or if a step or its forces are missing
    """
    deck, rows, steps = Deck.of_results(path), [], dict[int, dict[str, Array]]()
    for above, table in _tables_of_nodes(path):
        title = DAT_TITLE.search(above)
        if title and table.shape[1] == 3:
            time = fortran_number(title["time"])
            # steps end at whole times
            if abs(time - round(time)) < 1e-6:
                values = steps.setdefault(round(time), {})
                values[f"{title['name']} {title['set']}"] = table["2"].to_numpy()
    for step, time in enumerate(deck.times, 1):
        if step not in steps:
            raise SceneError(
                f"{path}: step {step} of {len(deck.times)} is missing or not finished: run the "
                "program to its end"
            )
        values, count = steps[step], len(deck.contact)
        forces = -WEDGE * values.get("forces FACE", values.get("forces CONTACT", np.empty(0)))
        moved = -deck.scale * values.get("displacements CONTACT", np.empty(0))
        if len(forces) != count or ("forces FACE" in values and len(moved) != count):
            raise SceneError(
                f"{path} does not have the forces on all contact nodes: keep *NODE PRINT and RF of "
                "the deck as they are"
            )
        if not np.isfinite(forces).all():
            raise SceneError(
                f"{path}: a force of step {step} is not a number: run the program again"
            )
        results = {
            "pressure": deck.pressures(float(time), forces),
            "normal_force": np.full(count, forces.sum()),
        }
        if "forces FACE" in values:
            results["displacement"] = moved
            if "displacements REF" in values:
                depth = deck.scale * values["displacements REF"][0]
                # displacements are those from the lowest point
                results["indentation"] = np.full(count, deck.notes["lowest height"][0] - depth)
        rows.append(deck.rows(float(time), results))
    return pd.concat(rows, ignore_index=True)


def read_rpt(path: Path) -> pd.DataFrame:
    """Return the results in a report of nodal fields by Abaqus: CPRESS, RF.RF2 and U.U2.

    If the deck has one time, as contact decks have, only the last step is read.

    Raises
    ------
    SceneError
        if the deck is not in the same folder, or if the report lacks these columns or nodes
    """
    deck, rows, steps = Deck.of_results(path), [], dict[int, pd.DataFrame]()
    step, headings = 1, ""
    for above, table in _tables_of_nodes(path):
        step = int([step, *RPT_STEP.findall(above)][-1])
        headings = [headings, *RPT_HEADINGS.findall(above)][-1]
        if len(headings.split()) == table.shape[1]:
            table = table.set_axis(headings.split(), axis=1).groupby(level=0).last()
            steps[step] = table.combine_first(steps.get(step, table))
    if not steps:
        raise SceneError(
            f"{path} has no table of nodes: in Abaqus/Viewer report a field at unique nodal "
            "positions, sorted by node label"
        )
    if len(deck.times) == 1:
        steps = {1: steps[max(steps)]}
    for step, table in sorted(steps.items()):
        time = float(deck.times[min(step, len(deck.times)) - 1])
        values, results = table.reindex(deck.contact), dict[str, Array]()
        if "CPRESS" in values:
            results["pressure"] = values["CPRESS"].to_numpy()
        elif "RF.RF2" in values and values["RF.RF2"].notna().all():
            forces = -values["RF.RF2"].to_numpy()
            results["pressure"] = deck.pressures(time, forces)
            results["normal_force"] = np.full(len(forces), forces.sum())
        if "U.U2" in values and "RF.RF2" not in values:
            results["displacement"] = -deck.scale * values["U.U2"].to_numpy()
        if not any(np.isfinite(result).any() for result in results.values()):
            raise SceneError(
                f"{path}: step {step} has neither CPRESS nor RF.RF2 of every node of the set "
                "CONTACT: report one of them at unique nodal positions"
            )
        rows.append(deck.rows(time, results))
    return pd.concat(rows, ignore_index=True)


def _tables_of_nodes(path: Path) -> Iterator[tuple[str, pd.DataFrame]]:
    """Yield the text above each table of nodes, and its rows by the numbers of nodes.

    Raises
    ------
    SceneError
        if a cell is no number; it names the line
    """
    lines = enumerate(path.read_text("utf-8", "replace").splitlines(), 1)
    words = ((number, line.split()) for number, line in lines if line.strip())
    above = ""
    for count, group in groupby(words, lambda pair: len(pair[1]) * pair[1][0].isdigit()):
        rows = dict(group)
        if count > 1:
            cells = pd.DataFrame([*rows.values()], [*rows])
            frame = Frame.of(str(path), cells, [*map(str, cells)], place="line")
            frame.refuse_faults({heading: heading for heading in frame.cells})
            yield above, frame.values.set_index("0")
        above = "\n".join(map(" ".join, rows.values()))


def differing_keys(results: Path, scene: Scene) -> list[str]:
    """Return the keys in which the scene beside the results of a deck differs from a scene.

    `ringwear deck` writes the scene that it models as `scene.toml`. Only keys that change what is
    modelled are compared. The list is empty if there is no such file, or if it is no scene.
    """
    path = results.parent / "scene.toml"
    try:
        modelled = Scene.load(path).table() if path.is_file() else scene.table()
    except SceneError:
        return []
    ours, theirs = (
        pd.json_normalize({key: table.get(key) for key in MODELLED_TABLES}).iloc[0].to_dict()
        for table in (scene.table(), modelled)
    )
    return sorted(key for key in ours | theirs if ours.get(key) != theirs.get(key))


def reach_of_deck(results: object, scene: Scene) -> float | None:
    """Return the radius of the half-space of a deck, in punch radii, if it models this scene.

    It is None for results that are not of a deck, or whose folder has no `scene.toml` with the same
    model.
    """
    if not isinstance(results, str | Path):
        return None
    path = Path(results)
    is_deck = path.suffix.lower() in READERS and (path.parent / "scene.toml").is_file()
    if not is_deck or differing_keys(path, scene):
        return None
    return Deck.of_results(path).reach / scene.punch.radius


READERS = {".dat": read_dat, ".rpt": read_rpt}
"""Readers of result files, by the ending of the file."""


def pressures_of(
    radii: Array, forces: Array, quadratic: bool, wear: Callable[[Array], Array]
) -> Array:
    """Return pressures (k,) at the nodes, from the consistent mass matrix of the contact line.

    The force on a node is ``int N p 2 pi r dr`` with its shape function N. After the start, ``wear
    * p`` is continuous across ring edges, because the face is; it is expanded in the shape
    functions of the elements.

    Parameters
    ----------
    radii : (k,) of the nodes from inside to outside, including those in the middles of sides
    forces : (k,) on the nodes, for the whole circumference
    quadratic : whether elements have nodes in the middles of their sides
    wear : function from radii to wear coefficients; where it is NaN, such as at ring edges where
        the coefficients jump, pressures are NaN
    """
    matrix = contact_mass(radii, 2 if quadratic else 1, lambda points: 1 / wear(points))
    return np.linalg.solve(matrix, forces) / wear(radii)
