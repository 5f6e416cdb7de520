"""Results of decks: CalculiX's .dat, and Abaqus's report of a field (.rpt).

Both name nodes by their numbers. The deck beside them says where the nodes are, and its comments
say the times, the rings and the scale.
"""

import re
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import numpy as np
import pandas as pd

from ...meshes.errors import SceneError
from ...meshes.radial import Array
from .pressures import pressures_of

WEDGE = 180.0
"""The circumference over the wedge of 2 degrees that CalculiX makes of an axisymmetric model."""
NEAR_RIM = 0.05
"""Part of the face beside the rim in which pressures of the start, infinite at the rim, are left
out: polynomials swing about them."""
DAT_TITLE = re.compile(
    r"(?P<what>displacements|forces) .*for set (?P<set>\w+) and time\s+(?P<time>\S+)"
)
RPT_STEP = re.compile(r"Step: *STEP-(?P<step>\d+)", re.IGNORECASE)


@dataclass(frozen=True, eq=False)
class Deck:
    """What a deck of `ringwear deck` says of its nodes and steps.

    Parameters
    ----------
    path : of the deck
    radii : radius of each node by its number
    sets : numbers of nodes by the names of sets
    quadratic : whether its elements have nodes in the middles of their sides
    notes : numbers in its comments, by their names
    """

    path: Path
    radii: dict[int, float]
    sets: dict[str, list[int]]
    quadratic: bool
    notes: dict[str, Array]

    @classmethod
    def beside(cls, results: Path) -> "Deck":
        """Read the deck of some results: the file of the same name that ends in .inp.

        Raises
        ------
        SceneError
            if it is not there, or not by `ringwear deck`
        """
        path = results.with_suffix(".inp")
        try:
            lines = path.read_text("utf-8", "replace").splitlines()
        except OSError:
            raise SceneError(
                f"{results} names nodes by their numbers: put the deck {path.name}, which says "
                "where they are, beside it"
            ) from None
        radii, sets, kinds = dict[int, float](), dict[str, list[int]](), set[str]()
        notes = dict[str, list[float]]()
        keyword, name = "", ""
        for line in lines:
            if line.startswith("**"):
                note, _, values = line[2:].strip().partition(":")
                if note in NOTES:
                    notes.setdefault(note, []).extend(map(float, values.split(",")))
            elif line.startswith("*"):
                keyword = line.partition(",")[0].upper()
                named = re.search(r"NSET=(\w+)", line)
                name = named[1].upper() if named else ""
                kinds.update(re.findall(r"TYPE=CAX(\d)", line))
            elif keyword == "*NODE":
                number, radius, *_ = line.split(",")
                radii[int(number)] = float(radius)
            elif keyword == "*NSET":
                sets.setdefault(name, []).extend(int(of) for of in line.split(",") if of.strip())
        if NOTES - notes.keys() or "CONTACT" not in sets:
            raise SceneError(
                f"{path} is no deck by `ringwear deck`: give results as a table of time, radius "
                "and pressure"
            )
        told = {note: np.array(values) for note, values in notes.items()}
        return cls(path, radii, sets, "8" in kinds, told)

    @property
    def times(self) -> Array:
        """The time of each step."""
        return self.notes["times"]

    @property
    def scale(self) -> float:
        """By which displacements are to be multiplied."""
        return float(self.notes["displacements times"][0])

    @property
    def lowest(self) -> float:
        """What is to be added to the displacement of the punch for the indentation."""
        return float(self.notes["lowest height"][0])

    @cached_property
    def contact_radii(self) -> Array:
        """(k,) radii of the contact nodes."""
        return np.array([self.radii[node] for node in self.sets["CONTACT"]])

    def pressures(self, time: float, forces: Array) -> Array:
        """Return pressures (k,) by the forces (k,) on the circumference at a time."""
        edges = self.notes["ring edges"]
        inner, outer = self.notes["wear at inner edges"], self.notes["wear at outer edges"]

        def wear(radii: Array) -> Array:
            if time == 0:
                return np.ones_like(radii)
            ring = np.clip(np.searchsorted(edges, radii, "right") - 1, 0, len(inner) - 1)
            share = (radii - edges[ring]) / (edges[ring + 1] - edges[ring])
            values = inner[ring] + share * (outer[ring] - inner[ring])
            jumps = edges[1:-1][inner[1:] != outer[:-1]]
            apart = np.abs(radii[:, None] - jumps) > 1e-9 * edges[-1]
            return np.where(apart.all(axis=1), values, np.nan)

        found = pressures_of(self.contact_radii, forces, self.quadratic, wear)
        return np.where(self._near_infinite if time == 0 else False, np.nan, found)

    @property
    def _near_infinite(self) -> Array:
        """(k,) whether a node is beside the rim or a hole, where first pressures are infinite."""
        inner, rim = self.notes["ring edges"][[0, -1]]
        margin, radii = NEAR_RIM * (rim - inner), self.contact_radii
        return (radii > rim - margin) | ((radii < inner + margin) & (inner > 0))

    def rows(self, time: float, found: dict[str, Array]) -> pd.DataFrame:
        """Return a table of what was found at a time, of fields by the contact nodes."""
        return pd.DataFrame({"time": time, "radius": self.contact_radii} | found)


NOTES = {
    "times",
    "ring edges",
    "wear at inner edges",
    "wear at outer edges",
    "displacements times",
    "lowest height",
}


def read_dat(path: Path) -> pd.DataFrame:
    """Return results of CalculiX: pressures by reaction forces, their sum, and displacements.

    Raises
    ------
    SceneError
        if the deck is not beside it, or if a step or its forces are not there
    """
    deck, tables = Deck.beside(path), []
    blocks = {(what, name, time): values for what, name, time, values in _blocks(path)}
    for step, time in enumerate(deck.times):
        end = max((when for *_, when in blocks if when <= step + 1 + 1e-6), default=0.0)
        if abs(end - step - 1) > 1e-6:
            raise SceneError(
                f"{path}: step {step + 1} of {len(deck.times)} is not there, or not finished: did "
                "the program stop early?"
            )
        found = {(what, name): of for (what, name, when), of in blocks.items() if when == end}
        forces = found.get(("forces", "FACE"), found.get(("forces", "CONTACT")))
        if forces is None or len(forces) != len(deck.contact_radii):
            raise SceneError(
                f"{path} has no forces of all nodes of the contact: keep *NODE PRINT and RF of the "
                "deck as they are"
            )
        pressed = -WEDGE * forces
        results = {
            "pressure": deck.pressures(float(time), pressed),
            "normal_force": np.full(len(pressed), pressed.sum()),
        }
        if ("forces", "FACE") in found:
            results["displacement"] = -deck.scale * found["displacements", "CONTACT"]
            if ("displacements", "REF") in found:
                depth = deck.lowest - deck.scale * found["displacements", "REF"][0]
                results["indentation"] = np.full(len(pressed), depth)
        tables.append(deck.rows(float(time), results))
    return pd.concat(tables, ignore_index=True)


def _blocks(path: Path) -> Iterator[tuple[str, str, float, Array]]:
    """Yield the vertical components of the blocks of nodes: what, of which set, and when."""
    title, values = None, list[float]()
    with path.open(encoding="utf-8", errors="replace") as lines:
        for line in lines:
            words = line.split()
            if len(words) == 4 and words[0].isdigit():
                values.append(float(words[2]))
                continue
            if words:
                if title and values:
                    yield title["what"], title["set"], float(title["time"]), np.array(values)
                title, values = DAT_TITLE.search(line), []
    if title and values:
        yield title["what"], title["set"], float(title["time"]), np.array(values)


def read_rpt(path: Path) -> pd.DataFrame:
    """Return results of a report of nodal fields by Abaqus: CPRESS, RF.RF2 and U.U2.

    Raises
    ------
    SceneError
        if the deck is not beside it, or if the report has no such columns or nodes
    """
    deck, tables = Deck.beside(path), []
    nodes = deck.sets["CONTACT"]
    for step, table in _reported(path, len(deck.times)):
        time = float(deck.times[min(step, len(deck.times)) - 1])
        given = table.reindex(nodes)
        results = dict[str, Array]()
        if "CPRESS" in given:
            results["pressure"] = given["CPRESS"].to_numpy()
        elif "RF.RF2" in given and given["RF.RF2"].notna().all():
            pressed = -given["RF.RF2"].to_numpy()
            results["pressure"] = deck.pressures(time, pressed)
            results["normal_force"] = np.full(len(pressed), pressed.sum())
        if "U.U2" in given and "RF.RF2" not in given:
            results["displacement"] = -deck.scale * given["U.U2"].to_numpy()
        if not any(np.isfinite(of).any() for of in results.values()):
            raise SceneError(
                f"{path}: step {step} has no CPRESS, and not RF.RF2 of every node of the set "
                "CONTACT: report one of them at unique nodal positions"
            )
        tables.append(deck.rows(time, results))
    return pd.concat(tables, ignore_index=True)


def _reported(path: Path, steps: int) -> Iterator[tuple[int, pd.DataFrame]]:
    """Yield the number of each step and its table by node; of a contact deck, the last step."""
    found, step, heads = dict[int, dict[int, dict[str, float]]](), 1, list[str]()
    with path.open(encoding="utf-8", errors="replace") as lines:
        for line in lines:
            words = line.split()
            if named := RPT_STEP.search(line):
                step = int(named["step"])
            elif words[:1] == ["Node"] and len(words) > 1:
                heads = words[1:]
            elif heads and len(words) == len(heads) + 1 and words[0].isdigit():
                row = dict(zip(heads, map(float, words[1:]), strict=True))
                found.setdefault(step, {}).setdefault(int(words[0]), {}).update(row)
    if not found:
        raise SceneError(
            f"{path} has no table of nodes: in Abaqus/Viewer report a field at unique nodal "
            "positions, sorted by node label"
        )
    if steps == 1:
        found = {1: found[max(found)]}
    for number, rows in sorted(found.items()):
        yield number, pd.DataFrame.from_dict(rows, orient="index")


READERS = {".dat": read_dat, ".rpt": read_rpt}
"""Readers by the ending of the file."""
