"""Numbers that once were wrong although the verdict was "agree", against exact results."""

from dataclasses import replace

import numpy as np
import pytest
from given import judge
from groups import nightly, slow
from natural import natural

from ringwear import Scene, check, run

FIVE = Scene.load("five_rings")


@pytest.mark.parametrize(
    "rtol",
    [
        1e-2,
        1e-4,
        *slow(1e-6, 1e-8),
        *nightly(1e-7),
    ],
)
@pytest.mark.parametrize("first", [1e-2, 1e-7])
def test_start_pressures_are_those_of_the_closed_form(rtol, first):
    """Small elements at ring edges, which later times need, do not make the start worse."""
    scene = FIVE.changed(accuracy__rtol=rtol, wear__times=[0.0, first, 1.0])
    methods = {1e-2: ["mdr", "bem"], 1e-4: ["mdr", "bem", "fem"]}
    result = run(scene, methods=methods.get(rtol, ["mdr"]))
    # at the rim, the pressure is infinite
    pressure = result.dataset.pressure.isel(time=0).where(result.dataset.radius < 1)
    error = np.pi * pressure * np.sqrt((1 - pressure.radius) * (1 + pressure.radius)) - 1
    assert float(np.abs(error).max()) <= rtol
    edges, rings = np.arange(5) / 5, result.summary["answer"]["mdr"]
    exact = 1 / np.pi / np.sqrt((1 - edges) * (1 + edges))
    np.testing.assert_allclose(rings["pressure_min"][0], exact, rtol=rtol)
    np.testing.assert_allclose(rings["pressure_max"][0][:-1], exact[1:], rtol=rtol)
    assert result.verdict != "disagree"


@pytest.mark.slow
@pytest.mark.parametrize(
    ("standoff", "inner", "indentation"),
    [
        *((0.2, 0.1, None), (100.0, 0.1, 1e-4), (0.25, 0.0, None)),
        *nightly((100.0, 0.1, 0.1), (100.0, 0.1, None)),
    ],
)
def test_results_do_not_depend_on_the_face_plane(standoff, inner, indentation):
    """Two rings, the inner one recessed or not, and all of the face at a distance from the plane.

    A face that is recessed everywhere is flat, and the steady state does not change, either. Errors
    of other programs are relative to depths from the first touch.
    """

    def results(standoff):
        force = {"normal_force": 0.1}
        recess = [inner + standoff, standoff]
        rings = {"rings": 2, "wear_coefficients": [1.0, 2.0], "recess": recess}
        load = force if indentation is None else {"indentation": standoff + indentation}
        methods = "mdr" if inner else "mdr fem direct"
        scene = natural(rings, [0.0, 1.0, 5.0], methods=methods, load=load)
        assert scene.problem.full_contact == (not inner)
        dataset = run(scene).dataset
        heights = dataset.profile.isel(solver=0).to_dataframe().reset_index()
        too_high = standoff + 1.03 * (heights.profile - standoff)
        theirs = heights[["time", "radius"]].assign(profile=too_high)
        return dataset, check(scene, theirs, "mdr").errors.error

    (plain, errors), (moved, errors_when_moved) = results(0.0), results(standoff)
    np.testing.assert_allclose(errors_when_moved, errors, rtol=1e-3)
    depth = float(plain.indentation.max())
    # the distance of the face causes roundoff of its heights
    roundoff = max(1e-9, 1e-14 * standoff / depth)
    names = ["pressure", "normal_force", "ring_worn_volume", "contact_radius", "steady_rms_slope"]
    for name in names if inner else [*names, "displacement", "rms_slope", "relaxation_time"]:
        scale = float(np.abs(plain[name].where(np.isfinite(plain[name]))).max())
        np.testing.assert_allclose(moved[name] / scale, plain[name] / scale, rtol=0, atol=roundoff)
    for name in ("indentation", "profile", "indentation_start"):
        height, error = (moved[name] - standoff) / depth, f"{name}_error"
        np.testing.assert_allclose(height, plain[name] / depth, atol=roundoff)
        np.testing.assert_allclose(moved[error], plain[error], rtol=1e-2, atol=1e-9)


def test_estimates_at_a_single_time_bound_the_errors():
    """Two meshes may agree by chance at one time; estimates use errors at nearby times, too."""
    profile = {"kind": "parabola", "curvature_radius": 1.58}
    scene = natural(
        {"wear_coefficient": 1.0, "profile": profile},
        methods="mdr",
        load={"normal_force": 0.107},
        wear={"times": [0.3], "steady": False},
    )
    result, truth = (
        run(scene.changed(accuracy__rtol=rtol)).dataset.isel(solver=0) for rtol in (1e-3, 1e-5)
    )
    for name in ("contact_radius", "profile", "indentation"):
        wrong = np.abs(result[name] - truth[name])
        scale = 1.0 if name == "contact_radius" else truth.indentation
        assert float((wrong / scale).max()) <= float(result[f"{name}_error"].max()), name


@pytest.mark.slow
def test_a_face_finer_than_the_cells_is_reported():
    """The exact contact begins at the highest of many peaks; cells see their mean."""
    heights = np.random.default_rng(0).uniform(0, 1e-3, 2000).tolist()
    rough = {"kind": "table", "radii": np.linspace(0, 1, 2000).tolist(), "heights": heights}
    scene = Scene.load("sphere").changed(
        load__normal_force=4 / 3 * 0.2**3,
        punch__profile=rough,
        wear={"times": [0.0, 0.01], "steady": False},
    )
    result, finer = (
        run(scene.changed(accuracy__rtol=rtol), methods=["mdr"]) for rtol in (1e-2, 1e-5)
    )
    assert any("the face is finer than the" in note for note in result.notes)
    error = np.abs(result["indentation"] / finer["indentation"] - 1)
    assert (error <= result.dataset.indentation_error).all()
    assert float(error.max()) > 1e-2


def test_no_pressure_under_a_flat_punch_is_negative():
    edges = 0.4 + np.geomspace(1e-14, 1e-8, 40)
    scene = FIVE.changed(
        accuracy__rtol=1e-3, wear__times=[0.0, 1e-8, 1e-4], output__radii=edges.tolist()
    )
    assert float(run(scene, methods=["mdr", "fem"]).dataset.pressure.min()) >= 0


@pytest.mark.parametrize(
    ("difference", "first", "second", "verdict"),
    [
        (0.9, 0.01, 0.01, "agree"),
        (1.9, 0.6, 0.6, "agree"),
        (2.1, 0.5, 0.5, "disagree"),
        (2.1, 1.2, 1.2, "undecided"),  # within the sum of the estimates, which are above rtol
        (30.0, 0.5, 1.1, "disagree"),  # beyond the sum of the estimates
        (3.0, 2.0, 2.5, "undecided"),
        (0.1, 0.5, 2.0, "undecided"),  # with an estimate above rtol, methods never agree
        (np.nan, 0.5, 0.5, "disagree"),
        (0.1, np.nan, 0.5, "undecided"),
    ],
)
def test_the_rule_of_the_verdict(difference, first, second, verdict):
    """The difference and both estimates are in units of rtol."""
    scene = FIVE.changed(wear__times=[0.1])
    rtol, solution = scene.accuracy.rtol, run(scene, methods=["mdr"]).solutions["mdr"]
    exact = solution.compared
    moved = exact | {"indentation": exact["indentation"] * (1 + difference * rtol)}
    both = {
        name: replace(solution, compared=checked, errors={"indentation": np.array([error * rtol])})
        for name, checked, error in (("mdr", moved, first), ("bem", exact, second))
    }
    rows = judge(scene, **both).agreement
    (row,) = (row for row in rows if row.quantity == "indentation")
    assert row.verdict == verdict


MM = {"units": "mm, N, MPa, s"}
# scenes in which anchors once did not hold although the results were right
RIGHT = {
    # at 3960 s, just before the knot, the force would be 1e-13 N
    "a force left by rounding": natural(
        {"radius": 6.0, "rings": 2, "wear_coefficients": [1e-9, 4e-9]},
        [0.0, 3600.0, 3960.0, 7560.0],
        1e-2,
        "mdr",
        half_space={"youngs_modulus": 1000.0},
        load={
            "sliding_speed": 200.0,
            "normal_force": {
                "times": [0.0, 3600.0, 3960.0000000000005, 7200.0, 7560.0],
                "values": [400.0, 400.0, 0.0, 0.0, 1.0],
            },
        },
        **MM,
    ),
    "the infinite pressure under a cone": natural(
        {
            "radius": 5.0,
            "rings": 5,
            "wear_coefficients": [1e-8, 1e-7],
            "profile": {"kind": "cone", "slope": 1.0},
        },
        [0.0, 100.0],
        methods="mdr",
        half_space={"plane_strain_modulus": 70.0},
        load={"normal_force": 175.0, "sliding_speed": 1000.0},
        **MM,
    ),
    # eight slow modes lie on the last ring, whose middle was one element of the small problem
    "modes of one wide ring": natural(
        {
            "ring_edges": [0.3, 0.34, 0.39, 1.0],
            "wear_coefficients": [0.0125, 1.0, 0.0125, 1.0],
        },
        [0.0, 1.0],
        1.5e-6,
        "mdr",
    ),
    # at a distance of 1e-12 from the dip, the coefficient is 1.3e-6 greater
    "a narrow dip": natural(
        {"wear_coefficient": {"radii": [0.394, 0.39438, 0.3948], "values": [1.0, 1e-3, 1.0]}},
        rtol=2e-7,
        methods="mdr",
    ),
    # squares of the pressures underflow
    "vanishing pressures": natural(
        {"ring_edges": [0.42, 1.0], "wear_coefficients": [1.0, 1.0]},
        [2.0, 40.0, 700.0],
        2e-5,
        "mdr",
        load={"indentation": 1.0},
    ),
}


@pytest.mark.parametrize("name", RIGHT)
def test_anchors_hold_where_results_are_right(name):
    assert [anchor for anchor in run(RIGHT[name]).anchors if not anchor.holds] == []
