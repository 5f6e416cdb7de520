"""Files of others with one fault: each is refused, or read as before but for the fault itself."""

import csv
import logging
import random
from datetime import date
from difflib import ndiff

import numpy as np
import pandas as pd
import pytest

from ringwear import RingwearError, Scene, SceneError
from ringwear.meshes.decks import read_deck
from ringwear.studies.check.tables import read
from ringwear.studies.crosscheck import profile_of_file
from ringwear.studies.fit.data import read_measurements
from ringwear.studies.study.orders import read_table
from ringwear.studies.tables.frame import Frame

MUTATIONS = 2000
SCENE = Scene(
    units="mm, N, MPa, s",
    methods=["mdr"],
    punch={"radius": 10.0, "rings": 1, "wear_coefficients": [1e-9]},
    half_space={"plane_strain_modulus": 1000.0},
    load={"normal_force": 1000.0, "sliding_speed": 100.0},
    wear={"times": [0.0, 1800.0]},
)
RADII = np.array([0.0, 1.25, 2.5, 3.75, 5.0, 6.25, 7.5, 8.75])
FIELDS = pd.DataFrame(
    {
        "time": np.repeat([0.0, 1800.0], len(RADII)),
        "radius": np.tile(RADII, 2),
        "pressure": np.tile(1.59155 / np.sqrt(1 - (RADII / 10) ** 2), 2).round(5),
    }
)
HISTORY = pd.DataFrame(
    {
        "time": 900.0 * np.arange(12),
        "indentation": (0.05 + 0.001 * np.arange(12) ** 0.8).round(6),
        "normal_force": 1000.0 + np.arange(12) % 5,
    }
)
PROFILE = pd.DataFrame(
    {"x": np.linspace(0, 10, 21), "z": (0.1 + np.linspace(0, 10, 21) ** 2 / 180).round(6)}
)
LEVELS = pd.DataFrame({"h": [0.5, 0.25, 0.125, 0.0625], "u": [1.02512, 1.00625, 1.00156, 1.00039]})


def text(table, separator=",", head=None, form="{:.6g}", comma=False, above="", below=""):
    """Return a table as text; `head` is a line of headings, by default the names."""
    cells = [[form.format(value) for value in row] for row in table.to_numpy()]
    if comma:
        cells = [[cell.replace(".", ",") for cell in row] for row in cells]
    head = separator.join(table) if head is None else head
    rows = [separator.join(row) for row in cells]
    return above + "\n".join(filter(None, [head, below, *rows])) + "\n"


def good_files():
    """Return good files: what reads each, and its content, by a name."""
    fields, history, profile = FIELDS, HISTORY, PROFILE
    in_si = fields * [1, 1e-3, 1e6]
    wide = fields[:8][["radius", "pressure"]].assign(later=fields[8:]["pressure"].to_numpy())
    paths = fields[:8][["pressure", "radius"]].assign(valid=1.0, y=0.0)
    clocks = history.assign(time=[f"{n // 4}:{15 * (n % 4):02}:00" for n in range(12)])
    plain = clocks.astype(str)
    clock_text = ",".join(plain) + "\n" + "\n".join(map(",".join, plain.to_numpy())) + "\n"
    numbered = fields.reset_index(names="No")
    thousands = text(history * [1, 1000, 1], ";", "time;d (um);F (N)", "{:,.3f}")
    missing = text(fields).replace("1.59155", "1.#QNAN", 1).replace("1.83776", "", 1)
    return {
        "plain": ("check", text(fields)),
        "semicolons": ("check", text(fields, ";", comma=True)),
        "tabs": ("check", text(fields, "\t")),
        "spaces": ("check", text(fields, "  ")),
        "aligned": ("check", text(fields, "", "time radius pressure", " {:14.6e}")),
        "units in brackets": ("check", text(in_si, head="time [s],radius [m],pressure [Pa]")),
        "units in parentheses": ("check", text(in_si, head="t (s),r (m),p (Pa)")),
        "units after slashes": ("check", text(in_si, ";", "t/s;r/m;p/Pa")),
        "units after words": ("check", text(in_si, head="time_s,radius_m,pressure_Pa")),
        "units below": ("check", text(in_si, head="time,radius,pressure", below="s,m,Pa")),
        "a comment as headings": ("check", text(fields, head="# time,radius,pressure")),
        "comments": ("check", text(fields, above="# by a program\n% of others\n")),
        "exponents": ("check", text(fields, form="{:.6E}").replace("E", "D")),
        "Markdown": (
            "check",
            text(fields, " | ", "time | radius | pressure", below="--- | --- | ---"),
        ),
        "quotes": ("check", fields.to_csv(index=False, quoting=csv.QUOTE_ALL)),
        "lines of Windows": ("check", text(fields).replace("\n", "\r\n")),
        "trailing commas": ("check", text(fields).replace("\n", ",\n")),
        "missing values": ("check", missing),
        "an index": ("check", text(numbered)),
        "a path": ("check", text(paths, head="CPRESS,Points:0,vtkValidPointMask,Points:1")),
        "a column for each time": (
            "check",
            text(wide, head="% r,solid.Tn (MPa) @ t=0,solid.Tn (MPa) @ t=1800"),
        ),
        "a preamble": ("check", text(fields, ";", above="Project;punch\nOperator;A\n")),
        "minus signs": ("check", text(fields.assign(pressure=-fields["pressure"]), head="t,r,S22")),
        "a history": ("fit", text(history)),
        "a history in um": ("fit", text(history * [1, 1e3, 1], "\t", "time\tdepth [um]\tFn [N]")),
        "a history with commas": ("fit", text(history, ";", comma=True)),
        "a history by the clock": ("fit", clock_text),
        "a history with thousands": ("fit", thousands),
        "a history in hours": ("fit", text(history / [3600, 1, 1], head="time [h],d [mm],F [N]")),
        "a scan": ("scan", text(profile)),
        "a scan in two units": ("scan", text(profile * [1, 1e3], head="x [mm],z [um]")),
        "a scan with suffixes": ("scan", text(profile * 1e3, head="x_um,z_um")),
        "a scan with a row of units": ("scan", text(profile, ";", "Lateral;Height", below="mm;mm")),
        "a scan without headings": ("scan", text(profile, "\t", "")),
        "a scan with decimal commas": ("scan", text(profile, ";", comma=True)),
        "a scan in Chinese": ("scan", text(profile, head="位置(mm),高度(mm)")),
        "levels": ("orders", text(LEVELS)),
        "levels with commas": ("orders", text(LEVELS, ";", comma=True)),
        "levels between spaces": ("orders", text(LEVELS, "  ", "h [mm]  u [mm]")),
        "levels with thousands": (
            "orders",
            text(LEVELS.assign(n=[1600, 6400, 25600, 102400]), ";", form="{:,.5f}"),
        ),
    }


def values_in(kind, path):
    """Return the numbers that are read from a file, by columns."""
    if kind == "check":
        return read(path, path.name, SCENE, {}, "", time=0.0)
    if kind == "fit":
        found = read_measurements(SCENE, [path])
        return pd.DataFrame({"time": found[0].times} | {each.column: each.values for each in found})
    if kind == "scan":
        profile = profile_of_file({"kind": "table"}, path, SCENE.table())
        heights = np.array(profile["heights"])
        if not heights.min():
            # a fault that makes a height negative shifts all, but one that makes it 0 does not
            right = np.interp(profile["radii"], PROFILE["x"], PROFILE["z"])
            heights += np.median(right - heights)
        return pd.DataFrame({"x": profile["radii"], "z": heights})
    return read_table(str(path)).select_dtypes("number")


def character(content, draw):
    """Delete, double or replace a character."""
    place = draw.randrange(len(content))
    new = draw.choice(["", 2 * content[place], draw.choice('0123456789.,;- eE\t"#[]um')])
    return content[:place] + new + content[place + 1 :]


def line(content, draw):
    """Cut a line, or move it."""
    lines = content.splitlines(keepends=True)
    taken = lines.pop(draw.randrange(len(lines)))
    if draw.random() < 0.5:
        lines.insert(draw.randrange(len(lines) + 1), taken)
    return "".join(lines)


def delimiters(content, draw):
    """Replace all delimiters of one kind by others."""
    old = draw.choice([each for each in ",;\t " if each in content])
    return content.replace(old, draw.choice(",;\t|"))


ENCODINGS = ("utf-16", "utf-8-sig", "gb18030", "utf-16-le", "utf-8")


def is_faithful(before, after, lines):
    """Return whether a table has only rows of another one, but for one cell in some lines."""
    if after.shape[1] == before.shape[1] and {*after} - {*before}:
        # a fault in a heading changes its name
        after = after.set_axis(before.columns, axis=1)
    common = [name for name in before if name in after]
    rows, known = after[common].to_numpy(float), before[common].to_numpy(float)
    same = np.isclose(rows[:, None], known, rtol=1e-6, atol=1e-9, equal_nan=True)
    # the number of cells of each row that no row of the other table has
    wrong = (~same).sum(axis=2).min(axis=1)
    return bool((wrong > 0).sum() <= lines and wrong.max() <= 1)


def fault_of(kind, path, good, caplog, lines=0):
    """Read a file with a fault; return what is wrong with that, else nothing.

    Parameters
    ----------
    kind : what reads the file
    path : of the file
    good : what is read from the file without the fault, the messages, and the units
    lines : number of rows that the fault may change; 0 if it cuts or moves whole lines
    """
    before, usual, units = good
    caplog.clear()
    try:
        after = values_in(kind, path)
    except SceneError as error:
        return "" if path.name in str(error) else f"no file in: {error}"
    except Exception as error:
        return f"{type(error).__name__}: {error}"
    messages = {record.getMessage() for record in caplog.records} - usual
    found = Frame.of_file(path, headed=False).units
    # a fault in a unit may be another unit, and a file without its line of units is a good one
    other_units = found.items() - units.items() or (units and not found and not lines)
    if messages or other_units or is_faithful(before, after, lines):
        return ""
    return f"read as\n{after}"


@pytest.mark.nightly
def test_a_fault_in_a_file_is_refused_or_seen(tmp_path, caplog):
    """The faults of a day are always the same ones."""
    draw = random.Random(date.today().toordinal())
    caplog.set_level(logging.INFO, logger="ringwear")
    faults, files, good = [], good_files(), {}
    path = tmp_path / "theirs.txt"
    for name, (kind, content) in files.items():
        path.write_text(content, "utf-8")
        caplog.clear()
        values = values_in(kind, path)
        messages = {record.getMessage() for record in caplog.records}
        good[name] = values, messages, Frame.of_file(path, headed=False).units
    for _ in range(MUTATIONS):
        name = draw.choice([*files])
        kind, content = files[name]
        change, lines = draw.choice([(character, 2), (line, 0), (delimiters, 0), (None, 0)])
        encoding = "utf-8" if change else draw.choice(ENCODINGS)
        mutated = change(content, draw) if change else content
        path.write_bytes(mutated.encode(encoding))
        if fault := fault_of(kind, path, good[name], caplog, lines):
            changes = ndiff(content.splitlines(), mutated.splitlines())
            shown = "\n".join(each for each in changes if not each.startswith(" "))
            faults.append(f"{name}, {encoding}:\n{shown}\n{fault}")
    assert not faults, "\n\n".join([f"{len(faults)} faults", *faults[:20]])


VTU = """<?xml version="1.0"?>
<VTKFile type="UnstructuredGrid" version="0.1" byte_order="LittleEndian">
<UnstructuredGrid><Piece NumberOfPoints="3" NumberOfCells="1">
<Points><DataArray type="Float64" NumberOfComponents="3" format="ascii">
0 0 0 10 0 0 0 -10 0
</DataArray></Points>
<Cells><DataArray type="Int64" Name="connectivity" format="ascii">0 1 2</DataArray>
<DataArray type="Int64" Name="offsets" format="ascii">3</DataArray>
<DataArray type="Int64" Name="types" format="ascii">5</DataArray></Cells>
<PointData><DataArray type="Float64" Name="disp_y" format="ascii">-1 -1 0</DataArray></PointData>
</Piece></UnstructuredGrid></VTKFile>
"""
DECK = """*HEADING
** times: 0, 1800
** ring edges: 0, 10
** wear at inner edges: 1e-9
** wear at outer edges: 1e-9
** displacements times: 1
** lowest height: 0
*NODE, NSET=ALL
1, 0, 0, 0.
2, 5, 0, 0.
3, 10, 0, 0.
4, 0, -10, 0.
*ELEMENT, TYPE=CAX3, ELSET=SOLID
1, 4, 3, 1
*NSET, NSET=CONTACT
1, 2, 3
"""
TABLE_OF_DAT = (
    "forces (fx,fy,fz) for set CONTACT and time {}\n\n 1 0. -1. 0.\n 2 0. -2. 0.\n 3 0. -3. 0.\n"
)
TABLE_OF_RPT = (
    "Step: STEP-{}\n\n  Node   RF.RF2\n Label   @Loc 1\n----\n 1  -1.\n 2  -2.\n 3  -3.\n"
)


def other_files(folder):
    """Return the contents of files that are no tables of text, by their names."""
    fields = FIELDS.set_index(["time", "radius"]).to_xarray()
    contents = {"theirs.vtu": VTU.encode(), "mesh.inp": DECK.encode(), "job.inp": DECK.encode()}
    for name, table in {"job.dat": TABLE_OF_DAT, "job.rpt": TABLE_OF_RPT}.items():
        contents[name] = "".join(map(table.format, (1, 2))).encode()
    for name, form in {"new.nc": "NETCDF4", "old.nc": "NETCDF3_CLASSIC"}.items():
        fields.to_netcdf(folder / name, format=form)
        contents[name] = (folder / name).read_bytes()
    return contents


@pytest.mark.nightly
def test_a_fault_in_a_mesh_or_in_results_is_refused_or_read(tmp_path):
    """Whatever is in these files, they end in numbers or in one line that names the file."""
    draw = random.Random(date.today().toordinal())
    contents, faults = other_files(tmp_path), []
    for name, content in contents.items():
        (tmp_path / name).write_bytes(content)

    def read_of(name):
        if name == "mesh.inp":
            return read_deck(tmp_path / name).points
        # a fault of a deck is one of its results
        path = tmp_path / name.replace("job.inp", "job.dat")
        return read(path, path.name, SCENE, {}, "", time=0.0)

    for name in contents:
        assert len(read_of(name)) > 1
    for _ in range(MUTATIONS):
        name = draw.choice([*contents])
        mutated = bytearray(contents[name])
        for _ in range(draw.choice([1, 1, 4])):
            mutated[draw.randrange(len(mutated))] = draw.choice(
                [draw.randrange(256), *b"0.,; -e\n"]
            )
        end = draw.choice([len(mutated), len(mutated), draw.randrange(len(mutated))])
        (tmp_path / name).write_bytes(mutated[:end])
        try:
            read_of(name)
        except RingwearError as error:
            if name.partition(".")[0] not in str(error) and name != "mesh.inp":
                faults.append(f"{name}: no file in {error}")
        except Exception as error:
            faults.append(f"{name}: {type(error).__name__}: {error}\n{bytes(mutated[:end])!r}")
        (tmp_path / name).write_bytes(contents[name])
    assert not faults, "\n\n".join([f"{len(faults)} faults", *faults[:20]])


def test_good_files_are_read(tmp_path):
    path = tmp_path / "theirs.txt"
    for name, (kind, content) in good_files().items():
        path.write_text(content, "utf-8")
        found = values_in(kind, path)
        expected = {"check": FIELDS, "fit": HISTORY, "scan": PROFILE, "orders": LEVELS}[kind]
        shared = [each for each in expected if each in found]
        assert len(shared) > 1, name
        assert is_faithful(expected[shared], found[shared].dropna(), 0), name
        # a path has one of two times
        assert len(found) in (len(expected), len(expected) / 2), name
