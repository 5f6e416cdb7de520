"""Diagnoses name the right fault of results first, and no fault of right or noisy results."""

from functools import cache

import numpy as np
import pytest

from ringwear import Scene, run
from ringwear.studies.estimate.compared import Comparison
from ringwear.studies.estimate.diagnose import diagnose

SCENES = {
    "five": Scene.load("five_rings"),
    "two": Scene(
        units="SI",
        punch={"radius": 0.01, "ring_edges": [0.004, 0.01], "wear_coefficients": [5e-15, 1e-15]},
        half_space={"youngs_modulus": 2e9},
        load={"normal_force": 100.0, "sliding_speed": 0.1},
        wear={"times": [0.0, 1e3, 3e3, 1e4, 2e4, 3e4, 4e4, 5e4]},
    ),
}
LENGTHS = {"indentation", "displacement", "profile"}
CLAMPED = {"method": "fem", "accuracy__fem__far_field": "fixed", "accuracy__fem__truncation": 20.0}


def radii_of(scene):
    return np.linspace(0.004, 0.996, 125) * scene.punch.radius


def solve(scene, method="mdr", late=0.0, **changes):
    """Return results of a scene with changes, at the times and radii of the unchanged scene.

    With `late`, wear starts at that time.
    """
    times, order = np.unique(np.maximum(np.array(scene.wear.times) - late, 0), return_inverse=True)
    changes |= {"output__radii": radii_of(scene).tolist(), "wear__times": times.tolist()}
    dataset = run(scene.changed(**changes), methods=[method]).dataset
    return {name: dataset[name].values[0][order] for name in (*LENGTHS, "pressure")}


@cache
def ours(name):
    return solve(SCENES[name])


def look(name, theirs, **changes):
    """Return the diagnosis of another program's results."""
    scene = SCENES[name].changed(**changes)
    return diagnose(
        Comparison(np.array(scene.wear.times), radii_of(scene), theirs, ours(name), scene)
    )


LAST = SCENES["two"].wear.times[-1]


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "size", "change"),
    [
        ("first-order time step", LAST / 40, {"wear__march": "implicit", "wear__step": LAST / 40}),
        ("late start", LAST / 6, {"late": LAST / 6}),
    ],
)
def test_the_right_fault_of_the_model_is_named_first(name, size, change):
    first = look("two", solve(SCENES["two"], **change))[0]
    assert (first.name, first.size) == (name, pytest.approx(size, rel=0.2))
    assert 0.8 < first.share <= 1


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "factor", "of"),
    [
        ("2 pi missing", 1 / (2 * np.pi), {"pressure"}),
        ("Poisson's ratio", 1 - 0.3**2, LENGTHS),
    ],
)
def test_the_right_factor_is_named_first(name, factor, of):
    theirs = {key: right * (factor if key in of else 1) for key, right in ours("two").items()}
    first = look("two", theirs)[0]
    assert (first.name, first.size) == (name, pytest.approx(factor))
    assert f"{factor:.4g}" in first.words


@pytest.mark.slow
def test_faults_of_the_mesh_are_named():
    coarse = {"accuracy__fem__rim_size": 0.1, "accuracy__fem__degree": 4}
    assert look("five", solve(SCENES["five"], "fem", **coarse))[0].name == "coarse rim"
    # together with a truncated half-space, which shows in the displacements
    theirs = solve(SCENES["five"], **CLAMPED)
    theirs["pressure"] = theirs["pressure"] * (1 + 0.05 * (-1.0) ** np.arange(125))
    sizes = {fault.name: fault.size for fault in look("five", theirs)}
    assert sizes["truncated half-space"] == pytest.approx(20, rel=0.2)
    assert sizes["checkerboard"] == pytest.approx(0.05, rel=0.01)


@pytest.mark.slow
def test_a_truncated_incompressible_half_space_is_named():
    """The indentation is too small by 6/pi a/R, as for a point force in an incompressible ball."""
    theirs = solve(SCENES["five"], half_space__poisson_ratio=0.5, accuracy__rtol=1e-2, **CLAMPED)
    low = ours("five")["indentation"][0] - theirs["indentation"][0]
    assert low == pytest.approx(6 / np.pi / 20, rel=0.03)
    first = look("five", theirs, half_space__poisson_ratio=0.5)[0]
    assert (first.name, first.size) == ("truncated half-space", pytest.approx(20, rel=0.05))


@pytest.mark.slow
def test_a_force_too_high_for_the_indentation_means_a_truncated_half_space():
    """At one time a wrong modulus is as likely and named, too; later forces exclude it."""
    scene = SCENES["five"].changed(
        load={"indentation": 0.8, "sliding_speed": 1.0}, wear__steady=False, accuracy__rtol=1e-3
    )
    names = ["pressure", "profile", "displacement", "normal_force"]
    at = {"output__radii": radii_of(scene).tolist()}
    cut_off = {key: of for key, of in CLAMPED.items() if key != "method"}
    right, wrong = (
        {name: run(changed, methods=[of]).dataset[name].values[0] for name in names}
        for changed, of in ((scene.changed(**at), "mdr"), (scene.changed(**at, **cut_off), "fem"))
    )
    times = np.array(scene.wear.times)
    first, *others = diagnose(Comparison(times, radii_of(scene), wrong, right, scene))
    assert (first.name, first.size) == ("truncated half-space", pytest.approx(20, rel=0.05))
    assert not others
    start = ({name: of[:1] for name, of in each.items()} for each in (wrong, right))
    looks = diagnose(Comparison(times[:1], radii_of(scene), *start, scene))
    assert [fault.name for fault in looks] == ["truncated half-space", "modulus"]
    assert looks[0].size == pytest.approx(20, rel=0.05)


@pytest.mark.slow
def test_missing_layers_are_named():
    stiffness = 4.0
    layer = {"thickness": 0.3, "youngs_modulus": stiffness, "poisson_ratio": 0.3}
    below = {"youngs_modulus": 1.0, "poisson_ratio": 0.3}
    scene = SCENES["five"].changed(
        half_space=below | {"layers": [layer]}, wear__steady=False, accuracy__rtol=1e-3
    )
    right, times = solve(scene), np.array(scene.wear.times)
    theirs = solve(scene.changed(half_space=below))
    (only,) = diagnose(Comparison(times, radii_of(scene), theirs, right, scene))
    assert (only.name, only.size) == ("layers left out", pytest.approx(1.0 / stiffness))
    assert only.share > 0.8


@pytest.mark.slow
def test_noise_is_no_fault():
    draw = np.random.default_rng(0).standard_normal
    theirs = {name: of * (1 + 1e-3 * draw(of.shape)) for name, of in ours("two").items()}
    assert look("two", theirs) == []


def test_right_results_have_no_fault():
    assert look("five", ours("five")) == []
    assert look("five", solve(SCENES["five"], "fem")) == []
