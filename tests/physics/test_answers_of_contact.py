"""Answers for punches whose contact opens, closes and spreads."""

from dataclasses import replace
from itertools import product

import numpy as np
import pytest
from groups import nightly, nightly_but
from natural import natural
from scipy.optimize import brentq

from ringwear import Scene, run

CURVATURE, FORCE = 3.0, 0.1


def sphere(times, **changes):
    """Return a scene of a sphere in units that differ from the natural ones."""
    profile = {"kind": "parabola", "curvature_radius": CURVATURE}
    scene = natural(
        {"radius": 2.0, "wear_coefficient": 0.5, "profile": profile},
        half_space={"plane_strain_modulus": 7.0},
        load={"normal_force": FORCE, "sliding_speed": 3.0},
        wear={"times": times},
        accuracy={},
    )
    return scene.changed(**changes)


@pytest.mark.slow
@pytest.mark.gmsh
def test_a_sphere_starts_with_hertz_contact():
    result = run(sphere([0.0, 0.1]))
    radius = (3 * FORCE * CURVATURE / 4 / 7.0) ** (1 / 3)
    exact = {
        "contact_radius_start": radius,
        "pressure_peak_start": 1.5 * FORCE / np.pi / radius**2,
        "indentation_start": radius**2 / CURVATURE,
        "force_start": FORCE,
        # the last time is long before full contact
        "time_to_full_contact": np.nan,
    }
    for answers in result.answers.values():
        found = {name: float(answers[name]) for name in exact}
        assert found == pytest.approx(exact, rel=1e-4, nan_ok=True)
        assert found["contact_radius_start"] == pytest.approx(radius, rel=1e-6)
        assert found["indentation_start"] == pytest.approx(radius**2 / CURVATURE, rel=1e-6)
    start = result.dataset.sel(solver="mdr").isel(time=0)
    assert ((start.contact > 0) == (start.radius <= radius)).all()
    assert np.array(start.contact_edge[:2]) == pytest.approx([0.0, radius])


@pytest.mark.parametrize("name", ["cone", "recessed_binder"])
def test_infinite_peak_pressures_are_left_out_of_the_answer(name):
    scene = Scene.load(name).changed(wear__times=[0.0], wear__steady=False)
    answers = run(scene, methods=["mdr"]).answers["mdr"]
    assert np.isnan(answers["pressure_peak_start"])
    assert answers["contact_radius_start"] > 0


@pytest.fixture(scope="module")
def worn():
    """Run of a sphere that wears into full contact within the times of the scene."""
    return run(sphere([0.0, 1e-3, 0.2, 40.0], load__normal_force=20.0, accuracy__rtol=1e-3))


def test_the_printed_answer_lists_the_running_in_times(worn):
    printed = repr(worn)
    for label in ("time to full contact", "time to 90", "time to 99"):
        assert label in printed


@pytest.mark.slow
@pytest.mark.parametrize("name", ["cone", *nightly("recessed_binder", "rounded_rim")])
def test_times_running_in_cover_the_whole_running_in(name):
    scene = Scene.load(name).changed(wear__times="running-in", accuracy__rtol=1e-2)
    assert Scene.from_toml(scene.to_toml()).wear.times == scene.wear.times
    result = run(scene, methods=["mdr"])
    answers, times = result.answers["mdr"], scene.wear.times
    assert times[1] < 0.05 * answers["time_to_90"]
    assert answers["time_to_99"] <= times[-1] < 10 * answers["time_to_99"]
    # at the first time after the start, the punch is hardly worn
    depth = result.dataset.indentation.values[0]
    assert 0 < depth[1] - depth[0] < 0.01 * depth[0]
    # the same at the initial indentation, held fixed: the times extend until the force has decayed
    fixed = scene.changed(load={"indentation": float(depth[0])})
    force = run(fixed, methods=["mdr"]).dataset.normal_force.values[0]
    assert 0.98 * force[0] < force[1] < force[0]
    assert force[-1] < 0.02 * force[0]


def test_tau_counts_relaxation_times_of_the_full_face():
    counts = {"tau": [0.0, 0.5, 2.0]}
    shaped = sphere(counts).wear.times
    flat = Scene.load("flat_punch").changed(wear__times=counts).problem.times
    assert shaped[1] == pytest.approx(flat[1] * 2.0 / 7.0 / 0.5 / 3.0, rel=5e-3)
    fixed = {"indentation": 0.1, "sliding_speed": 3.0}
    fixed_sphere = sphere(counts, load=fixed)
    assert fixed_sphere.wear.times[2] / shaped[2] == pytest.approx(1.7275 / 0.4852837728, rel=1e-2)


def test_curves_continue_from_the_march_into_full_contact(worn):
    radius, wear_coefficient, force, speed = 2.0, 0.5, 20.0, 3.0
    for name, solution in worn.solutions.items():
        # the first method with values between the times is the only one
        drawn, between = replace(worn, solutions={name: solution}).between
        assert drawn == name
        times = between["time"]
        assert (np.diff(times) > 0).all()
        # Archard's law for one material under a constant force
        volumes = between["ring_worn_volume"].sum(axis=1)
        assert volumes == pytest.approx(wear_coefficient * force * speed * times, rel=1e-10)
        assert times[-1] == pytest.approx(worn.scene.wear.times[-1], rel=1e-12)
        edge, full = between["contact_edge"][:, 1], worn.answers[name]["time_to_full_contact"]
        # the first time is before full contact, which is reached; the edge is accurate to one cell
        widest = radius * np.diff(solution.evolution.punch.space.breakpoints).max()
        assert (np.diff(edge) > -widest).all()
        assert (edge[times > 1.01 * full] == radius).all()
        assert (times > full).sum() > 30


def test_the_steps_of_the_march_are_stored(worn):
    assert "step_time" not in worn.dataset
    scene = worn.scene.changed(output__every_step=True, accuracy__rtol=1e-3)
    stored = run(scene, methods=["mdr"]).dataset.isel(solver=0)
    times = stored.step_time.values
    assert (np.diff(times) > 0).all()
    # from the start to the last time; in full contact, where modes take over, at some times
    assert times[0] == 0.0
    assert times[-1] == stored.time[-1]
    assert stored.step_normal_force.values == pytest.approx(20.0)
    assert stored.step_contact_area[-1] == 1.0
    assert (np.diff(stored.step_contact_area) >= 0).all()
    assert float(stored.step_indentation[0]) == pytest.approx(
        float(stored.indentation[0]), rel=1e-4
    )


# a face that is worn flat over a radius c, and has lost the volume between its heights and h(c)
FACES = {
    "ball": ({"kind": "ball", "ball_radius": 5.0}, 0.0, lambda r: 5 - np.sqrt(25 - r**2)),
    "cone": ({"kind": "cone", "slope": 0.1}, 0.0, lambda r: 0.1 * r),
    "parabola": ({"kind": "parabola", "curvature_radius": 5.0}, 0.0, lambda r: r**2 / 10),
    "hollow": ({"kind": "parabola", "curvature_radius": 5.0}, 0.6, lambda r: r**2 / 10),
}
RIM, WEAR, STIFF_FORCE = 1.5, 2e-8, 10.0


@pytest.mark.slow
@pytest.mark.gmsh
@pytest.mark.parametrize(
    ("name", "method"),
    nightly_but(
        [("ball", "mdr"), ("cone", "bem"), ("parabola", "fem"), ("hollow", "mdr")],
        product(FACES, ("mdr", "bem", "fem")),
    ),
)
def test_running_in_of_a_stiff_punch_until_shortly_after_full_contact(name, method):
    profile, hole, height = FACES[name]

    def worn(edge):
        radii, weights = np.polynomial.legendre.leggauss(8)
        radii = (hole + edge) / 2 + (edge - hole) / 2 * radii
        depths = (height(edge) - height(radii)) * 2 * np.pi * radii
        return depths @ weights * (edge - hole) / 2

    def remaining(edge):
        parts = [height(c) - worn(c) / np.pi / (RIM**2 - hole**2) for c in (edge, RIM, hole)]
        return (parts[1] - parts[0]) / (parts[1] - parts[2])

    edges = [brentq(lambda c, p=part: remaining(c) - p, hole, RIM) for part in (0.1, 0.01)]
    times = {"time_to_full_contact": RIM, "time_to_90": edges[0], "time_to_99": edges[1]}
    times = {name: worn(edge) / WEAR / STIFF_FORCE for name, edge in times.items()}
    full = times["time_to_full_contact"]
    for end in (0.999, 1.001, 1.1):
        scene = natural(
            {"radius": RIM, "inner_radius": hole, "wear_coefficient": WEAR, "profile": profile},
            [0.0, end * full],
            methods=method,
            half_space={"plane_strain_modulus": 1e7},
            load={"normal_force": STIFF_FORCE},
        )
        result = run(scene)
        answers = {time: float(result.answers[method][time]) for time in times}
        if end < 1:
            assert np.isnan(list(answers.values())).all()
            continue
        error = 1.5 * float(result.solutions[method].errors["time_to_full_contact"])
        assert answers["time_to_full_contact"] == pytest.approx(full, rel=error)
        # the elastic indentation at the start, which is left out above, is a few 1e-3 of the height
        assert answers == pytest.approx(times, rel=5e-3)
