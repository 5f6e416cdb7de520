"""Mistakes in single columns and single inputs are named; errors of our own decks are of the mesh.

Each mistake is made in the input or in the table; what has to be named follows from it.
"""

import numpy as np
import pytest
from groups import nightly, nightly_but
from programs import finite_elements, input_of, ours, springs

from ringwear import Scene, SceneError, check
from ringwear.studies.estimate.compared import Comparison
from ringwear.studies.estimate.diagnose import diagnose

MESH = {"coarse rim", "coarse mesh", "checkerboard"}
QUICK = {"methods": ["mdr"], "accuracy": {"rtol": 1e-3}}
MM = {"units": "mm, N, MPa, s"} | QUICK
FLAT = Scene(
    **MM,
    punch={"radius": 8.0, "rings": 4, "wear_coefficients": [1e-6, 5e-6]},
    half_space={"youngs_modulus": 800.0, "poisson_ratio": 0.3},
    load={"normal_force": 300.0, "sliding_speed": 20.0},
    wear={"times": [0.0, 5.0, 20.0, 100.0, 300.0, 800.0], "steady": False},
)
THREE = FLAT.changed(
    punch={
        "radius": 8.0,
        "ring_edges": [2.0, 5.0, 8.0],
        "wear_coefficients": [1e-6, 4e-6, 2e-6],
    }
)
UPPER = {"thickness": 1.0, "youngs_modulus": 500.0, "poisson_ratio": 0.4}
LOWER = {"thickness": 2.0, "youngs_modulus": 4000.0, "poisson_ratio": 0.3}
LAYERS = FLAT.changed(
    punch={"radius": 5.0, "rings": 3, "wear_coefficients": [1e-6, 4e-6]},
    half_space={"youngs_modulus": 2000.0, "poisson_ratio": 0.3, "layers": [UPPER, LOWER]},
    load={"normal_force": 200.0, "sliding_speed": 20.0},
    wear__times=[0.0, 1.0, 5.0, 20.0, 60.0, 150.0],
)
BALL = Scene(
    **MM,
    punch={
        "radius": 2.0,
        "profile": {"kind": "ball", "ball_radius": 30.0},
        "wear_coefficient": 1e-6,
    },
    half_space={"youngs_modulus": 5000.0, "poisson_ratio": 0.3},
    load={"normal_force": 40.0, "sliding_speed": 10.0},
    wear={"times": [0.0, 5.0, 30.0, 120.0], "steady": False},
)


def looks(scene, table, **how):
    return check(scene, {"theirs": table}, **how).mistakes("theirs")


def in_other_units(column, factor):
    table = springs(input_of(FLAT))
    return looks(FLAT, table.assign(**{column: table[column] * factor}))


@pytest.mark.slow
@pytest.mark.parametrize(
    ("column", "factor"),
    [
        ("indentation", 1e3),
        *nightly(("displacement", 1e3), ("profile", 1e6), ("pressure", 1e-3)),
    ],
)
def test_a_single_column_in_other_units_is_named_with_its_factor(column, factor):
    first, *others = in_other_units(column, factor)
    assert (first.name, first.size) == ("units", pytest.approx(factor))
    assert f"the column {column} is {factor:.4g} times ours" in first.words
    assert all(other.share <= 0.7 or other.name in MESH for other in others)


@pytest.mark.slow
@pytest.mark.parametrize("factor", [60.0, *nightly(1e3)])
def test_a_column_of_times_in_other_units_cannot_be_told_from_a_wear_coefficient(factor):
    """Results depend on the time only as k v t, so that neither may be sure."""
    found = in_other_units("time", factor)
    assert [fault.name for fault in found] == ["units of time", "wear coefficient"]
    assert all(fault.share <= 0.7 for fault in found)
    assert [fault.size for fault in found] == pytest.approx([1 / factor] * 2, rel=0.01)
    assert f"the column time is {factor:.4g} times ours" in found[0].words


@pytest.mark.slow
def test_a_column_of_radii_in_other_units_is_named():
    first, *others = in_other_units("radius", 1e-3)
    assert (first.name, first.size) == ("units of radii", pytest.approx(1e3))
    assert "the column radius is 0.001 times ours" in first.words
    assert all(other.share <= 0.7 for other in others)
    with pytest.raises(SceneError, match="the column radius seems to be 1000 times ours"):
        in_other_units("radius", 1e3)


def other(layer, **changes):
    """Return a layer with changes."""
    return layer | changes


WRONG = {
    "k2 = 10 for 5": (FLAT, {"punch__wear_coefficients": [1e-6, 1e-5]}, "wear ratio", 2.0),
    "edges 5 % in": (THREE, {"punch__ring_edges": [1.9, 4.75, 8.0]}, "ring edges", 0.95),
    "two of three swapped": (
        THREE,
        {"punch__wear_coefficients": [1e-6, 2e-6, 4e-6]},
        "swapped materials",
        1.0,
    ),
    "nu of the layer": (
        LAYERS,
        {"half_space__layers": [other(UPPER, poisson_ratio=0.0), LOWER]},
        "Poisson's ratio of a layer",
        0.0,
    ),
    "modulus of the layer": (
        LAYERS,
        {"half_space__layers": [UPPER, other(LOWER, youngs_modulus=8000.0)]},
        "modulus of a layer",
        2.0,
    ),
    "thickness of the layer": (
        LAYERS,
        {"half_space__layers": [other(UPPER, thickness=1.5), LOWER]},
        "thickness of a layer",
        1.5,
    ),
    "swapped moduli": (
        LAYERS,
        {
            "half_space__layers": [
                other(UPPER, youngs_modulus=4000.0),
                other(LOWER, youngs_modulus=500.0),
            ]
        },
        "swapped layers",
        1.0,
    ),
    "load of a ball": (BALL, {"load__normal_force": 56.0}, "normal force", 1.4),
}
QUICK = {"two of three swapped"}


@pytest.mark.parametrize("name", nightly_but(QUICK, WRONG))
def test_a_single_wrong_input_is_named_and_no_other_is_sure(name):
    scene, changes, cause, size = WRONG[name]
    first, *others = looks(scene, ours(scene, **changes))
    assert (first.name, first.size) == (cause, pytest.approx(size, rel=0.05))
    assert first.share > 0.7
    assert all(other.share <= 0.7 for other in others)


def flat_start(error):
    """Return a comparison of F and p at the start that are too large by an error, as in a deck."""
    scene = Scene.load("flat_punch").changed(methods=["mdr"], wear__times=[0.0])
    radius, force = scene.punch.radius, scene.load_.normal_force
    radii = np.linspace(0.0, 0.9, 10) * radius
    pressure = force / (2 * np.pi * radius * np.sqrt(radius**2 - radii**2))
    right = {"pressure": pressure[None], "normal_force": np.array([force])}
    wrong = {name: values * (1 + error) for name, values in right.items()}
    return Comparison(np.zeros(1), radii, wrong, right, scene)


@pytest.mark.parametrize(("reach", "share"), [(20.0, 1.0), (80.0, 0.25)])
def test_the_error_of_a_deck_is_shared_by_its_arc_and_its_mesh(reach, share):
    """With prescribed displacements an arc at 20 a causes 1.09 / 20 (Poisson's ratio 0.3)."""
    found = {fault.name: fault for fault in diagnose(flat_start(1.09 / 20), deck_reach=reach)}
    arc = found["truncated half-space"]
    assert arc.size == reach
    sure = arc.share + (found["coarse mesh"].share if share < 1 else 0)
    assert arc.share / sure == pytest.approx(share, rel=0.05)
    assert all(
        fault.share < 0.3
        for name, fault in found.items()
        if name not in MESH | {"truncated half-space"}
    )


FIVE = Scene.load("five_rings").changed(
    methods=["mdr"], wear__times=[0.0, 0.02, 0.1, 0.3, 0.6, 1.0, 2.0], accuracy__rtol=1e-3
)


def with_ring(number, factor):
    """Return the input of five rings with the wear coefficient of one of them multiplied."""
    given = input_of(FIVE)
    wear = list(given.wear)
    wear[number - 1] *= factor
    return given.changed(wear=tuple(wear))


def wrong_on_ring(table, column, number):
    """Return a table whose column has the wrong sign on one ring."""
    edges = FIVE.problem.ring_edges
    on_ring = (table.radius > edges[number - 1]) & (table.radius < edges[number])
    return table.assign(**{column: table[column].where(~on_ring, -table[column])})


def shifted(table):
    """Return a table whose pressures are each in the row of the next radius."""
    return table.assign(pressure=table.groupby("time").pressure.shift(1)).dropna()


def right(cells=40):
    return finite_elements(input_of(FIVE), cells)


SINGLE = {
    "an own mesh of a/10": (lambda: right(10), "coarse mesh", "a mesh that is too coarse"),
    "k of ring 2 forgotten": (
        lambda: springs(with_ring(2, 1e-4)),
        "forgotten ring",
        "ring 2 that is forgotten",
    ),
    "k of ring 3 30 % too high": (
        lambda: springs(with_ring(3, 1.3)),
        "wear coefficient of a ring",
        "a wear coefficient of ring 3 of 1.3",
    ),
    "pressure shifted": (
        lambda: shifted(right()),
        "shifted column",
        "a column pressure that is shifted outward by one node",
    ),
    "sign of pressure": (
        lambda: wrong_on_ring(right(), "pressure", 2),
        "sign of the pressure",
        "an opposite sign of pressure on ring 2",
    ),
    "sign of wear": (
        lambda: wrong_on_ring(right(), "profile", 4),
        "sign of the profile",
        "an opposite sign of profile on ring 4",
    ),
}


@pytest.mark.slow
@pytest.mark.parametrize("name", nightly_but([*SINGLE][:-1], SINGLE))
def test_a_mesh_a_ring_and_a_column_are_named(name):
    table, cause, words = SINGLE[name]
    first = looks(FIVE, table())[0]
    assert first.name == cause
    assert words in first.words
    assert "explain" in first.words


@pytest.mark.slow
def test_results_that_converge_name_the_mesh_first():
    sizes = (0.2, 0.1, 0.05)
    files = {f"h = {size}": right(round(1 / size)) for size in sizes}
    first = check(FIVE, files, sizes=sizes).mistakes()[0]
    assert first.name == "mesh"
    assert "which decrease with their size" in first.words
