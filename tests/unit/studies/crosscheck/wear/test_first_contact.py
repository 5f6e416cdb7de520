"""The search for the first contact, and the cells that it determines."""

import time

import numpy as np
import pytest
from natural import natural
from rough_faces import rough, with_heights

from ringwear import (
    ContactCells,
    Stages,
    energy,
    even_half_space,
    method,
    moments,
)
from ringwear.meshes.half_space import contact_radii
from ringwear.studies.crosscheck.sizes.cells import cells_of
from ringwear.studies.crosscheck.wear import first_contact as search
from ringwear.studies.crosscheck.wear.contact_edges import worn_edges
from ringwear.studies.crosscheck.wear.first_contact import (
    UnwornPunch,
    contact_cells,
    find_first_contact,
    first_contact,
    load_at_start,
    load_of,
)
from ringwear.studies.crosscheck.wear.unilateral import Contact

RINGS = natural(
    {"radius": 2.0, "ring_edges": [0.8, 1.4, 2.0], "wear_coefficients": [1, 10]},
    [0.0, 0.1, 1.0],
    half_space={"plane_strain_modulus": 5.0},
    load={"normal_force": 0.3},
)


RADII = np.linspace(0, 1, 601)
STARTS = {
    "50 heights, next to no force": rough(50, normal_force=1e-9),
    "200 heights": rough(200, normal_force=1e-2),
    "200 heights, next to no force": rough(200, normal_force=1e-9),
    "30 dimples": with_heights(RADII, 0.01 * np.sin(30 * np.pi * RADII) ** 2, normal_force=5e-4),
    "off-centre ring": with_heights([0, 0.5, 1], [0.1, 0, 0.1], normal_force=1e-6),
    "hardly pressed in": with_heights([0, 0.5, 1], [0.1, 0, 0.1], indentation=1e-9),
    "huge force": with_heights([0, 0.5, 1], [0.1, 0, 0.1], normal_force=1e6),
}


@pytest.mark.parametrize("name", STARTS)
def test_contact_begins_where_the_face_is_lowest(name):
    problem = STARTS[name].problem
    began = time.process_time()
    intervals, cells = first_contact(problem)
    assert time.process_time() - began < 3
    space, load = cells.space(), load_at_start(problem)
    matrix, of_profile = energy.compliance(space).matrix, moments(problem.profile, space)
    press = Contact(matrix, space.weights).press(of_profile, load)
    gap = matrix @ press.pressure + of_profile - press.indentation * space.weights
    assert press.pressure.min() >= 0
    depths = np.abs(of_profile) + press.indentation * space.weights
    assert gap.min() >= -1e-14 * depths.max()
    assert space.weights @ press.pressure == pytest.approx(press.force, rel=1e-12)
    # the lowest point is in contact, to within one cell, because the contact may be narrower
    radii, heights = problem.profile.sampled()
    lowest = radii[heights.argmin()]
    cell = float(cells(lowest))
    assert any(part.inner - cell <= lowest <= part.outer + cell for part in intervals)
    assert cell < 0.02
    assert press.indentation > heights.min()


# scenes in which an earlier search for the first contact returned to the same cells in every second
# or third iteration, or in each, until it had used up its iterations
CIRCLING = {
    "every second": {
        "punch__ring_edges": [0.199, 0.208, 0.347, 0.769, 1.0],
        "punch__recess": [0.0044, 0.015, 0.004, 0.011, 0.015],
        "punch__profile": {"kind": "parabola", "curvature_radius": 1100.0},
        "load__normal_force": 0.048,
        "accuracy__rtol": 1e-2,
    },
    "every third": {
        "punch__ring_edges": [0.152, 0.204, 0.711, 1.0],
        "punch__recess": [0.12, 0.2, 0.062, 0.24],
        "load__normal_force": 1.0,
    },
    "always the same": {
        "punch__ring_edges": [0.205, 0.495, 1.0],
        "punch__recess": [0.00017, 0.00036, 0.0004],
        "load__normal_force": 5.6e-5,
        "accuracy__rtol": 1e-4,
    },
}


@pytest.mark.parametrize("name", CIRCLING)
def test_first_contact_is_found_with_at_most_four_compliances(name):
    modulus = {"half_space__plane_strain_modulus": 1.0, "punch__wear_coefficients": [1.0, 2.0]}
    problem = RINGS.changed(punch__radius=1.0, **modulus, **CIRCLING[name]).problem
    looks = []

    def look(space):
        looks.append(space)
        return energy.compliance(space)

    punch = UnwornPunch(look, problem.profile, load_of(problem))
    intervals, _ = find_first_contact(punch, cells_of(problem))
    assert intervals
    assert 1 <= len(looks) <= 4


def test_first_contact_is_found_once_for_all_methods(monkeypatch):
    calls = []

    def count(*arguments):
        calls.append(arguments)
        return find_first_contact(*arguments)

    monkeypatch.setattr(search, "find_first_contact", count)
    problem = RINGS.changed(punch__recess=[0.0, 0.01, 0.0], accuracy__rtol=1e-2).problem
    for name in ("mdr", "bem"):
        method(name).solve(problem, Stages(name))
    # once on the cells of the result, and once on half as many for the error estimate
    assert len(calls) == 2


def test_the_coarser_cells_are_coarser_where_contact_begins():
    """A search for the first contact may choose the sizes there itself."""
    edges, wear = [0.1979, 0.8762, 1.0], [1.0, 0.923368719092991, 0.5865486762333854]
    profile = {"kind": "power", "coefficient": 0.0048846518726409485, "exponent": 4.62017910640662}
    begun = natural(
        {"ring_edges": edges, "wear_coefficients": wear, "profile": profile},
        rtol=10**-3.5,
        load={"normal_force": 3.6e-6},
        wear={"times": [0.0, 1.0], "steady": False},
    )
    fine, coarse = contact_cells(begun.problem)
    for cells, other in zip(fine.refinements, coarse.refinements, strict=True):
        assert other[2] / (other[1] - other[0]) == pytest.approx(
            2 * cells[2] / (cells[1] - cells[0]), rel=1e-12
        )


def test_refinement_reaches_the_sizes_of_any_cells():
    """Facets of triangles follow the cells; an earlier refinement ran out of iterations here."""
    punch = {
        "radius": 25.0,
        "ring_edges": [18.0, 21.0, 25.0],
        "wear_coefficients": [1.0, 1.0, 4.0],
        "profile": {
            "kind": "table",
            "radii": [0.0, 17.9, 18.5, 19.5, 21.5, 23.5, 24.5, 25.0],
            "heights": [0.02, 0.02, 0.012, 0.004, 0.0, 0.004, 0.012, 0.02],
        },
    }
    scene = natural(punch, rtol=1e-4, methods="fem", load={"indentation": 0.05})
    _, cells = first_contact(scene.problem)
    mesh = even_half_space(cells).solid.mesh
    radii = contact_radii(mesh)
    assert all(np.abs(radii - edge).min() < 1e-12 for edge in cells.ring_edges)
    # facets are as small as the cells, except that the size varies over a triangle
    assert (np.diff(radii) <= 1.5 * cells((radii[1:] + radii[:-1]) / 2)).all()


@pytest.mark.parametrize("gap", [1, 2, 3])
def test_parts_of_the_contact_do_not_overlap(gap):
    """Contact edges are extrapolated from worn depths on both sides of a narrow gap."""
    space = ContactCells((0.0, 1.0), 0.02, 0.02).space()
    node = np.arange(space.size)
    middle = space.size // 2
    contact = (node < middle) | (node >= middle + gap)
    worn = np.where(contact, np.abs(node - middle - (gap - 1) / 2), 0.0)
    edges = np.ravel(worn_edges(space, contact, np.where(worn > 0, worn + 3, 0.0)))
    assert len(edges) == 4
    assert (np.diff(edges) >= 0).all()
