"""Read the results of decks: the .dat file of CalculiX, and field reports (.rpt) of Abaqus.

Both refer to nodes by their numbers. The deck in the same folder contains the positions of the
nodes; its comments contain the times, the rings and the scale.
"""

import re
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import numpy as np
import pandas as pd

from ...meshes import Array, SceneError, ring_of
from ..crosscheck import Scene
from ..tables.numbers import EXPONENT
from ..wear_step.contact_nodes import contact_mass

WEDGE = 180.0
"""The whole circumference over the wedge of 2 degrees by which CalculiX models axial symmetry."""
NEAR_RIM = 0.05
"""Part of the face, at the rim and at a hole, in which pressures at the start are ignored: they are
infinite at the edge, and those of polynomial elements oscillate there."""
DAT_TITLE = re.compile(
    r"(?P<quantity>displacements|forces) .*for set (?P<set>\w+) and time\s+(?P<time>\S+)"
)
RPT_STEP = re.compile(r"Step: *STEP-(?P<step>\d+)", re.IGNORECASE)


@dataclass(frozen=True, eq=False)
class Deck:
    """The nodes and steps of a deck by `ringwear deck`.

    Parameters
    ----------
    path : of the deck
    radii : radius of each node, by node number
    sets : node numbers of each node set, by its name
    quadratic : whether elements have nodes in the middles of their sides
    notes : numbers in the comments, by the name of the comment
    """

    path: Path
    radii: dict[int, float]
    sets: dict[str, list[int]]
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
        try:
            lines = path.read_text("utf-8", "replace").splitlines()
        except OSError:
            raise SceneError(
                f"{results} refers to nodes by their numbers: put the deck {path.name}, which has "
                "their positions, into the same folder"
            ) from None
        radii, sets, node_counts = dict[int, float](), dict[str, list[int]](), set[str]()
        notes = dict[str, list[float]]()
        keyword, name = "", ""
        for line in lines:
            if line.startswith("**"):
                note, _, values = line[2:].strip().partition(":")
                if note in NOTES:
                    notes.setdefault(note, []).extend(map(float, values.split(",")))
            elif line.startswith("*"):
                keyword = line.partition(",")[0].upper()
                set_name = re.search(r"NSET=(\w+)", line)
                name = set_name[1].upper() if set_name else ""
                node_counts.update(re.findall(r"TYPE=CAX(\d)", line))
            elif keyword == "*NODE":
                number, radius, *_ = line.split(",")
                radii[int(number)] = float(radius)
            elif keyword == "*NSET":
                members = (int(number) for number in line.split(",") if number.strip())
                sets.setdefault(name, []).extend(members)
        if NOTES - notes.keys() or "CONTACT" not in sets:
            raise SceneError(
                f"{path} was not written by `ringwear deck`: give results as a table of time, "
                "radius and pressure"
            )
        arrays = {note: np.array(values) for note, values in notes.items()}
        return cls(path, radii, sets, "8" in node_counts, arrays)

    @property
    def times(self) -> Array:
        """The time of each step."""
        return self.notes["times"]

    @property
    def scale(self) -> float:
        """Factor that turns displacements of the deck into those of the scene."""
        return float(self.notes["displacements times"][0])

    @property
    def lowest(self) -> float:
        """Height that is added to the displacement of the punch to obtain the indentation."""
        return float(self.notes["lowest height"][0])

    @cached_property
    def contact_radii(self) -> Array:
        """(k,) radii of the contact nodes."""
        return np.array([self.radii[node] for node in self.sets["CONTACT"]])

    def pressures(self, time: float, forces: Array) -> Array:
        """Return pressures (k,) at a time from the nodal forces (k,) on the whole circumference.

        They are NaN at ring edges where wear coefficients jump, and at the start near the rim.
        """
        edges = self.notes["ring edges"]
        inner, outer = self.notes["wear at inner edges"], self.notes["wear at outer edges"]

        def wear(radii: Array) -> Array:
            if time == 0:
                return np.ones_like(radii)
            ring = ring_of(edges, radii)
            fraction = (radii - edges[ring]) / np.diff(edges)[ring]
            values = inner[ring] + fraction * (outer[ring] - inner[ring])
            jumps = edges[1:-1][inner[1:] != outer[:-1]]
            away_from_jumps = np.abs(radii[:, None] - jumps) > 1e-9 * edges[-1]
            return np.where(away_from_jumps.all(axis=1), values, np.nan)

        pressures = pressures_of(self.contact_radii, forces, self.quadratic, wear)
        return np.where(self._near_singularity if time == 0 else False, np.nan, pressures)

    @property
    def _near_singularity(self) -> Array:
        """(k,) whether a node is near the rim or a hole, where first pressures are infinite."""
        inner, rim = self.notes["ring edges"][[0, -1]]
        margin, radii = NEAR_RIM * (rim - inner), self.contact_radii
        return (radii > rim - margin) | ((radii < inner + margin) & (inner > 0))

    def rows(self, time: float, results: dict[str, Array]) -> pd.DataFrame:
        """Return a table of results (k,) at the contact nodes at a time."""
        return pd.DataFrame({"time": time, "radius": self.contact_radii} | results)


NOTES = {
    "times",
    "ring edges",
    "wear at inner edges",
    "wear at outer edges",
    "displacements times",
    "lowest height",
}
"""Names of the comments that a deck must have."""


def read_dat(path: Path) -> pd.DataFrame:
    """Return the results of CalculiX: pressures from reaction forces, the force, displacements.

    Raises
    ------
    SceneError
        if the deck is not in the same folder, or if a step or its forces are missing
    """
    deck, tables = Deck.of_results(path), []
    blocks = {(quantity, name, time): values for quantity, name, time, values in _blocks(path)}
    for step, time in enumerate(deck.times):
        end = max((time for *_, time in blocks if time <= step + 1 + 1e-6), default=0.0)
        if abs(end - step - 1) > 1e-6:
            raise SceneError(
                f"{path}: step {step + 1} of {len(deck.times)} is missing or not finished: run the "
                "program to its end"
            )
        step_blocks = {
            (quantity, name): values
            for (quantity, name, block_time), values in blocks.items()
            if block_time == end
        }
        forces = step_blocks.get(("forces", "FACE"), step_blocks.get(("forces", "CONTACT")))
        if forces is None or len(forces) != len(deck.contact_radii):
            raise SceneError(
                f"{path} does not have the forces on all contact nodes: keep *NODE PRINT and RF of "
                "the deck as they are"
            )
        if not np.isfinite(forces).all():
            raise SceneError(
                f"{path}: a force of step {step + 1} is not a number: run the program again"
            )
        pressing_forces = -WEDGE * forces
        results = {
            "pressure": deck.pressures(float(time), pressing_forces),
            "normal_force": np.full(len(forces), pressing_forces.sum()),
        }
        if ("forces", "FACE") in step_blocks:
            results["displacement"] = -deck.scale * step_blocks["displacements", "CONTACT"]
            if ("displacements", "REF") in step_blocks:
                depth = deck.lowest - deck.scale * step_blocks["displacements", "REF"][0]
                results["indentation"] = np.full(len(forces), depth)
        tables.append(deck.rows(float(time), results))
    return pd.concat(tables, ignore_index=True)


def _blocks(path: Path) -> Iterator[tuple[str, str, float, Array]]:
    """Yield the vertical components in each block of nodes: quantity, node set, time, values."""
    block: tuple[str, str, float] | None = None
    values = list[float]()
    with path.open(encoding="utf-8", errors="replace") as lines:
        for line in lines:
            words = line.split()
            if len(words) == 4 and words[0].isdigit():
                values.append(fortran_number(words[2]))
                continue
            if words:
                if block and values:
                    yield *block, np.array(values)
                block, values = None, []
                if title := DAT_TITLE.search(line):
                    block = title["quantity"], title["set"], fortran_number(title["time"])
    if block and values:
        yield *block, np.array(values)


def fortran_number(text: str) -> float:
    """Return the number in a text, whose exponent may be written as in Fortran.

    Raises
    ------
    ValueError
        if the text is no number
    """
    return float(EXPONENT.sub("e", text, count=1))


def read_rpt(path: Path) -> pd.DataFrame:
    """Return the results in a report of nodal fields by Abaqus: CPRESS, RF.RF2 and U.U2.

    Raises
    ------
    SceneError
        if the deck is not in the same folder, or if the report lacks these columns or nodes
    """
    deck, tables = Deck.of_results(path), []
    nodes = deck.sets["CONTACT"]
    for step, table in _step_tables(path, len(deck.times)):
        time = float(deck.times[min(step, len(deck.times)) - 1])
        values = table.reindex(nodes)
        results = dict[str, Array]()
        if "CPRESS" in values:
            results["pressure"] = values["CPRESS"].to_numpy()
        elif "RF.RF2" in values and values["RF.RF2"].notna().all():
            pressing_forces = -values["RF.RF2"].to_numpy()
            results["pressure"] = deck.pressures(time, pressing_forces)
            results["normal_force"] = np.full(len(pressing_forces), pressing_forces.sum())
        if "U.U2" in values and "RF.RF2" not in values:
            results["displacement"] = -deck.scale * values["U.U2"].to_numpy()
        if not any(np.isfinite(result).any() for result in results.values()):
            raise SceneError(
                f"{path}: step {step} has neither CPRESS nor RF.RF2 of every node of the set "
                "CONTACT: report one of them at unique nodal positions"
            )
        tables.append(deck.rows(time, results))
    return pd.concat(tables, ignore_index=True)


def _step_tables(path: Path, steps: int) -> Iterator[tuple[int, pd.DataFrame]]:
    """Yield the number of each step, and its table by node number.

    If the deck has one time, as contact decks have, only the last step is read, as number 1.

    Raises
    ------
    SceneError
        if there is no table of nodes
    """
    rows_by_step, step, headings = dict[int, dict[int, dict[str, float]]](), 1, list[str]()
    with path.open(encoding="utf-8", errors="replace") as lines:
        for line in lines:
            words = line.split()
            if step_line := RPT_STEP.search(line):
                step = int(step_line["step"])
            elif words[:1] == ["Node"] and len(words) > 1:
                headings = words[1:]
            elif headings and len(words) == len(headings) + 1 and words[0].isdigit():
                row = dict(zip(headings, map(fortran_number, words[1:]), strict=True))
                rows_by_step.setdefault(step, {}).setdefault(int(words[0]), {}).update(row)
    if not rows_by_step:
        raise SceneError(
            f"{path} has no table of nodes: in Abaqus/Viewer report a field at unique nodal "
            "positions, sorted by node label"
        )
    if steps == 1:
        rows_by_step = {1: rows_by_step[max(rows_by_step)]}
    for number, rows in sorted(rows_by_step.items()):
        yield number, pd.DataFrame.from_dict(rows, orient="index")


def differing_keys(results: Path, scene: Scene) -> list[str]:
    """Return the keys in which the scene beside the results of a deck differs from a scene.

    `ringwear deck` writes the scene that it models as `scene.toml`. Only keys that change what is
    modelled are compared. The list is empty if there is no such file, or if it is no scene.
    """
    path = results.parent / "scene.toml"
    if not path.is_file():
        return []
    try:
        modelled = Scene.load(path)
    except SceneError:
        return []
    ours, theirs = _modelled_values(scene.table()), _modelled_values(modelled.table())
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
    return max(Deck.of_results(path).radii.values()) / scene.punch.radius


def _modelled_values(table: Mapping[str, object], prefix: str = "") -> dict[str, object]:
    """Return the values of the keys with dots of a scene that change what is modelled."""
    values = dict[str, object]()
    for key, value in table.items():
        if not prefix and key not in MODELLED_TABLES:
            continue
        name = f"{prefix}{key}"
        if isinstance(value, Mapping):
            values |= _modelled_values(value, f"{name}.")
        elif isinstance(value, list) and value and isinstance(value[0], Mapping):
            for number, item in enumerate(value):
                values |= _modelled_values(item, f"{name}.{number}.")
        else:
            values[name] = value
    return values


def is_table(path: Path) -> bool:
    """Return whether a file has columns of numbers, as of an XY plot, and no results on nodes."""
    text = path.read_text("utf-8", "replace")
    if path.suffix.lower() == ".rpt":
        return "node" not in text.lower()
    return not (path.with_suffix(".inp").is_file() or DAT_TITLE.search(text))


READERS = {".dat": read_dat, ".rpt": read_rpt}
"""Readers of result files, by the ending of the file."""
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
