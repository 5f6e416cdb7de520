"""Edges of the contact, and ring forces beside them, against an independent solution."""

import numpy as np
import pytest
from groups import nightly
from independent_contact import WornPunch, graded_rings
from natural import natural

from ringwear import Scene, run
from ringwear.studies.crosscheck.methods import moving_evaluation
from ringwear.studies.crosscheck.problem.quantities import differences
from ringwear.studies.crosscheck.wear.evolution import evolve

METHODS = ["mdr", pytest.param("fem", marks=pytest.mark.gmsh)]


def scene(punch, force, times, rtol=1e-3):
    wear = {"times": times, "steady": False}
    return natural(punch, rtol=rtol, load={"normal_force": force}, wear=wear)


def sizes(largest, places, smallest=2e-5, growth=0.1):
    """Return narrow rings that are small at some radii."""
    return lambda radii: np.min(
        [np.full_like(radii, largest), *(smallest + growth * np.abs(radii - r) for r in places)],
        axis=0,
    )


# a rounded rim: the contact spreads from 0.988 to the rim in the first 2 % of the history
FLAT, CURVATURE, EDGE, SLOW = 0.79307, 9.5893, 0.3952, 0.59832
RIM_FORCE, RIM_TIMES = 0.0155134, [0.0, 0.0040615, 0.0144385, 0.0513291]
RIM = scene(
    {
        "ring_edges": [EDGE, 1.0],
        "wear_coefficients": [1.0, SLOW],
        "profile": {"kind": "rounded_rim", "flat_radius": FLAT, "curvature_radius": CURVATURE},
    },
    RIM_FORCE,
    RIM_TIMES,
)


@pytest.fixture(scope="module")
def rim():
    """Contact radii of the rounded rim by the independent solution, to 2e-4."""
    edges = graded_rings([0, EDGE, FLAT, 1], sizes(1 / 150, [EDGE, FLAT, 0.988, 0.992, 1.0], 2e-4))
    punch = WornPunch(
        edges,
        lambda radii: np.where(radii < EDGE, 1.0, SLOW),
        lambda radii: np.maximum(radii - FLAT, 0) ** 2 / (2 * CURVATURE),
    )
    return np.array([punch.contact_radius(state) for state in punch.march(RIM_FORCE, RIM_TIMES)])


@pytest.mark.parametrize("method", METHODS)
def test_contact_radii_of_a_rounded_rim(rim, method):
    data = run(RIM, methods=[method]).dataset.isel(solver=0)
    error = np.abs(data.contact_radius.values - rim)
    assert (error[1:] <= data.contact_radius_error.values[1:] + 2e-4).all()


def test_edges_lie_in_the_cell_in_which_contact_ends(rim):
    """The error estimate of a contact radius is at least the width of that cell."""
    result = run(RIM, methods=["mdr"])
    evolution = result.solutions["mdr"].evolution
    space, history = evolution.punch.space, evolution.at(result.scene.problem.times)
    cells, radii = space.breakpoints, np.empty(space.size)
    # radii of the pressures at both ends of each cell
    radii[space.dofs] = np.stack([cells[:-1], cells[1:]], axis=1)
    errors = result.solutions["mdr"].errors["contact_radius"]
    for time in (1, 2):
        last = np.flatnonzero(history.contact[time])[-1]
        width = radii[last + 1] - radii[last]
        assert radii[last] - 2e-4 <= rim[time] <= radii[last + 1] + 0.1 * width + 2e-4
        assert errors[time] >= width * (1 - 1e-12)


# rings with recesses: an edge of the contact crosses the second ring before the last time
RINGS = [0.151, 0.2127, 0.4677, 0.8038, 1.0]
FAST, LOWER = 1.0, 0.74575
RECESS = [0.0, 1.59394e-3, 5.32552e-3, 0.0, 0.0]
RING_FORCE, RING_TIMES = 0.0180486, [0.0, 0.08539641, 0.24691585, 0.71393438]


def on_rings(values):
    return lambda radii: np.array(values)[np.searchsorted(RINGS, radii)]


@pytest.mark.slow
@pytest.mark.parametrize("method", METHODS)
def test_ring_forces_at_the_last_time(method):
    """Errors of steps in time limit these forces; the coarser march has longer steps."""
    wear = np.resize([FAST, LOWER], len(RINGS))
    punch = {"ring_edges": RINGS, "wear_coefficients": wear.tolist(), "recess": RECESS}
    data = run(scene(punch, RING_FORCE, RING_TIMES), methods=[method]).dataset.isel(solver=0)
    fine, coarse = (
        WornPunch(
            graded_rings([0, *RINGS], sizes(largest, RINGS, smallest, 0.25)),
            on_rings(wear),
            on_rings(RECESS),
        )
        for largest, smallest in ((1 / 150, 1e-5), (1 / 90, 4e-5))
    )
    states = (
        fine.march(RING_FORCE, RING_TIMES, 25)[-1],
        coarse.march(RING_FORCE, RING_TIMES, 15)[-1],
    )
    forces, less_accurate = (
        punch.by_ring(state.pressure, [0, *RINGS])
        for punch, state in zip((fine, coarse), states, strict=True)
    )
    doubt = np.abs(forces - less_accurate).max() / RING_FORCE
    error = np.abs(data.ring_force.values[-1] - forces).max() / RING_FORCE
    assert doubt < 1e-4
    assert error <= float(data.ring_force_error[-1]) + doubt


@pytest.mark.gmsh
@pytest.mark.slow
def test_pressures_of_a_toroid():
    """The contact has two free edges; both meshes of a method may have them at the same places."""
    radii = np.linspace(0, 1, 401)
    table = {"kind": "table", "radii": radii.tolist(), "heights": ((radii - 0.5) ** 2 / 2).tolist()}
    toroid = scene({"wear_coefficient": 1.0, "profile": table}, 1e-4, [0.0], rtol=1e-4)
    result = run(toroid, methods=["mdr", "fem"])
    assert result.verdict == "agree"
    face, height = toroid.problem.face, toroid.punch.profile.height_over(1.0)
    places = sizes(0.02, [0.49375, 0.50645], 1e-5, 0.02)
    punch = WornPunch(graded_rings([0, 1], places), np.ones_like, height)
    (state,) = punch.march(1e-4, [0.0])
    exact = np.interp(face.radii, punch.middles, state.pressure)
    weights = face.weights * face.edge_weights
    for method, solution in result.solutions.items():
        pressure = solution.compared["pressure"][0] * 1e-4
        error = np.sqrt(weights @ (pressure - exact) ** 2 / (weights @ exact**2))
        assert error <= solution.errors["pressure"][0], method
        depth = float(result.dataset.indentation.sel(solver=method)[0])
        assert abs(depth / state.indentation - 1) <= solution.errors["indentation"][0], method


@pytest.mark.slow
@pytest.mark.parametrize("longer", [1.0, 1e4])
@pytest.mark.parametrize("name", ["sphere", *nightly("cone", "rounded_rim")])
def test_estimates_include_steps_that_are_too_long(name, longer, monkeypatch):
    scene = Scene.load(name).changed(accuracy__rtol=1e-3)
    exact = run(scene.changed(accuracy__rtol=1e-4), methods=["bem"]).solutions["bem"].compared
    monkeypatch.setattr(
        moving_evaluation,
        "evolve",
        lambda punch, last, tolerance, *others: evolve(punch, last, longer * tolerance, *others),
    )
    loose = run(scene, methods=["mdr"]).solutions["mdr"]
    errors = differences(loose.compared, exact, scene.problem.face)
    greatest = max(errors.get("time_to_90", 0.0), errors["mean_contact_radius"].max())
    assert greatest > 1e-3 or longer == 1
    for quantity, error in errors.items():
        assert not (error > 1.5 * loose.errors[quantity]).any(), quantity
