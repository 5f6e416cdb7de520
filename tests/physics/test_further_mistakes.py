"""Twice twenty files with random mistakes, and twelve whose mistakes the diagnosis does not know.

Punches, half-spaces, loads, programs and the sizes of mistakes are drawn. In each twenty, each kind
of mistake occurs once, and two files have two. Both seeds were fixed before their files were made;
the second twenty were made only after the table of mistakes had been written.
"""

import math
from functools import cache

import numpy as np
import pytest
from checks import mistakes
from programs import finite_elements, input_of, ours, springs

from ringwear import Scene, check
from ringwear.studies.estimate.diagnose import EXPLAINS

pytestmark = pytest.mark.nightly

SEEDS = 20261127, 20261128
LENGTHS = ("displacement", "profile", "indentation")
LEAST_RIGHT, MOST_EXPLAINED_WRONGLY = 19, 1


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
        units="mm, N, MPa, s",
        methods=["mdr"],
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


def typed(**changes):
    """Return a change of the input of a program; values are functions of the right input."""
    return lambda given: given.changed(**{key: of(given) for key, of in changes.items()})


def times(size, *rings):
    """Return a function that multiplies the wear coefficients of all, or of some, rings."""
    return lambda given: tuple(
        value * (size if not rings or place % 2 in rings else 1.0)
        for place, value in enumerate(given.wear)
    )


def exchanged(given):
    """Return wear coefficients of which the two values are exchanged."""
    return tuple(given.wear[1 - place % 2] for place in range(len(given.wear)))


def moved(size):
    """Return a function that multiplies all edges of an input but the rim."""
    return lambda given: (*(edge * size for edge in given.edges[:-1]), given.edges[-1])


def twice(given):
    return tuple(2 * edge for edge in given.edges)


# each kind of mistake: its names; and what draws a change of the input, or of the table
INPUTS = {
    "wear coefficient": lambda random: typed(wear=times(factor(random))),
    "normal force": lambda random: (lambda f: typed(force=lambda given: f * given.force))(
        factor(random)
    ),
    "force per length": lambda _: typed(force=lambda given: given.force / (2 * math.pi)),
    "modulus": lambda random: (lambda f: typed(youngs=lambda given: f * given.youngs))(
        factor(random)
    ),
    "Poisson's ratio": lambda _: typed(ratio=lambda _: 0.0),
    "radius for diameter": lambda _: typed(radius=lambda given: 2 * given.radius, edges=twice),
    "truncated half-space": lambda random: (lambda reach: typed(reach=lambda _: reach))(
        between(random, 5.0, 12.0)
    ),
    "plane strain": lambda _: typed(
        plane=lambda _: True, force=lambda given: given.force / (2 * given.radius)
    ),
    "layer": lambda random: (lambda layer: typed(layer=lambda _: layer))(
        (between(random, 0.15, 0.5), factor(random, 3.0, 10.0))
    ),
    "swapped materials": lambda _: typed(wear=exchanged),
    "wear ratio": lambda random: typed(
        wear=times(factor(random, 2.0, 4.0), int(random.integers(2)))
    ),
    "ring edges": lambda random: typed(edges=moved(factor(random, 1.06, 1.12))),
}
TABLES = {
    "sign": lambda random: scaled(**{str(random.choice(["pressure", "displacement"])): -1.0}),
    "units": lambda random: scaled(**dict.fromkeys(LENGTHS, float(random.choice([1e-3, 1e3])))),
    "units of time": lambda random: scaled(time=float(random.choice([1 / 60, 1 / 3600]))),
    "late start": lambda random: (
        lambda part: lambda table: table.assign(time=table.time + part * table.time.max())
    )(between(random, 0.03, 0.2)),
    "constant factor": lambda random: scaled(pressure=factor(random, 1.2, 3.0)),
    "units of radii": lambda _: scaled(radius=2.0),
}
NEEDS_ELEMENTS = {"truncated half-space", "plane strain", "layer"}
PAIRS = [("wear coefficient", "sign"), ("normal force", "units")]


def names_of(kind):
    """Return the names by which a kind of mistake is right."""
    if kind == "sign":
        return {"sign of the pressure", "sign of the displacement"}
    # a force that is given wrongly is a wrong force
    return {"normal force", "force per length"} if kind == "normal force" else {kind}


@cache
def files(seed):
    """Return each file: its scene, its table, and the right names."""
    random, made = np.random.default_rng(seed), {}
    for kinds in [*((each,) for each in (*INPUTS, *TABLES)), *PAIRS]:
        scene = random_scene(random)
        elements = bool(NEEDS_ELEMENTS & {*kinds}) or random.uniform() < 0.3
        given = input_of(scene)
        changes = [
            INPUTS[kind](random) if kind in INPUTS else TABLES[kind](random) for kind in kinds
        ]
        for kind, change in zip(kinds, changes, strict=True):
            given = change(given) if kind in INPUTS else given
        table = (finite_elements if elements else springs)(given)
        for kind, change in zip(kinds, changes, strict=True):
            table = table if kind in INPUTS else change(table)
        made[" and ".join(kinds)] = scene, table, set().union(*map(names_of, kinds))
    return made


@pytest.mark.parametrize("seed", SEEDS)
def test_the_right_mistake_is_first_in_nineteen_of_twenty_random_files(seed):
    """No other mistake is said to explain the difference; springs do have a coarse rim."""
    right, wrong = [], {}
    for name, (scene, table, names) in files(seed).items():
        found = mistakes(check(scene, table))
        if found[0].name in names:
            right.append(name)
        else:
            wrong[name] = [(each.name, each.judgement) for each in found]
        explain = {each.name for each in found if each.judgement == EXPLAINS}
        assert explain <= names | {"coarse rim"}, name
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


FIVE = Scene.load("five_rings").changed(
    methods=["mdr"], wear__times=[0.0, 0.02, 0.1, 0.3, 0.6, 1.0, 2.0], accuracy__rtol=1e-3
)
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


def test_at_most_one_unknown_mistake_is_explained_wrongly():
    explained = {}
    for name, make in UNKNOWN.items():
        found = mistakes(check(FIVE, make()))
        if wrong := [each.name for each in found if each.judgement == EXPLAINS]:
            explained[name] = wrong
    assert len(UNKNOWN) == 12
    assert len(explained) <= MOST_EXPLAINED_WRONGLY, explained
