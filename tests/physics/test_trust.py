"""Numbers that once were wrong although the verdict was "agree", against exact results."""

from dataclasses import replace

import numpy as np
import pytest
from given import judge
from groups import nightly, slow
from natural import natural

from ringwear import ComplianceMethod, Scene, energy, method as named, run

FIVE = Scene.load("five_rings")


def check_start(result):
    """Assert that reported start pressures are within rtol of Eq. 10, except at the rim."""
    pressure, scene = result.dataset.pressure.isel(time=0), result.scene
    ratio = pressure.radius / scene.punch.radius
    ratio = ratio.where(ratio < 1)
    exact = scene.load_.normal_force / (2 * np.pi * scene.punch.radius**2)
    error = pressure.where(ratio < 1) * np.sqrt((1 - ratio) * (1 + ratio)) / exact - 1
    assert float(np.abs(error).max()) <= scene.accuracy.rtol, scene.title


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
    check_start(result)
    edges, rings = np.arange(5) / 5, result.summary["answer"]["mdr"]
    exact = 1 / np.pi / np.sqrt((1 - edges) * (1 + edges))
    np.testing.assert_allclose(rings["pressure_min"][0], exact, rtol=rtol)
    np.testing.assert_allclose(rings["pressure_max"][0][:-1], exact[1:], rtol=rtol)
    assert result.verdict != "disagree"


@pytest.mark.slow
@pytest.mark.parametrize(
    ("standoff", "indentation"),
    [(0.2, None), (100.0, 1e-4), *nightly((100.0, 0.1), (100.0, None))],
)
def test_results_do_not_depend_on_the_face_plane(standoff, indentation):
    """Two rings, the inner one recessed, with the whole face at a distance from the face plane."""

    def results(standoff):
        force = {"normal_force": 0.1}
        rings = {"rings": 2, "wear_coefficients": [1.0, 2.0], "recess": [0.1 + standoff, standoff]}
        load = force if indentation is None else {"indentation": standoff + indentation}
        return run(natural(rings, [0.0, 1.0, 5.0], methods="mdr", load=load)).dataset

    plain, moved = results(0.0), results(standoff)
    depth = float(plain.indentation.max())
    # the distance of the face causes roundoff of its heights
    roundoff = max(1e-9, 1e-14 * standoff / depth)
    for name in ("pressure", "normal_force", "ring_worn_volume", "contact_radius"):
        scale = float(np.abs(plain[name]).max())
        np.testing.assert_allclose(moved[name] / scale, plain[name] / scale, rtol=0, atol=roundoff)
    for name in ("indentation", "profile"):
        height, error = (moved[name] - standoff) / depth, f"{name}_error"
        np.testing.assert_allclose(height, plain[name] / depth, atol=roundoff)
        np.testing.assert_allclose(moved[error], plain[error], rtol=1e-2, atol=1e-9)


def worn_sphere(rtol, times, method="mdr", **changes):
    """Return dataset, at 1200 radii, and notes of a sphere whose first contact radius is 0.2."""
    scene = Scene.load("sphere").changed(
        load__normal_force=4 / 3 * 0.2**3,
        wear={"times": times, "steady": False},
        output__radii=((np.arange(1200) + 0.5) / 1200).tolist(),
        accuracy__rtol=rtol,
        **changes,
    )
    result = run(scene, methods=[method])
    return result.dataset.isel(solver=0), result.notes


class Halved(ComplianceMethod):
    """MDR on cells that are half as large; it is not refined further."""

    name = "halved"

    def discretise(self, problem, stages):
        ready = named("mdr").discretise(problem, stages)
        space = ready.compliance.space
        halves = space.no_wider(0.51 * np.diff(space.breakpoints))
        return replace(
            ready, compliance=energy.compliance(halves), coarser=lambda: ready.compliance
        )

    def sizes_given(self, problem):
        return True


@pytest.fixture(scope="module")
def truth():
    return worn_sphere(1e-5, [0.01, 0.1, 1.0], Halved())[0]


@pytest.mark.slow
@pytest.mark.parametrize("rtol", [1e-3, *nightly(1e-4)])
def test_estimates_bound_the_errors_of_a_worn_sphere(truth, rtol):
    """Errors, in their norms, are below the estimates."""
    result, _ = worn_sphere(rtol, truth.time.values.tolist())
    wrong = np.abs(result - truth)
    squares = [(data.pressure**2 * truth.radius).sum("radius") for data in (wrong, truth)]
    assert (np.sqrt(squares[0] / squares[1]) <= result.pressure_error).all()
    for name in ("profile", "displacement", "indentation"):
        greatest = wrong[name].max(set(wrong[name].dims) - {"time"})
        assert (greatest / truth.indentation <= result[f"{name}_error"]).all(), name


@pytest.mark.parametrize("name", ["contact_radius", "profile", "indentation"])
def test_estimates_at_a_single_time_bound_the_errors(single_time, name):
    """Two meshes may agree by chance at one time; estimates use errors at nearby times, too."""
    result, truth = single_time
    wrong = np.abs(result[name] - truth[name])
    scale = 1.0 if name == "contact_radius" else truth.indentation
    assert float((wrong / scale).max()) <= float(result[f"{name}_error"].max())


@pytest.fixture(scope="module")
def single_time():
    radius, force = 1.58, 0.107
    scene = natural(
        {
            "wear_coefficient": 1.0,
            "profile": {"kind": "parabola", "curvature_radius": radius},
        },
        methods="mdr",
        load={"normal_force": force},
        wear={"times": [0.3], "steady": False},
    )
    runs = (run(scene.changed(accuracy__rtol=rtol)).dataset for rtol in (1e-3, 1e-5))
    return [data.isel(solver=0) for data in runs]


@pytest.mark.slow
def test_a_face_finer_than_the_cells_is_reported():
    """The exact contact begins at the highest of many peaks; cells see their mean."""
    heights = np.random.default_rng(0).uniform(0, 1e-3, 2000).tolist()
    radii = np.linspace(0, 1, 2000).tolist()
    rough = {"punch__profile": {"kind": "table", "radii": radii, "heights": heights}}
    result, notes = worn_sphere(1e-2, [0.0, 0.01], **rough)
    assert any("the face is finer than the" in note for note in notes)
    finer = worn_sphere(1e-5, [0.0, 0.01], Halved(), **rough)[0].indentation
    error = np.abs(result.indentation - finer) / finer
    assert (error <= result.indentation_error).all()
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
