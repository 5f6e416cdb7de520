"""Tables of other programs: numbers, headings and layouts, from text and from memory."""

from math import nan

import numpy as np
import pandas as pd
import pytest

from ringwear import SceneError
from ringwear.studies.crosscheck import QUANTITIES
from ringwear.studies.tables.frame import Frame, surface_table
from ringwear.studies.tables.headings import KINDS, name_of, split_heading
from ringwear.studies.tables.layout import content_of_file


def frame_of(text, tmp_path, encoding="utf-8", headed=True):
    path = tmp_path / "theirs.txt"
    path.write_bytes(text.encode(encoding))
    return Frame.of_file(path, headed)


NUMBERS = [
    (("1.5", "2", "1e3"), (1.5, 2, 1e3)),
    (("0,25", "0,125", "12"), (0.25, 0.125, 12)),
    (("1.6D+02", "1.6+02", "-1.5-03"), (160, 160, -1.5e-3)),
    (("\u22121.5", "\u20132", "+3"), (-1.5, -2, 3)),
    (("1,800.0", "2.5", "12,000.0"), (1800, 2.5, 12000)),
    (("1.800,0", "2,5", "12.000,0"), (1800, 2.5, 12000)),
    (("1.5x10^-3", "2*10^3", "1E3"), (1.5e-3, 2e3, 1e3)),
    (("1 800,0", "1'000,5", "1\u202f000"), (1800, 1000.5, 1000)),
    (("5 %", "12%", "0.5%"), (0.05, 0.12, 0.005)),
    (("1/4", "1/8", "2"), (0.25, 0.125, 2)),
    (("00:00:00", "00:30:00", "25:00:00"), (0, 1800, 90000)),
    (("2026-03-02 08:00", "2026-03-02T08:30:00Z", "2026-03-03 08:00"), (0, 1800, 86400)),
    (("1.#QNAN", "-1.#IND", "1"), (nan, nan, 1)),
    (("Bad", "No Data", "2"), (nan, nan, 2)),
    (("", "****", "-nan(ind)", "NA", "null", "-", "#N/A"), (nan,) * 7),
]


@pytest.mark.parametrize(("cells", "expected"), NUMBERS)
def test_numbers_of_a_column(cells, expected, tmp_path):
    frame = frame_of("a|b\n" + "".join(f"{cell}|1\n" for cell in cells), tmp_path)
    frame.refuse_faults({"a": "a"})
    np.testing.assert_allclose(frame.values["a"], expected)


def test_thousands_are_read_if_another_column_decides_and_else_refused(tmp_path):
    with pytest.raises(SceneError, match=r"line 2, column 'a': '1,600' may have a decimal comma"):
        frame_of("a;b\n1,600;1\n6,400;2\n", tmp_path).refuse_faults({"a": "a"})
    for other, expected in ("1.00625", 1600), ("1,00625", 1.6):
        frame = frame_of(f"a;b\n1,600;{other}\n", tmp_path)
        assert frame.values["a"].tolist() == [expected]


@pytest.mark.parametrize(
    ("cells", "line"), [("0,5;1,25;1.800", 4), ("1.25;1,800;0.5", 3), ("23:59:00;00:01:00", 3)]
)
def test_a_cell_that_differs_from_its_column_is_refused(cells, line, tmp_path):
    """A point may be a comma that is misspelt, and a clock may have passed midnight."""
    rows = "".join(f"{cell}|x\n" for cell in cells.split(";"))
    with pytest.raises(SceneError, match=f"line {line}, column 'a'"):
        frame_of(f"a|b\n{rows}", tmp_path).refuse_faults({"a": "a"})


def test_a_small_file_is_read_once(tmp_path, monkeypatch):
    """A pipe cannot be read twice."""
    calls = []

    def counted(*given):
        calls.append(given)
        return content_of_file(*given)

    monkeypatch.setattr("ringwear.studies.tables.frame.content_of_file", counted)
    assert frame_of("time,p\n0,1.5\n", tmp_path).values.to_numpy().tolist() == [[0, 1.5]]
    assert len(calls) == 1


def test_large_files_are_read_fast_and_like_small_ones(tmp_path, monkeypatch):
    table = pd.DataFrame({"time": 0.0, "radius": np.linspace(0, 1, 500), "pressure": 2.0})
    plain = table.to_csv(index=False)
    head, _, rows = plain.partition("\n")
    plain_texts = [
        plain,
        "# a remark\n\n" + plain,
        "% a remark\n% time,radius,pressure\n" + rows,
        f"{head}\ns,m,Pa\n{rows}",
        plain.replace(",", " "),
        plain.replace(",", ";").replace(".", ","),
        plain + "0,0.5,NaN\n",
    ]
    odd_texts = [plain + line for line in ("0,0.5,\n", "# a remark\n", "\n", "0,.5,1D0\n")]
    for text in plain_texts + odd_texts:
        by_lines = frame_of(text, tmp_path)
        monkeypatch.setattr("ringwear.studies.tables.frame.HEAD", 2000)
        at_once = frame_of(text, tmp_path)
        monkeypatch.undo()
        pd.testing.assert_frame_equal(at_once.values, by_lines.values, check_index_type=False)
        assert at_once.units == by_lines.units
        # numbers that are read at once are no texts any more
        assert (at_once.cells.dtypes == "float64").all() == (text in plain_texts)
    for line in ("0,0.5\n", "0,0.5,1,2\n"):
        for size in (2000, 10**6):
            monkeypatch.setattr("ringwear.studies.tables.frame.HEAD", size)
            with pytest.raises(SceneError, match=r"line 502: \d cells under 3 columns"):
                frame_of(plain + line, tmp_path)


def test_a_heading_that_is_open_is_refused_if_the_column_is_needed(tmp_path):
    text = "t,p [MPa,q [mPa],a,a,b,d [?m]\n0,1,2,3,4,5,6\n"
    frame = frame_of(text, tmp_path)
    frame.refuse_faults({"t": "time", "b": "b"})
    for heading, message in (
        ("p [MPa", "close the brackets"),
        ("q [mPa]", "may be another one: write it as in MPa"),
        ("d [?m]", "may be another one: write it as in MPa, um"),
        ("a", "two columns are called a"),
    ):
        with pytest.raises(SceneError, match=message):
            frame.refuse_faults({heading: heading})


def test_kinds_of_units_are_those_of_the_quantities():
    for name, kind in KINDS.items():
        assert name not in QUANTITIES or QUANTITIES[name].unit == kind


@pytest.mark.parametrize(
    ("heading", "name"),
    [
        ("F [N]", "normal_force"),
        ("f", "profile"),
        ("load (kN)", "normal_force"),
        ("d", "indentation"),
    ],
)
def test_a_unit_may_tell_what_a_symbol_is(heading, name):
    assert name_of(heading)[1].name == name


@pytest.mark.parametrize(
    "cell", ["x", "<0.01", "1.5 ± 0.1", "0x10", "1_000", "1+2i", "00:30", "1-2", "03/02/2026"]
)
def test_what_is_no_number_is_named_with_its_line(cell, tmp_path):
    frame = frame_of(f"t|a\n0|{cell}\n1|2\n", tmp_path)
    with pytest.raises(SceneError, match=r"line 2, column 'a': '.*; give a number"):
        frame.refuse_faults({"a": "a"})


@pytest.mark.parametrize(
    ("heading", "expected"),
    [
        ("time", ("time", "")),
        ("Time [s]", ("time", "s")),
        ("t", ("time", "")),
        ("R (mm)", ("radius", "mm")),
        ("p / MPa", ("pressure", "MPa")),
        ("Contact pressure [MPa]", ("pressure", "MPa")),
        ("Normal Force", ("normal_force", "")),
        ("wear coefficient [mm^3/(N m)]", ("wear_coefficient", "mm^3/(N m)")),
        *dict.fromkeys(("x_um", "x um", "x in um", "X_(microns)"), ("radius", "um")).items(),
        ("pressure_kPa", ("pressure", "kPa")),
        ("time_s", ("time", "s")),
        ("PRESSURE_MPA", ("pressure", "MPa")),
        ("Pressure [mPa]", ("pressure", "mPa")),
        ("pressure_mPa", ("pressure", "mPa")),
        ("load_mN", ("normal_force", "mN")),
        *((name, (name, "")) for name in ("p_m", "sigma_n", "u_s", "worn_volume", "p_min")),
    ],
)
def test_headings_are_known_in_any_case_by_symbols_and_with_units(heading, expected):
    found = name_of(heading)
    name = found[1].name if found else split_heading(heading).name
    assert (name, split_heading(heading).unit) == expected


ROWS = "0,1.5\n1,2.5\n"
LAYOUTS = {
    "plain": f"time,p\n{ROWS}",
    "byte order mark": f"\ufefftime,p\n{ROWS}",
    "semicolons": "time;p\n0;1,5\n1;2,5\n",
    "sep=": "sep=;\ntime;p\n0;1,5\n1;2,5\n",
    "tabs": "time\tp\n0\t1.5\n1\t2.5\n",
    "spaces": "  time   p\n\n  0   1.5\n  1   2.5\n",
    "quotes": '"time","p"\n"0","1,5"\n"1","2,5"\n',
    "Markdown": "| time | p |\n|---|---|\n| 0 | 1.5 |\n| 1 | 2.5 |\n",
    "commas at ends": "time,p\n0,1.5,,\n1,2.5,,\n",
    "commas at all ends": "time,p,\n0,1.5,\n1,2.5,\n",
    "headings in a comment": f"# made by A\n# time,p\n{ROWS}",
    "comments by !": "! time p\n0 1.5\n1 2.5\n",
    "comments at ends": "time,p\n0,1.5 # first\n1,2.5 // second\n",
    "preamble": f"Points,2\nDate,2026-03-02\nBy,A\n\ntime,p\n{ROWS}2,3.5\n",
    "CRLF": f"time,p\n{ROWS}".replace("\n", "\r\n"),
}


@pytest.mark.parametrize("kind", LAYOUTS)
def test_layouts(kind, tmp_path):
    frame = frame_of(LAYOUTS[kind], tmp_path)
    assert [*frame.values] == ["time", "p"]
    assert frame.values.to_numpy()[:2].tolist() == [[0, 1.5], [1, 2.5]]


@pytest.mark.parametrize("encoding", ["utf-8", "utf-16", "gbk"])
def test_encodings(encoding, tmp_path):
    frame = frame_of("\u65f6\u95f4(s),\u6df1\u5ea6(um)\n0,1\n", tmp_path, encoding)
    assert [*frame.units.values()] == ["s", "um"]
    assert frame_of("d [\xb5m];t\n0,5;1\n", tmp_path, "cp1252").units == {"d [\xb5m]": "\xb5m"}


@pytest.mark.parametrize(
    "text",
    [
        "time [s],p [MPa]\n0,1\n",
        "time,p\ns,MPa\n0,1\n",
        "time,p\n[s],[MPa]\n0,1\n",
        "time_s,p_mpa\n0,1\n",
        "% time [s],p [MPa]\n0,1\n",
    ],
)
def test_units(text, tmp_path):
    assert [*frame_of(text, tmp_path).units.values()] == ["s", "MPa"]


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "has no rows"),
        ("time,p\n", "has no rows"),
        ("0,1\n1,2\n", "line 1: the first line must name the columns"),
        ("time,p\n0,1\n1\n2,3\n", "line 3: 1 cells under 2 columns"),
        ("time,p\n0,1,2\n1,2,3\n", "line 2: 3 cells under 2 columns"),
        ("time p\n0 1\n\ntime p\n0 2\n", "line 4: 'time p' is no row of numbers"),
        ('{"time": [0, 1]}', "is JSON: give CSV"),
        ("PK\x03\x04\x00", "is a workbook of Excel or an archive: export one sheet as CSV"),
        ("<html><body>", "is a page in HTML"),
        ("*Step = 1\n*Time = 0\n1 2 3\n", "is a log of FEBio"),
    ],
)
def test_what_is_no_table_is_refused(text, message, tmp_path):
    with pytest.raises(SceneError, match=message):
        frame_of(text, tmp_path)


@pytest.mark.parametrize("form", ["p (MPa) @ t={}", "p [MPa] t={}", "p_MPa (t = {})"])
def test_a_column_for_each_time_becomes_rows(form, tmp_path):
    text = f"r,{form.format(0)},{form.format(1800)}\n1,2,3\n2,4,5\n"
    frame = frame_of(text, tmp_path).long()
    assert frame.values.to_numpy().tolist() == [[1, 0, 2], [2, 0, 4], [1, 1800, 3], [2, 1800, 5]]
    assert [*frame.units.values()] == ["MPa"]


def test_tables_in_memory():
    times = pd.to_datetime("2026-03-02") + pd.to_timedelta([0, 1800], "s")
    table = pd.DataFrame({("run", "time"): times, ("run", "d"): ["1,5", "2,5"]})
    frame = Frame.of_pandas(table, "theirs")
    assert frame.values.to_numpy().tolist() == [[0, 1.5], [1800, 2.5]]
    assert frame.units == {"time": "s"}
    masked = pd.DataFrame({"p": [1.0, 0.0], "vtkValidPointMask": [1, 0]})
    assert Frame.of_pandas(masked, "theirs").values.to_numpy().tolist() == [[1.0]]


@pytest.mark.parametrize("axis", [1, 2])
@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_arrays_at_the_surface_of_a_mesh(axis, sign):
    points, vectors, tensors = np.zeros((3, 3)), np.zeros((3, 3)), np.zeros((3, 3, 3))
    points[:, 0], points[2, axis], vectors[:, axis] = [0, 1, 0], sign, sign * 0.5
    tensors[:, axis, axis] = -2.0
    table = surface_table(points, {"u": vectors, "s t=1": tensors, "p": np.ones((3, 1))})
    expected = {
        "radius": [0.0, 1.0],
        "displacement": [0.5, 0.5],
        "s_zz t=1": [-2.0, -2.0],
        "p": [1.0, 1.0],
    }
    assert table.to_dict("list") == expected
