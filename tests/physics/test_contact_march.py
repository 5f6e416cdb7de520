"""Wear while contact opens, closes and spreads.

Laws of wear, the sphere's, the flat punch's modes and steady states.
"""

from __future__ import annotations

import numpy as np
import pytest
from closed_forms import PowerPunch, worn_sphere

from ringwear.fem.contact_meshes import even_half_space
from ringwear.mdr import direct, energy
from ringwear.meshes.compliance import Compliance
from ringwear.meshes.contact_cells import ContactCells
from ringwear.meshes.radial import Array, ring_areas
from ringwear.studies.methods.base import method
from ringwear.studies.methods.quantities import QUANTITIES, array
from ringwear.studies.problem.problem import Problem, Rings
from ringwear.studies.problem.profile import InitialProfile, power, rounded_rim
from ringwear.studies.progress import Stages
from ringwear.studies.wear.archard import RunningIn
from ringwear.studies.wear.contact_edges import nodes, worn_edges
from ringwear.studies.wear.contact_march import ContactHistory, ContactMarch
from ringwear.studies.wear.moments import moments
from ringwear.studies.wear.unilateral import Load

BY_FORCE = Load(1.0)
FIVE, THREE = Rings.alternating(5, 1.0, 10.0), Rings.alternating(3, 1.0, 0.01)
ONE = Rings(np.array([0.0, 1.0]), np.ones(1))


def waves(count: int) -> object:
    return lambda radii: 0.3 * (1 - np.cos(count * np.pi * radii))


FACES = {
    "recessed": (FIVE, [0, 0.3, 0, 0.3, 0], ()),
    "stairs": (FIVE, [0.5, 0, 0.2, 0, 0.1], ()),
    "recessed, k to 100": (THREE, [0, 0.2, 0], ()),
    "sphere": (FIVE, [0] * 5, (power(1.0, 2),)),
    "sphere, k to 100": (THREE, [0] * 3, (power(2.0, 2),)),
    "cone": (FIVE, [0] * 5, (power(1.0, 1),)),
    "cone of one material": (ONE, [0], (power(1.0, 1),)),
    "waves": (FIVE, [0] * 5, (waves(9),)),
    "waves and recesses": (THREE, [0.2, 0, 0.3], (waves(5),)),
    "rounded rim": (FIVE, [0] * 5, (rounded_rim(0.6, 0.1),)),
}


def face(name: str) -> tuple[Rings, InitialProfile]:
    rings, recess, heights = FACES[name]
    return rings, InitialProfile(rings.ring_edges, np.array(recess, dtype=float), heights)


def marched(
    compliance: Compliance,
    rings: Rings,
    profile: InitialProfile,
    times: Array,
    load: Load = BY_FORCE,
    tolerance: float = 2e-5,
) -> ContactHistory:
    march = ContactMarch(
        compliance, rings.wear_coefficients, moments(profile, compliance.space), load
    )
    return march.adaptive(times, tolerance)


def cells(rings: Rings, count: int = 160, edge: float = 2e-4) -> ContactCells:
    return ContactCells(tuple(rings.ring_edges), 1 / count, edge)


QUICK = ("recessed",)


@pytest.mark.parametrize(
    "name", [one if one in QUICK else pytest.param(one, marks=pytest.mark.slow) for one in FACES]
)
def test_every_face_wears_to_the_steady_state_of_the_flat_punch(name: str) -> None:
    rings, profile = face(name)
    times = np.array([0.0, *np.geomspace(1e-2, 1e3, 11), 1e4])
    half_space = even_half_space(cells(rings), 0.3).compliance()
    space = half_space.space
    found, by_elements = (
        marched(one, rings, profile, times) for one in (energy.compliance(space), half_space)
    )
    wear = rings.wear_coefficients[nodes(space)[1]]
    # finite elements and the energy of the MDR all along
    assert by_elements.indentation == pytest.approx(found.indentation, rel=1e-4)
    assert (
        np.abs(wear * (by_elements.integral - found.integral)).max()
        < 1e-4 * found.indentation.min()
    )
    # all of the face carries in the end, and as the flat punch of these rings
    steady = direct.steady_pressures(*rings)[nodes(space)[1]]
    assert found.contact[-1].all()
    assert found.pressure[-1] == pytest.approx(steady, rel=1e-12)
    # complementary at every time, and each ring has worn k times what it has carried
    assert found.pressure.min() >= 0
    assert (found.gap >= -1e-14 * np.outer(found.indentation, space.weights)).all()
    assert (np.sum(np.abs(found.pressure * found.gap), axis=1) <= 1e-12 * found.indentation).all()
    assert found.integral[1:] @ space.weights == pytest.approx(times[1:], rel=1e-12)
    # long steps, each over several cells; of one that wears in twenty of them, most while a whole
    # ring comes to bear
    assert np.mean(found.iterations) <= (1.75 if name == "recessed, k to 100" else 1.5)
    assert max(found.iterations) <= 10


@pytest.mark.parametrize("name", QUICK)
def test_short_steps_hardly_search(name: str) -> None:
    rings, profile = face(name)
    compliance = energy.compliance(cells(rings).space())
    march = ContactMarch(
        compliance, rings.wear_coefficients, moments(profile, compliance.space), BY_FORCE
    )
    found = march.implicit(np.array([1.0]), 2e-3)
    assert found.steps == 500
    assert np.mean(found.iterations) <= 1.5
    assert max(found.iterations) <= 10
    assert march.start().iterations <= 20


@pytest.mark.parametrize("rings", [FIVE, THREE], ids=["k to 10", "k to 100"])
def test_a_flat_face_keeps_its_contact_and_follows_its_modes(rings: Rings) -> None:
    compliance, times = (
        energy.compliance(cells(rings, 60, 1e-4).space()),
        np.geomspace(1e-2, 3.0, 8),
    )
    flat = InitialProfile(rings.ring_edges, np.zeros(len(rings.wear_coefficients)))
    known = RunningIn(compliance, rings.wear_coefficients).modal(times)
    found = marched(compliance, rings, flat, times, tolerance=1e-7)
    assert found.contact.all()
    assert found.indentation == pytest.approx(known.indentation, rel=1e-5)


def test_orders_in_time() -> None:
    compliance, times = energy.compliance(cells(FIVE, 30, 1e-2).space()), np.array([0.0, 0.2])
    _, profile = face("sphere")
    march = ContactMarch(
        compliance, FIVE.wear_coefficients, moments(profile, compliance.space), Load(1.0)
    )
    exact = march.adaptive(times, 1e-9).indentation[-1]
    implicit = [
        abs(march.implicit(times, step).indentation[-1] - exact) for step in (0.02, 0.01, 0.005)
    ]
    assert 1.7 < implicit[0] / implicit[1] < 2.3
    assert 1.7 < implicit[1] / implicit[2] < 2.3
    few, many = march.adaptive(times, 1e-4), march.adaptive(times, 1e-6)
    error = abs(many.indentation[-1] - exact)
    assert error < 1e-5 * exact
    assert (
        many.steps < 10 * few.steps
    )  # of third order in a step: a hundredth of the error by 4.6 times the steps


def test_full_contact_relaxes_as_short_steps_have_it() -> None:
    rings, profile = face("cone")
    compliance, times = (
        energy.compliance(cells(rings, 40, 1e-3).space()),
        np.array([2.5, 3.0, 4.0, 6.0]),
    )
    march = ContactMarch(
        compliance, rings.wear_coefficients, moments(profile, compliance.space), BY_FORCE
    )
    found = march.adaptive(times, 1e-7)
    assert found.contact.all()
    errors = [march.implicit(times, step).indentation - found.indentation for step in (0.01, 0.005)]
    assert errors[0] / errors[1] == pytest.approx(2.0, rel=0.1)
    assert 2 * errors[1] - errors[0] == pytest.approx(0.0, abs=1e-5)


def worn_spheres(
    ratios: Array, cells_at_first: int, tolerance: float, elements: bool
) -> tuple[Array, list[tuple[Compliance, ContactHistory]]]:
    """Times and indentations by the law, and marches by theory, and by elements, to some radii over
    the first one.
    """
    first, curvature = 0.08, 1.0
    sphere = PowerPunch(1 / (2 * curvature), 2)
    force = sphere.force(first)
    known = np.array([worn_sphere(curvature, 1.0, force, first * ratio) for ratio in ratios])
    fine = ContactCells(
        (0.0, 1.0),
        0.2,
        1e-3,
        spread=1 / cells_at_first,
        spots=((0.0, first, first / cells_at_first),),
    )
    profile = InitialProfile(np.array([0.0, 1.0]), np.zeros(1), (power(1 / (2 * curvature), 2),))
    found = []
    compliances = [
        energy.compliance(fine.space()),
        *([even_half_space(fine, 0.3).compliance()] if elements else []),
    ]
    for compliance in compliances:
        history = marched(compliance, ONE, profile, known[:, 0], Load(force), tolerance)
        assert history.integral @ compliance.space.weights == pytest.approx(
            force * known[:, 0], rel=1e-12
        )
        found.append((compliance, history))
    return known, found


def test_the_law_of_the_worn_sphere() -> None:
    ratios = np.array([5.0, 10.0])
    known, [(compliance, found)] = worn_spheres(ratios, 80, 1e-5, elements=False)
    assert found.indentation == pytest.approx(known[:, 1], rel=1e-4)
    edges = [
        worn_edges(compliance.space, *one)[-1][1]
        for one in zip(found.contact, found.integral, strict=True)
    ]
    assert edges == pytest.approx(0.08 * ratios, rel=2e-3)


@pytest.mark.slow
def test_what_the_law_of_the_worn_sphere_leaves_out_falls_by_the_sixth_power() -> None:
    """It takes the pressure to be uniform.

    While the contact grows, displacements change by ``du/dt``, and the pressure is off by ``du/dt /
    k``, a part of about ``(c0/c)^3``; its displacement is such a part of F/c, which is one of the
    depth.
    """
    ratios = np.array([1.5, 2.0, 2.5, 3.0])
    known, ((_, by_theory), (_, by_elements)) = worn_spheres(ratios, 160, 1e-6, elements=True)
    # two methods tell the same of it, to a part of what it is
    assert by_elements.indentation == pytest.approx(by_theory.indentation, rel=6e-5)
    left_out = by_theory.indentation / known[:, 1] - 1
    assert (left_out[:2] > 6e-4).all()
    order = -np.diff(np.log(left_out)) / np.diff(np.log(ratios))
    assert order == pytest.approx(6.0, abs=1.2)


def test_at_a_fixed_indentation_the_force_decays() -> None:
    rings, profile = face("recessed")
    compliance = energy.compliance(cells(rings).space())
    times = np.array([0.0, 0.01, 0.1, 1.0, 10.0, 100.0])
    found = marched(compliance, rings, profile, times, Load(None, 0.5))
    assert found.indentation == pytest.approx(np.full(6, 0.5))
    assert (np.diff(found.force) < 0).all()
    assert found.force[-1] < 1e-3
    # in the end all that stood out has worn off: f = d where it has touched
    worn = found.integral[-1] * rings.wear_coefficients[nodes(compliance.space)[1]]
    middle = np.abs(nodes(compliance.space)[0] - 0.5) < 0.05
    assert worn[middle] == pytest.approx(0.5, abs=2e-3)


def test_contact_may_lift_again() -> None:
    # as the hard recessed disc comes to bear at last, the corner of the ring round it lets go
    rings = Rings(np.array([0.0, 0.73, 1.0]), np.array([0.081, 1.0]))
    profile = InitialProfile(rings.ring_edges, np.array([0.29, 0.0]))
    lifted = []
    for compliance in (
        energy.compliance(cells(rings).space()),
        even_half_space(cells(rings), 0.3).compliance(),
    ):
        times = np.array([2.6, 2.7604, 2.9, 3.5])
        found = marched(compliance, rings, profile, times, Load(None, 0.3), 5e-6)
        edges = [
            worn_edges(compliance.space, *one)
            for one in zip(found.contact, found.integral, strict=True)
        ]
        assert edges[0][-1] == (0.73, 1.0)
        lifted.append([one[-1][0] for one in edges[1:] if len(one) > 1])
        assert len(edges[-1]) == 1  # and bears again, as the disc wears on
        assert found.pressure.min() >= 0
    (by_theory, *_), (by_elements, *_) = ([edge for edge in one if edge > 0.731] for one in lifted)
    assert by_elements == pytest.approx(by_theory, abs=1e-3)


def random_punch(seed: int) -> tuple[Rings, InitialProfile]:
    """Up to six rings, wear coefficients over three decades, and recesses, powers, waves, a rounded
    rim, or sums of two.
    """
    draw = np.random.default_rng(seed)
    count = int(draw.integers(1, 7))
    edges = np.concatenate([[0.0], np.sort(draw.uniform(0.02, 0.98, count - 1)), [1.0]])
    recess = np.where(draw.random(count) < 0.4, 0.0, draw.uniform(0.0, 0.5, count)) * (
        draw.random() < 0.7
    )
    size, number, phase = 10 ** draw.uniform(-2, 0.5), draw.uniform(1, 8), draw.uniform(0, 6)
    shapes = (
        power(size, draw.uniform(0.5, 8)),
        rounded_rim(draw.uniform(0, 0.95), 10 ** draw.uniform(-2, 1)),
        lambda radii: size * (1 + np.sin(number * np.pi * radii + phase)),
    )
    chosen = tuple(shape for shape in shapes if draw.random() < 0.4)
    wear = 10 ** draw.uniform(-3, 0, count)
    return Rings(edges, wear / wear.max()), InitialProfile(edges, recess, chosen)


@pytest.mark.slow
@pytest.mark.parametrize("held", [False, True], ids=["force", "indentation"])
def test_random_punches(held: bool) -> None:
    times, touched = np.array([0.0, *np.geomspace(1e-2, 1e2, 9)]), 0
    for seed in range(200):
        rings, profile = random_punch(seed)
        depth = 10 ** np.random.default_rng(seed).uniform(-1.5, 0.3)
        compliance = energy.compliance(cells(rings, 40, 1e-3).space())
        space, load = compliance.space, Load(None, depth) if held else BY_FORCE
        found = marched(compliance, rings, profile, times, load, 1e-4)
        touched += int(found.force[0] > 0)
        assert found.pressure.min() >= 0, seed
        # no penetration beyond roundoff, by the moments of the gap
        assert (found.gap >= -1e-13 * np.outer(found.indentation, space.weights)).all(), seed
        assert (
            np.sum(np.abs(found.pressure * found.gap), axis=1)
            <= 1e-12 * found.force * found.indentation + 1e-25
        ).all()
        if held:
            assert (np.diff(found.force) <= 1e-12).all(), seed
            # no ring wears deeper than the punch is held, to the error of the steps
            worn = rings.wear_coefficients * (
                space.ring_forces(rings.ring_edges) @ found.integral[-1]
            )
            assert (worn <= depth * ring_areas(rings.ring_edges) * (1 + 1e-4)).all(), seed
        else:
            # each ring by its own coefficient: the sum over them is the force times time
            assert found.integral[1:] @ space.weights == pytest.approx(times[1:], rel=1e-12), seed
    assert touched >= 100


@pytest.mark.slow
@pytest.mark.parametrize("held", [False, True], ids=["force", "indentation"])
def test_random_punches_keep_to_what_is_said_of_them(held: bool) -> None:
    """Through a method, with its press fitted to the edges of the contact, its cells and its
    estimate.
    """
    mdr, solved = method("mdr"), 0
    for seed in range(1000, 1020):
        rings, profile = random_punch(seed)
        depth = 0.5 if held else None
        times = np.array([0.0, *np.geomspace(1e-2, 1e2, 9)])
        problem = Problem(rings, times, not held, rtol=1e-3, profile=profile, indentation=depth)
        if held and profile.nearest() >= 0.5:
            continue
        solved += 1
        solution = mdr.solve(problem, Stages("mdr"))
        results, errors = (
            {name: array(solution.results, name) for name in QUANTITIES},
            solution.errors,
        )
        gap = results["displacement"] + results["profile"] - results["indentation"][:, None]
        allowed = sum(errors[name] for name in ("displacement", "profile", "indentation"))
        assert (gap.min(axis=1) >= -allowed * results["indentation"]).all(), seed
        assert results["pressure"][1:].min() >= 0, seed
        if not held:
            total = (results["ring_worn_volume"] / rings.wear_coefficients).sum(axis=1)
            assert total == pytest.approx(times, rel=1e-12), seed
    assert solved >= 10
