"""Contact nodes, explicit updates, and limits of steps in the units of a scene."""

import numpy as np
import pytest

from ringwear import Scene, SceneError
from ringwear.meshes import as_half_space, ring_areas, structured
from ringwear.studies.check.sawtooth import find
from ringwear.studies.study.own import ELEMENTS
from ringwear.studies.wear_step import contact_nodes as contact_nodes_module
from ringwear.studies.wear_step.contact_nodes import PER_NODE, TREATMENTS, contact_nodes, relief
from ringwear.studies.wear_step.limits import (
    contacts_of,
    describe,
    limits_of_size,
    limits_on_mesh,
    vertices_of_size,
)

FLAT, FIVE = Scene.load("flat_punch").problem, Scene.load("five_rings")


def nodes_of(element, count=16, inner=0.0):
    vertices = np.linspace(0, 1, count + 1)
    mesh = structured.below_nodes(vertices, 20.0)
    if element.startswith("P"):
        mesh = structured.in_triangles(mesh)
    return contact_nodes(as_half_space(mesh, np.array([inner, 1.0])), element, FLAT.ground)


@pytest.mark.parametrize("element", ELEMENTS)
@pytest.mark.parametrize("inner", [0.0, 0.5])
def test_nodes_carry_the_force_of_a_flat_punch(element, inner):
    """The stiffness of a full disc is 2 E* a; pressures of both treatments carry the force."""
    nodes = nodes_of(element, inner=inner)
    stiffness = nodes.stiffness.sum()
    # linear elements of a sixteenth of the radius are too stiff below the singular rim
    error = 0.07 if element.endswith("1") else 0.02
    assert stiffness == pytest.approx(2.0 if not inner else 1.96, rel=error)
    uniform = np.ones(len(nodes.radii))
    for treatment in TREATMENTS:
        forces = nodes.mass @ uniform
        pressures = nodes.pressures(treatment) @ forces
        area = ring_areas([inner, 1.0])[0]
        assert forces.sum() == pytest.approx(area, rel=1e-12)
        if treatment == "consistent":
            np.testing.assert_allclose(pressures, 1.0, rtol=1e-9)
        assert nodes.weights.sum() == pytest.approx(area, rel=1e-12)


def test_uniform_wear_takes_force_away_at_a_fixed_indentation_only():
    fixed = Scene.load("flat_punch").changed(load={"indentation": 0.5}).problem
    nodes = nodes_of("Q1")
    given, lost = (
        nodes.weights @ relief(problem, nodes, PER_NODE).sum(axis=1) for problem in (FLAT, fixed)
    )
    assert given == pytest.approx(0.0, abs=1e-12)
    assert lost == pytest.approx(nodes.stiffness.sum())


def test_limits_are_in_the_units_of_the_scene():
    """The same punch in other units allows the same sliding distance."""
    scene = Scene.load("washer")
    usual = limits_of_size(scene, 0.1, "Q1")[0]
    millimetres = scene.problem.units
    assert usual.distance(1.0) == pytest.approx(
        millimetres.length / millimetres.modulus / millimetres.wear_coefficient
    )
    (line,) = [line for line in describe([usual]) if line.startswith("stable")]
    assert " m (a time of " in line


@pytest.mark.slow
def test_a_shaped_punch_has_limits_at_its_start_and_at_its_end():
    scene = Scene.load("sphere")
    intervals = contacts_of(scene)
    assert [*intervals] == ["at the start", "at the last time"]
    (first,), (last,) = (ends.tolist() for ends in intervals.values())
    assert 0 == first[0] == last[0] < first[1] < last[1] < 1
    radii = np.linspace(0, 1, 101)
    mesh = as_half_space(structured.below_nodes(radii, 20.0), np.array([0.0, 1.0]))
    limits = limits_on_mesh(scene, mesh, "Q1")
    assert len(limits.contacts) == 2
    assert any(line.startswith("contact: edges move") for line in describe([limits]))
    coarse = as_half_space(structured.below_nodes(np.linspace(0, 1, 5), 20.0), np.array([0.0, 1.0]))
    with pytest.raises(SceneError, match="nodes in the contact at the start"):
        limits_on_mesh(scene, coarse, "Q1")


def test_limits_of_triangles_include_free_meshes_and_are_found_iteratively(monkeypatch):
    """The longest step of a mesh of many nodes follows from the largest eigenvalue alone."""
    limits = limits_of_size(FIVE, 0.1, "P1")
    # three first rows, and a mesh by bisection
    assert len(limits) == 4
    exact = [each.limit() for each in limits]
    monkeypatch.setattr(contact_nodes_module, "MOST_DENSE", 2)
    np.testing.assert_allclose([each.limit() for each in limits], exact, rtol=1e-3)
    with pytest.raises(SceneError, match="the mesh has quadrilaterals: give Q1, Q2 or Q2S"):
        contact_nodes(structured.below_nodes(np.linspace(0, 1, 5), 20.0), "P1", FLAT.ground)


def test_vertices_are_at_ring_edges():
    vertices = vertices_of_size(FIVE.problem, 0.07)
    assert np.isin(np.round(FIVE.problem.merged.ring_edges, 12), np.round(vertices, 12)).all()
    assert np.diff(vertices).max() <= 0.07


@pytest.mark.parametrize("rows", [0, 1, 9, 10])
def test_tables_without_a_sawtooth(rows):
    """Empty, constant and linear tables have none; an alternating one has."""
    times = np.arange(rows + 0.0)
    assert find(times, np.ones((rows, 5)), 1.0) is None
    assert find(times, times[:, None] * np.ones(5), 1.0) is None
    alternating = 1 + 0.5 * np.outer((-1.0) ** np.arange(rows), [0, 1, -1, 1, 0])
    assert (find(times, alternating, 1.0) is not None) == (rows == 10)
    assert find(times, alternating[:, :2], 1.0) is None
