"""Units of scenes: refusals of inconsistent ones, and quantities with their own units."""

from typing import Annotated

import numpy as np
import pytest

from ringwear import Scene, SceneError
from ringwear.studies.crosscheck.problem.fields import OverTime, Positive, Section, Unit
from ringwear.studies.crosscheck.problem.punch import PunchSection
from ringwear.studies.crosscheck.problem.unit_names import UnitNames, kind_of, without_quantities
from ringwear.studies.crosscheck.verdict.agreement import when_in_words
from ringwear.studies.crosscheck.verdict.promise import LeftOut, in_words

SI = {
    "punch": {
        "radius": 0.02,
        "ring_edges": [0.005, 0.02],
        "wear_coefficients": [1e-15, 1e-13],
        "recess": [0.0, 3e-6],
        "profile": {"kind": "parabola", "curvature_radius": 25.0},
    },
    "half_space": {"youngs_modulus": 2e9},
    "load": {
        "normal_force": {"times": [0.0, 3600.0], "values": [500.0, 2000.0]},
        "sliding_speed": 0.1,
    },
    "wear": {"times": [0.0, 60.0, 7200.0]},
    "output": {"radii": [0.001, 0.01]},
}
WRITTEN = {
    "punch": {
        "radius": "20 mm",
        "ring_edges": ["0.5 cm", "20000 µm"],
        "wear_coefficients": ["1e-15 m^2/N", "1e-4 mm^3/(N m)"],
        "recess": [0.0, "3 um"],
        "profile": {"kind": "parabola", "curvature_radius": "25 m"},
    },
    "half_space": {"youngs_modulus": "2 GPa"},
    "load": {
        "normal_force": {"times": ["0 s", "1 h"], "values": ["0.5 kN", "2 kN"]},
        "sliding_speed": "360 m/h",
    },
    "wear": {"times": ["0 s", "1 min", "2 h"]},
    "output": {"radii": ["1 mm", "1 cm"]},
}


def numbers(table):
    for value in table.values() if isinstance(table, dict) else table:
        if isinstance(value, dict | list):
            yield from numbers(value)
        elif isinstance(value, float):
            yield value


@pytest.mark.parametrize(
    ("units", "sizes"),
    [("SI", (1.0, 1.0, 1.0, 1.0)), ("mm, N, MPa, s", (1e-3, 1.0, 1e6, 1.0))],
)
def test_quantities_with_units_equal_plain_numbers(units, sizes):
    """Quantities equal the plain numbers in SI within 1e-14, and are converted to other units."""
    table = Scene.from_table(WRITTEN | {"units": units}).table()
    expected = Scene.from_table(SI).table()
    assert table.pop("units") == units
    if units == "SI":
        np.testing.assert_allclose(
            list(numbers(table)), list(numbers(expected)), rtol=1e-14, atol=0
        )
    length, force, pressure, time = sizes
    assert table["punch"]["radius"] == pytest.approx(0.02 / length, rel=1e-14)
    assert table["punch"]["wear_coefficients"][1] == pytest.approx(1e-13 * pressure, rel=1e-14)
    assert table["half_space"]["youngs_modulus"] == pytest.approx(2e9 / pressure, rel=1e-14)
    assert table["load"]["normal_force"]["values"][1] == pytest.approx(2e3 / force, rel=1e-14)
    assert table["load"]["sliding_speed"] == pytest.approx(0.1 / length * time, rel=1e-14)


def test_results_do_not_depend_on_the_units():
    one, other = (
        Scene.from_table(WRITTEN | {"units": of}).problem for of in ("SI", "mm, N, MPa, s")
    )
    np.testing.assert_allclose(one.times, other.times, rtol=1e-13)
    assert one.units.displacement == pytest.approx(1e-3 * other.units.displacement, rel=1e-13)


@pytest.mark.parametrize(
    "units",
    [
        "bananas",
        "mm, N, GPa, s",
        "mm, kN, MPa, s",
        "m, kg, Pa, s",
        "m, N, Pa, Hz",
        "m, N, degC, s",
        "N, m, Pa, s",
        "m, N, , s",
        "2 mm, N, MPa, s",
        "metric",
    ],
)
def test_units_that_are_not_consistent_are_refused(units):
    with pytest.raises(SceneError, match="units") as refused:
        Scene.load("flat_punch").changed(units=units)
    assert "such as 'mm, N, MPa, s'" in str(refused.value) or "not consistent" in str(refused.value)


@pytest.mark.parametrize(
    ("stated", "value", "kind", "text"),
    [
        ("mm, N, MPa, s", 12.0, "length", "12 mm"),
        ("mm, N, MPa, s", 3e-3, "pressure", "0.003 MPa"),
        ("mm, N, MPa, s", 2.5e-5, "displacement", "2.5e-05 mm"),
        ("mm, N, MPa, s", 5000.0, "volume", "5000 mm³"),
        ("mm, N, MPa, s", 1e-8, "wear_rate", "3.6e-05 mm/h"),
        ("mm, N, MPa, s", 2.0, "wear_rate", "2 mm/s"),
        ("mm, N, MPa, s", 7200.0, "time", "2 h"),
        ("mm, N, MPa, s", 0.005, "time", "0.005 s"),
        ("mm, N, MPa, h", 48.0, "time", "48 h"),
        ("mm, N, MPa, h", 3e-4, "wear_rate", "0.0003 mm/h"),
        ("mm, N, MPa, s", 1e-9, "wear_coefficient", "1e-06 mm³/(N m)"),
        ("", 12.0, "length", "12"),
    ],
)
def test_numbers_are_written_in_the_stated_units(stated, value, kind, text):
    assert UnitNames.of(stated).write(value, kind) == text


def test_a_scene_without_units_takes_no_quantities():
    with pytest.raises(SceneError, match=r"punch\.radius.*units = 'SI'"):
        Scene.from_table(WRITTEN | {"units": "1"})


@pytest.mark.parametrize(
    ("value", "kind", "text"),
    [
        (1.234e-5, "displacement", "12.34 µm"),
        (3e5, "pressure", "300 kPa"),
        (1e6, "time", "11.57 days"),
        (86400.0, "time", "24 h"),
        (108000.0, "time", "30 h"),
        (1080.0, "time", "18 min"),
        (2.5e-8, "displacement", "25 nm"),
        (1e-9, "volume", "1 mm³"),
        (7e-14, "wear_rate", "2.209 µm/year"),
        (2e-15, "wear_coefficient", "2e-06 mm³/(N m)"),
        (0.5, "slope", "0.5"),
        (np.inf, "pressure", "infinite"),
        (np.nan, "time", "not computed"),
        (0.0, "length", "0 m"),
        (0.0, "time", "0 s"),
        (1e-20, "length", "1e-20 m"),
    ],
)
def test_numbers_in_si_are_written_in_convenient_units(value, kind, text):
    assert UnitNames.of("SI").write(value, kind) == text


@pytest.mark.parametrize(
    ("values", "kind", "texts"),
    [
        ([37116.0, 89165.0], "time", ["10.31 h", "24.77 h"]),
        ([60.0, 3600.0, 5400.0], "time", ["1 min", "60 min", "90 min"]),
        ([86400.0, 172800.0], "time", ["24 h", "48 h"]),
        ([1e-9, 1e-3], "displacement", ["0.001 µm", "1000 µm"]),
        ([0.0, 5e-6], "displacement", ["0 µm", "5 µm"]),
        ([0.0, 0.0], "time", ["0 s", "0 s"]),
        ([np.nan, 120.0, np.inf], "time", ["not computed", "2 min", "infinite"]),
    ],
)
def test_numbers_of_one_kind_are_written_in_one_unit(values, kind, texts):
    assert UnitNames.of("SI").write_together(values, kind) == texts


class Stroke(Section):
    """Section with keys of several kinds."""

    length: Annotated[Positive, Unit("length")] | None = None
    speeds: Annotated[list[Positive], Unit("wear_rate")] | None = None
    pull: Annotated[Positive | OverTime, Unit("force")] | None = None
    count: Positive | None = None


class PunchWithStroke(PunchSection):
    """Punch with a new key and a new table, declared as in CONTRIBUTING.md."""

    travel: Annotated[Positive, Unit("length")]
    stroke: Stroke = Stroke()


class SceneWithStroke(Scene):
    """Scene of such a punch."""

    punch: PunchWithStroke


@pytest.mark.parametrize(("units", "metre"), [("SI", 1.0), ("mm, N, MPa, s", 1e3)])
def test_a_new_key_converts_by_its_declared_unit(units, metre):
    pull = {"times": ["0 s", "2 min"], "values": ["1 N", "2 kN"]}
    stroke = {"length": "3 cm", "speeds": ["60 mm/min", "1 m/s"], "pull": pull, "count": 7.0}
    punch = WRITTEN["punch"] | {"travel": "5 mm", "stroke": stroke}
    read = SceneWithStroke(**WRITTEN | {"units": units, "punch": punch}).punch
    assert read.travel == pytest.approx(5e-3 * metre, rel=1e-14)
    assert read.stroke.length == pytest.approx(3e-2 * metre, rel=1e-14)
    assert read.stroke.speeds == pytest.approx([1e-3 * metre, metre], rel=1e-14)
    assert (read.stroke.pull.times, read.stroke.pull.values) == ([0, 120], [1, 2000])
    assert read.radius == pytest.approx(0.02 * metre, rel=1e-14)


def test_a_new_key_refuses_wrong_units_and_a_plain_key_refuses_all_units():
    punch = WRITTEN["punch"] | {"travel": "5 N"}
    with pytest.raises(SceneError, match=r"punch\.travel = '5 N'.*unit of length"):
        SceneWithStroke(**WRITTEN | {"punch": punch})
    punch = WRITTEN["punch"] | {"travel": 1.0, "stroke": {"count": "7 mm"}}
    with pytest.raises(SceneError, match=r"punch\.stroke\.count = '7 mm'"):
        SceneWithStroke(**WRITTEN | {"punch": punch})
    # the original Scene has no such key
    assert kind_of("punch.travel", SceneWithStroke) == "length"
    assert kind_of("punch.travel", Scene) == "number"


def test_contradictory_or_unknown_units_are_errors_of_the_declaration():
    class Twice(Section):
        reach: Annotated[Positive, Unit("length")] | Annotated[OverTime, Unit("time")]

    class Unknown(Section):
        reach: Annotated[Positive, Unit("lenght")]

    for table, message in ((Twice, "two kinds"), (Unknown, "no unit is of the kind 'lenght'")):
        with pytest.raises(TypeError, match=message):
            without_quantities({"reach": "1 m"}, table)


def test_verdicts_write_times_with_their_unit():
    scene = Scene.load("washer")
    units = UnitNames.of(scene.units)
    selected = np.array(scene.wear.times) <= 3600
    words = when_in_words(scene.problem, units, "indentation", selected)
    assert words == "up to t = 1 h"
    early = tuple(np.array(scene.wear.times)[selected])
    left_out = [
        LeftOut("pressure", early, "a reason", "while it is early"),
        LeftOut("rms_slope", early, "a reason", "while it is early"),
    ]
    expected = "Undecided while it is early, until t = 1 h: pressure, RMS slope."
    assert in_words(left_out, scene.wear.times, units) == expected
    left_out += [LeftOut("profile", early[:1], "a reason", "while it is early")]
    left_out += [LeftOut("steady_rms_slope", (), "another", "where it is steep")]
    expected = (
        "Undecided while it is early: pressure, RMS slope until t = 1 h; profile at t = 0 s. "
        "Undecided where it is steep: steady RMS slope."
    )
    assert in_words(left_out, scene.wear.times, units) == expected
