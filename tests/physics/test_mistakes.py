"""Mistakes in the input of other programs, or in their tables, are named first by the diagnosis.

The programs themselves have errors of one to ten per cent (`tests/programs.py`). Twice twenty files
have random mistakes: punches, half-spaces, loads, programs and the sizes of mistakes are drawn. In
each twenty, each kind of mistake occurs once, and two files have two. Both seeds were fixed before
their files were made; the second twenty were made only after the table of mistakes had been
written. Twelve files have mistakes that the diagnosis does not know.
"""

import math
from functools import cache

import numpy as np
import pandas as pd
import pytest
from programs import finite_elements, input_of, of_tamaas, ours, springs

from ringwear import Scene, check
from ringwear.studies.estimate.diagnose import EXPLAINS

SEEDS = 20261127, 20261128
LENGTHS = ("displacement", "profile", "indentation")
LEAST_RIGHT, MOST_EXPLAINED_WRONGLY = 19, 1
MM = {"units": "mm, N, MPa, s", "methods": ["mdr"]}
FIVE = Scene.load("five_rings").changed(
    methods=["mdr"], wear__times=[0.0, 0.02, 0.1, 0.3, 0.6, 1.0, 2.0], accuracy__rtol=1e-3
)
THREE = Scene(
    **MM,
    punch={"radius": 8.0, "ring_edges": [3.0, 5.0, 8.0], "wear_coefficients": [4e-7, 1e-7]},
    half_space={"youngs_modulus": 500.0, "poisson_ratio": 0.4},
    load={"normal_force": 300.0, "sliding_speed": 50.0},
    wear={"times": [0.0, 40.0, 200.0, 600.0, 1500.0]},
)
TAMAAS = Scene(
    **MM,
    punch={"radius": 1.0, "ring_edges": [0.3, 0.7, 1.0], "wear_coefficients": [1.0, 0.3, 1.0]},
    half_space={"plane_strain_modulus": 1.0},
    load={"normal_force": 1.0, "sliding_speed": 1.0},
    wear={"times": [0.0, 0.05, 0.2, 0.5, 1.0, 2.0]},
)


def between(random, low, high):
    """Return a number whose logarithm is uniformly distributed."""
    return float(f"{math.exp(random.uniform(math.log(low), math.log(high))):.3g}")


def random_scene(random):
    """Return a flat punch of rings of two materials, and times around its running-in."""
    radius, count = between(random, 0.2, 30.0), int(random.integers(2, 5))
    widths = random.uniform(0.6, 1.4, count)
    edges = [float(f"{each:.4g}") for each in radius * np.cumsum(widths) / widths.sum()]
    modulus, ratio = between(random, 100.0, 5000.0), round(float(random.uniform(0.25, 0.45)), 2)
    force = between(random, 1e-3, 1e-2) * modulus * radius**2
    speed, first = between(random, 1.0, 100.0), between(random, 1e-8, 1e-5)
    contrast = between(random, 2.0, 8.0) ** int(random.choice([-1, 1]))
    depth = force * (1 - ratio**2) / (2 * radius * modulus)
    time = depth / (first * math.sqrt(contrast) * speed * force / (math.pi * radius**2))
    return Scene(
        **MM,
        punch={
            "ring_edges": edges,
            "radius": edges[-1],
            "wear_coefficients": [first, first * contrast],
        },
        half_space={"youngs_modulus": modulus, "poisson_ratio": ratio},
        load={"normal_force": force, "sliding_speed": speed},
        wear={"times": [float(f"{time * each:.3g}") for each in (0, 0.05, 0.2, 0.6, 1.5, 4.0)]},
    )


def factor(random, low=1.4, high=4.0):
    """Return a factor, above or below 1."""
    return between(random, low, high) ** int(random.choice([-1, 1]))


def scaled(**columns):
    """Return a change of a table: some of its columns are multiplied."""
    return lambda table: table.assign(**{key: table[key] * size for key, size in columns.items()})


def typed(**values):
    """Return a change of the input of a program: some of its values are others."""
    return lambda given: given.changed(**values)


def multiplied(**factors):
    """Return a change of the input of a program: some of its numbers are multiplied."""

    def change(given):
        return given.changed(
            **{key: np.multiply(getattr(given, key), size) for key, size in factors.items()}
        )

    return change


def one_material(size, number):
    """Return a change of the input: the wear coefficients of every second ring are multiplied."""

    def change(given):
        rings = np.arange(len(given.wear)) % 2
        return multiplied(wear=np.where(rings == number, size, 1.0))(given)

    return change


def exchanged(given):
    """Return the input with the two wear coefficients exchanged."""
    return given.changed(wear=[given.wear[1 - place % 2] for place in range(len(given.wear))])


def moved(size):
    """Return a change of the input: all edges but the rim are multiplied."""
    return lambda given: given.changed(edges=[*np.multiply(given.edges[:-1], size), given.radius])


def per_length(given):
    """Return the input in plane strain, with the force over the diameter."""
    return given.changed(plane=True, force=given.force / (2 * given.radius))


def late(part):
    """Return a change of a table: its times are later by a part of the last one."""
    return lambda table: table.assign(time=table.time + part * table.time.max())


# each kind of mistake by its name, and what draws a change of the input, or of the table
INPUTS = {
    "wear coefficient": lambda random: multiplied(wear=factor(random)),
    "normal force": lambda random: multiplied(force=factor(random)),
    "force per length": lambda _: multiplied(force=0.5 / math.pi),
    "modulus": lambda random: multiplied(youngs=factor(random)),
    "Poisson's ratio": lambda _: typed(ratio=0.0),
    "radius for diameter": lambda _: multiplied(radius=2, edges=2),
    "truncated half-space": lambda random: typed(reach=between(random, 5.0, 12.0)),
    "plane strain": lambda _: per_length,
    "layer": lambda random: typed(layer=(between(random, 0.15, 0.5), factor(random, 3.0, 10.0))),
    "swapped materials": lambda _: exchanged,
    "wear ratio": lambda random: one_material(factor(random, 2.0, 4.0), int(random.integers(2))),
    "ring edges": lambda random: moved(factor(random, 1.06, 1.12)),
}
TABLES = {
    "sign": lambda random: scaled(**{str(random.choice(["pressure", "displacement"])): -1.0}),
    "units": lambda random: scaled(**dict.fromkeys(LENGTHS, float(random.choice([1e-3, 1e3])))),
    "units of time": lambda random: scaled(time=float(random.choice([1 / 60, 1 / 3600]))),
    "late start": lambda random: late(between(random, 0.03, 0.2)),
    "constant factor": lambda random: scaled(pressure=factor(random, 1.2, 3.0)),
    "units of radii": lambda _: scaled(radius=2.0),
}
NEEDS_ELEMENTS = {"truncated half-space", "plane strain", "layer"}
PAIRS = [("wear coefficient", "sign"), ("normal force", "units")]
# other names by which a kind is right: a force that is given wrongly is a wrong force
NAMES = {
    "sign": {"sign of the pressure", "sign of the displacement"},
    "normal force": {"normal force", "force per length"},
}


@cache
def files(seed):
    """Return the scene, the program, the changes and the right names of each file, by its kind."""
    random, made = np.random.default_rng(seed), {}
    for kinds in [*((each,) for each in (*INPUTS, *TABLES)), *PAIRS]:
        scene = random_scene(random)
        elements = bool(NEEDS_ELEMENTS & {*kinds}) or random.uniform() < 0.3
        inputs = [INPUTS[kind](random) for kind in kinds if kind in INPUTS]
        tables = [TABLES[kind](random) for kind in kinds if kind in TABLES]
        names = set().union(*(NAMES.get(kind, {kind}) for kind in kinds))
        program = finite_elements if elements else springs
        made[" and ".join(kinds)] = scene, program, inputs, tables, names
    return made


@cache
def look(seed, kind):
    """Return the diagnosis of a file, and the right names.

    No other mistake is said to explain the difference; springs do have a coarse rim.
    """
    scene, program, inputs, tables, names = files(seed)[kind]
    given = input_of(scene)
    for change in inputs:
        given = change(given)
    table = program(given)
    for change in tables:
        table = change(table)
    found = check(scene, table).mistakes()
    explain = {each.name for each in found if each.judgement == EXPLAINS}
    assert explain <= names | {"coarse rim"}, kind
    return found, names


@pytest.mark.slow
@pytest.mark.parametrize(
    "kind",
    [
        *("wear coefficient", "truncated half-space", "sign", "units", "plane strain"),
        *("force per length", "layer", "radius for diameter", "ring edges"),
        "wear coefficient and sign",
    ],
)
def test_the_right_mistake_is_first(kind):
    found, names = look(SEEDS[0], kind)
    assert found[0].name in names


@pytest.mark.nightly
@pytest.mark.parametrize("seed", SEEDS)
def test_the_right_mistake_is_first_in_nineteen_of_twenty_random_files(seed):
    right, wrong = [], {}
    for kind in files(seed):
        found, names = look(seed, kind)
        if found[0].name in names:
            right.append(kind)
        else:
            wrong[kind] = [(each.name, each.judgement) for each in found]
    assert len(files(seed)) == 20
    assert len(right) >= LEAST_RIGHT, wrong


def by_law(law):
    """Return a function that makes the table of springs whose wear rate follows another law."""
    return lambda: springs(input_of(FIVE).changed(law=law))


def loaded(load):
    """Return a function that makes our table of the scene under another load."""
    return lambda: ours(FIVE, wear__steady=False, load=load)


def changed(change):
    """Return a function that makes the right table of springs, and changes it."""
    return lambda: change(springs(input_of(FIVE)))


def less_than_rim(table):
    rim = table.groupby("time").displacement.transform("last")
    return table.assign(displacement=table.displacement - rim)


def less_mean(table):
    mean = table.groupby("time")["profile"].transform("mean")
    return table.assign(profile=table["profile"] - mean)


def one_time_late(table):
    late = table.groupby("radius").pressure.shift(1)
    return table.assign(pressure=late.fillna(table.pressure))


def shifted(table):
    radii = np.minimum(table.radius + 0.06, 0.999)
    return table.assign(radius=radii).groupby(["time", "radius"], as_index=False).first()


def noisy(table):
    random = np.random.default_rng(SEEDS[0])
    fields = ("pressure", "displacement", "profile")
    return table.assign(
        **{key: table[key] * (1 + 0.1 * random.normal(size=len(table))) for key in fields}
    )


def exchanged_columns(table):
    return table.rename(columns={"profile": "displacement", "displacement": "profile"})


FASTER = {"times": [0.0, 0.3, 0.300001, 2.0], "values": [1.0, 1.0, 2.0, 2.0]}
UNKNOWN = {
    "k goes as p^0.5": by_law(lambda p, _t, _r: np.sign(p) * np.abs(p) ** 1.5),
    "k goes as p^-0.3": by_law(lambda p, _t, _r: np.sign(p) * np.abs(p) ** 0.7),
    "k doubles in time": by_law(lambda p, t, _r: p * (1 + t)),
    "k rises with the radius": by_law(lambda p, _t, r: p * (0.7 + 0.6 * r)),
    "displacement less that of the rim": changed(less_than_rim),
    "profile less its mean": changed(less_mean),
    "pressure of one time too late": changed(one_time_late),
    "radii shifted by .06": changed(shifted),
    "noise of ten per cent": changed(noisy),
    "profile and displacement exchanged": changed(exchanged_columns),
    "speed doubles at t = .3": loaded({"normal_force": 2.0, "sliding_speed": FASTER}),
    "force rises over .5": loaded(
        {"normal_force": {"times": [0.0, 0.5], "values": [1.0, 2.0]}, "sliding_speed": 1.0}
    ),
}


@pytest.mark.nightly
def test_at_most_one_unknown_mistake_is_explained_wrongly():
    explained = {}
    for name, make in UNKNOWN.items():
        found = check(FIVE, make()).mistakes()
        if wrong := [each.name for each in found if each.judgement == EXPLAINS]:
            explained[name] = wrong
    assert len(UNKNOWN) == 12
    assert len(explained) <= MOST_EXPLAINED_WRONGLY, explained


@pytest.mark.slow
def test_causes_with_the_same_pressures_explain_them_equally_well():
    """k and E* both scale the time; only lengths, which are not given, distinguish them."""
    table = springs(multiplied(wear=1.1)(input_of(FIVE)))[["time", "radius", "pressure"]]
    first, second = check(FIVE, table).mistakes()
    assert {first.name, second.name} == {"wear coefficient", "Poisson's ratio"}
    assert first.share + second.share == pytest.approx(1, abs=0.1)
    assert first.share < 0.7
    assert "explain the difference equally well" in first.words


@pytest.mark.slow
@pytest.mark.parametrize("program", ["springs", "finite elements", "tamaas"])
def test_no_cause_is_sure_for_programs_without_a_mistake(program):
    """Faults of the mesh may be named, because the finite elements do have them."""
    scene, table = {
        "springs": (FIVE, lambda: springs(input_of(FIVE))),
        "finite elements": (THREE, lambda: finite_elements(input_of(THREE))),
        "tamaas": (TAMAAS, lambda: of_tamaas("tamaas_three")),
    }[program]
    mesh = {"coarse rim", "checkerboard"}
    assert all(one.share <= 0.7 for one in check(scene, table()).mistakes() if one.name not in mesh)


@pytest.mark.slow
def test_metres_for_millimetres_are_named_in_a_table_of_tamaas():
    table = scaled(**dict.fromkeys(LENGTHS, 1e-3))(of_tamaas("tamaas_three"))
    first, *others = check(TAMAAS, table).mistakes()
    assert first.name == "units"
    assert all(other.share <= 0.7 for other in others)


def test_one_number_has_several_unsure_causes():
    """A clamped box is named first, and the others with it."""
    first, *others = check(FIVE, pd.DataFrame({"time": [0.0], "indentation": [0.95]})).mistakes()
    assert (first.name, first.size) == (
        "truncated half-space",
        pytest.approx(1.09 / 0.05, rel=1e-2),
    )
    assert first.share < 0.5
    assert "explain the difference equally well" in first.words
    assert others
