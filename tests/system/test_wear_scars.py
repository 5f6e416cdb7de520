"""Fits to wear scars, and to data over sliding distances or cycles in place of times."""

import numpy as np
import pandas as pd
import pytest

import ringwear
from ringwear import Scene, SceneError

WEAR = "punch.wear_coefficient"
BALL = Scene(
    units="mm, N, MPa, s",
    methods=["mdr"],
    punch={
        "radius": 3.0,
        "profile": {"kind": "ball", "ball_radius": 5.0},
        "wear_coefficient": "1e-5 mm^3/(N m)",
    },
    half_space={"youngs_modulus": "200 GPa", "poisson_ratio": 0.3},
    load={"normal_force": 10.0, "sliding_speed": "0.1 m/s"},
)
FLAT = Scene.load("flat_punch")


def by_geometry(diameter, force=10.0, ball_radius=5.0, modulus=200e3 / 0.91):
    """Return the worn volume of a ball whose pressure is uniform.

    It is that of the cap, less that of the elastic indentation: ``4 F a / (3 pi E*)``, by the mean
    ``16 p a / (3 pi E*)`` and the value at the edge ``4 p a / (pi E*)`` of the displacements under
    a uniform pressure (Johnson, Contact Mechanics, 3.4).
    """
    a = diameter / 2
    height = ball_radius - np.sqrt(ball_radius**2 - a**2)
    cap = np.pi * height / 6 * (3 * a**2 + height**2)
    return cap - 4 * force * a / (3 * np.pi * modulus)


@pytest.mark.slow
@pytest.mark.parametrize("diameter", [0.6, 2.0])
def test_a_scar_has_the_wear_coefficient_of_its_volume(diameter):
    data = {"distance [m]": [1000.0], "scar_diameter [mm]": [diameter]}
    found = ringwear.fit(BALL, data, WEAR, noise="0.5 %")
    expected = by_geometry(diameter) / (10.0 * 1e6)
    assert found.estimates.value[WEAR] == pytest.approx(expected, rel=5e-3)
    # dV / V is nearly 4 da / a
    row = found.estimates.loc[WEAR]
    assert np.log(row.high / row.low) == pytest.approx(8 * 1.96 * 5e-3, rel=0.05)
    # nothing is left to test the law of wear with
    assert not found.tests


@pytest.mark.slow
def test_distances_and_cycles_are_times_by_the_speed_of_the_scene():
    """At 0.1 m/s, 100 s are 10 m, or 500 cycles of 20 mm; radii are halves of diameters.

    Without a speed, times are distances.
    """
    times, diameters = np.array([100.0, 1000.0, 1e4]), np.array([0.7, 1.2, 2.1])
    tables = [
        ({"time": times, "scar_diameter": diameters}, {}),
        ({"time [min]": times / 60, "contact_radius [um]": 500 * diameters}, {}),
        ({"distance": 100 * times, "scar_diameter": diameters}, {}),
        ({"distance [km]": times * 1e-4, "scar_diameter": diameters}, {}),
        ({"distance": 0.1 * times, "scar_diameter": 1e-3 * diameters}, {"units": "SI"}),
        ({"cycles": 5 * times, "scar_diameter": diameters}, {"cycle": "20 mm"}),
        ({"N": 5 * times, "d": diameters}, {"cycle": 20.0, "columns": {"N": "cycles"}}),
    ]
    tables[-1][1]["columns"] |= {"d": "scar_diameter"}
    values = [ringwear.fit(BALL, table, WEAR, "5 %", **how).estimates for table, how in tables]
    without_speed = BALL.table()
    del without_speed["load"]["sliding_speed"]
    values.append(ringwear.fit(without_speed, tables[2][0], WEAR, "5 %").estimates)
    for each in values:
        assert each.value[WEAR] == pytest.approx(values[0].value[WEAR], rel=1e-6)


def test_distances_of_a_speed_that_varies():
    """The speed rises to 2 until t = 1, the punch rests from 2 to 3, and slides on at 1."""
    speed = {"times": [0.0, 1.0, 2.0, 2.1, 3.0, 3.1], "values": [0.0, 2.0, 2.0, 0.0, 0.0, 1.0]}
    scene = FLAT.changed(load__sliding_speed=speed, wear__times=[5.0])
    loading, unit = scene.problem.loading, scene.problem.units.time
    times = np.array([0.0, 0.3, 1.0, 1.5, 2.05, 2.1, 3.05, 4.0])
    distances = loading.at(times / unit).distance
    assert 2.0 * unit * distances == pytest.approx([0, 0.09, 1, 2, 3.075, 3.1, 3.1125, 4.05])
    assert loading.times_at(distances) * unit == pytest.approx(times)
    stopped = FLAT.changed(
        load__sliding_speed={"times": [0.0, 1.0], "values": [1.0, 0.0]}, wear__times=[5.0]
    ).problem
    reached, missed = stopped.loading.times_at(np.array([0.375, 0.6]) / stopped.units.time)
    assert reached * stopped.units.time == pytest.approx(0.5)
    assert np.isnan(missed)


@pytest.mark.slow
def test_another_program_may_give_distances():
    result = ringwear.run("flat_punch", methods=["mdr"]).dataset
    table = pd.DataFrame(
        {"distance": result.time.values, "indentation": result.indentation.values[0]}
    )
    assert ringwear.check("flat_punch", table).passes


@pytest.mark.parametrize(
    ("scene", "data", "how", "words"),
    [
        (FLAT, {"time": [1.0], "scar_diameter": [2.0]}, {}, "the punch of the scene is flat"),
        (
            BALL,
            {"cycles": [5], "scar_diameter": [2.0]},
            {},
            "one cycle by --cycle, such as '20 mm'",
        ),
        (BALL, {"cycles": [5], "scar_diameter": [2.0]}, {"cycle": 0}, "--cycle = 0: give a number"),
        (
            BALL,
            {"distance": [-5], "scar_diameter": [2.0]},
            {},
            "'distance': -5; give the distance",
        ),
        (
            BALL.changed(load__sliding_speed={"times": [0.0, 1.0], "values": [1.0, 0.0]}),
            {"distance": [2.0], "scar_diameter": [2.0]},
            {},
            "never slides as far as 2",
        ),
        (
            BALL,
            {"distance": [2.0], "scar_diameter": [2.0]},
            {"parameters": "load.sliding_speed"},
            "its values do not depend on the speed",
        ),
    ],
)
def test_what_has_no_meaning_is_refused(scene, data, how, words):
    with pytest.raises(SceneError, match=words):
        ringwear.fit(scene, data, **({"parameters": WEAR, "noise": 0.1} | how))


@pytest.mark.slow
def test_the_command_reads_cycles(command, tmp_path):
    (tmp_path / "scar.csv").write_text("cycles, scar_diameter [um]\n50000, 2080\n", "utf-8")
    flags = f"--parameters {WEAR} --cycle '20 mm' --noise '1 %' --out out"
    printed = command(f"fit scene.toml scar.csv {flags}", scene=BALL).out
    assert f"{WEAR} = 1.86" in printed
