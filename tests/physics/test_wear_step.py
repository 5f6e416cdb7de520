"""The longest stable update of wear, against explicit loops in scikit-fem without ringwear."""

import numpy as np
import pandas as pd
import pytest
from explicit_loops import condensed, march, pressures_of
from groups import nightly, nightly_but

from ringwear import Scene, check, plan, run
from ringwear.meshes import SizeField, as_half_space, bisection, structured
from ringwear.studies.check import sawtooth
from ringwear.studies.wear_step.contact_nodes import (
    PER_NODE,
    TREATMENTS,
)
from ringwear.studies.wear_step.limits import limits_on_mesh
from ringwear.studies.wear_step.models import limit_of_models

FIVE = Scene.load("five_rings")
EDGES = FIVE.problem.merged.ring_edges
REACH, MEAN = 20.0, 2 / np.pi


def wear_of_five_rings(radii):
    """Return k over the greatest at nodes; the harmonic mean at ring edges."""

    def at(places):
        return np.where(np.clip((5 * places).astype(int), 0, 4) % 2, 1.0, 0.1)

    return 2 / (1 / at(radii - 1e-6) + 1 / at(radii + 1e-6))


def mesh_of(shape, element):
    """Return a quarter disc: in rows and columns, graded to ring edges, or in free triangles."""
    if element.startswith("P") and shape != "uniform":
        size, growth = (0.01, 0.5) if shape == "graded" else (0.05, 0.3)
        field = SizeField(
            tuple(EDGES),
            size,
            size,
            growth,
            REACH,
            0.1 if shape == "graded" else 0.05,
            cells=None if shape == "graded" else lambda radii: np.full(len(radii), 0.05),
        )
        return bisection.mesh(field)
    vertices = np.linspace(0, 1, 21)
    if shape == "graded":
        part = np.array([0.0, 0.02, 0.06, 0.15, 0.35, 0.65, 0.85, 0.94, 0.98])
        vertices = np.append((EDGES[:-1, None] + 0.2 * part).ravel(), 1.0)
    mesh = structured.below_nodes(vertices, REACH)
    if element.startswith("P"):
        mesh = structured.in_triangles(mesh)
    return as_half_space(mesh, EDGES)


def greatest_eigenvalue_limit(stiffness, to_pressures, wear):
    """Return 2 Re(l) / |l|^2 for the eigenvalues of the loop under a given force."""
    per_depth = to_pressures @ stiffness
    rigid = stiffness.sum(axis=0)
    relief = per_depth - np.outer(per_depth.sum(axis=1), rigid) / rigid.sum()
    values = np.linalg.eigvals(wear[:, None] * relief)
    values = values[np.abs(values) > 1e-3 * np.abs(values).max()]
    return (2 * values.real / np.abs(values) ** 2).min()


MESHES = [
    (shape, element)
    for shape in ("uniform", "graded", "free")
    for element in ("P1", "P2", "Q1", "Q2", "Q2S")
    if shape != "free" or element.startswith("P")
]


@pytest.mark.parametrize(
    ("shape", "element"),
    nightly_but({("uniform", "P1"), ("graded", "Q2S"), ("free", "P2")}, MESHES),
)
@pytest.mark.parametrize("treatment", TREATMENTS)
def test_the_limit_is_that_of_explicit_loops(shape, element, treatment):
    """A loop is stable at .95 times the limit of this very mesh, and unstable at 1.05 times."""
    mesh = mesh_of(shape, element)
    radii, stiffness = condensed(mesh, element)
    to_pressures = pressures_of(radii, element, treatment != PER_NODE)
    wear = wear_of_five_rings(radii)
    limit = limits_on_mesh(FIVE, mesh, element).limit(treatment)
    exact = greatest_eigenvalue_limit(stiffness, to_pressures, wear)
    # the loop has a clamped boundary, which changes long waves only
    assert limit == pytest.approx(exact, rel=1e-3)
    greatest = {}
    for part in (0.95, 1.05):
        pressures = march(stiffness, to_pressures, wear, 2.0, part * limit, 400)[1]
        greatest[part] = np.abs(pressures[-1]).max() / MEAN
    # the steady pressure is at most 1.6 times the mean
    assert greatest[0.95] < 3
    assert greatest[1.05] > 1e3


def test_plan_gives_the_limit_of_a_mesh():
    mesh = mesh_of("uniform", "Q1")
    radii, stiffness = condensed(mesh, "Q1")
    exact = greatest_eigenvalue_limit(
        stiffness, pressures_of(radii, "Q1", False), wear_of_five_rings(radii)
    )
    (line,) = [line for line in plan(FIVE, mesh=mesh) if line.startswith("stable")]
    # k of the scene is 10 on soft rings, in units of 1 / E*
    assert float(line.split("sliding distance of ")[1].split()[0]) == pytest.approx(
        exact / 10, rel=0.02
    )


def loops(part, count=60):
    """Yield tables of loops in scikit-fem whose steps are too long, clipped at zero pressure."""
    for shape, element in MESHES:
        mesh = mesh_of(shape, element)
        radii, stiffness = condensed(mesh, element)
        wear = wear_of_five_rings(radii)
        for treatment in TREATMENTS:
            to_pressures = pressures_of(radii, element, treatment != PER_NODE)
            limit = greatest_eigenvalue_limit(stiffness, to_pressures, wear)
            marched = march(stiffness, to_pressures, wear, 2.0, part * limit, count, clipped=True)
            yield element, radii, limit, marched[0], marched[1]


@pytest.mark.slow
@pytest.mark.parametrize(("part", "near"), [(1.3, 0.75), *nightly((2.0, 0.6))])
def test_a_sawtooth_is_recognised_with_its_limit(part, near):
    """All are recognised; the limit by a model mesh is within 20 % in most cases."""
    found, within, count = 0, 0, 0
    for element, radii, limit, times, pressures in loops(part):
        count += 1
        if sawtooth.find(times, pressures, MEAN):
            found += 1
            last = times[-sawtooth.LAST_ROWS :], pressures[-sawtooth.LAST_ROWS :]
            told, _ = limit_of_models(FIVE.problem, last[0], radii, last[1], element)
            within += abs(told / limit - 1) < 0.2
    assert count >= 20
    assert found == count
    assert within >= near * count


def test_good_tables_cause_no_false_alarm():
    """Exact pressures with rings and a rim, and one per cent of noise, in 1000 tables."""
    random, alarms = np.random.default_rng(7), 0
    for wear, cells in [([1.0, 1.0], 20), ([1.0, 10.0], 20), ([1.0, 10.0], 100), ([10.0, 1.0], 40)]:
        scene = FIVE.changed(
            {
                "wear.times": (0.02 * np.arange(1, 41)).tolist(),
                "output.radii": np.linspace(0, 1, cells + 1).tolist(),
                "punch.wear_coefficients": wear,
            }
        )
        pressures = run(scene, ["mdr"], quantities=["pressure"]).dataset["pressure"].values[0]
        assert np.isfinite(pressures).all()
        for _ in range(250):
            noisy = pressures + 0.01 * MEAN * random.standard_normal(pressures.shape)
            alarms += sawtooth.find(np.array(scene.wear.times), noisy, MEAN) is not None
    assert alarms == 0


def table_of(radii, times, pressures, depths):
    """Return a table as users write it; ring edges, where pressures jump, are left out."""
    inside = np.abs(5 * radii - np.round(5 * radii)) > 1e-6
    rows = [
        pd.DataFrame({"time": t, "radius": radii[inside], "pressure": p[inside], "indentation": d})
        for t, p, d in zip(times[1:], pressures[1:], depths[1:], strict=True)
    ]
    return pd.concat(rows)


@pytest.mark.slow
def test_check_names_too_long_a_wear_step():
    """The indentation is right, the pressures are not; and the limit is about that of the mesh."""
    scene = FIVE.changed(punch__wear_coefficients=[0.1, 1.0])
    mesh = as_half_space(structured.below_nodes(np.linspace(0, 1, 21), 200.0), EDGES)
    radii, stiffness = condensed(mesh, "Q1")
    to_pressures, wear = pressures_of(radii, "Q1", False), wear_of_five_rings(radii)
    limit = greatest_eigenvalue_limit(stiffness, to_pressures, wear)
    marched = march(stiffness, to_pressures, wear, 2.0, 1.3 * limit, 40, clipped=True)
    table = table_of(radii, *marched[:3])
    found = check(scene, {"loop": table}, methods=["mdr"], within=0.05, element="q1").mistakes()
    assert [each.name for each in found] == ["wear step too long"]
    words = found[0].words
    assert "indentation and force are right, but the pressures are not" in words
    assert "explains the difference" in words
    assert found[0].size == pytest.approx(limit, rel=0.2)
    few = check(scene, {"loop": table[table["time"] > 37 * 1.3 * limit]}, methods=["mdr"])
    assert "consecutive updates of the wear" in few.mistakes()[-1].words
