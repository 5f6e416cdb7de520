"""Kinks of faces that are functions, detected or given by `kinks`, and infinite slopes."""

import numpy as np
import pytest
from groups import nightly
from natural import natural
from scipy.interpolate import PchipInterpolator

from ringwear import SceneError, run

FLAT_RADIUS = 0.4321
# truncated punches
FACES = (
    lambda r: 0.3 * np.maximum(r - FLAT_RADIUS, 0),
    lambda r: np.maximum(r - FLAT_RADIUS, 0) * (r + FLAT_RADIUS) / (2 * 2.0),
)
SCENE = natural(
    {"rings": 1, "wear_coefficients": [1.0, 1.0]},
    methods="mdr",
    load={"normal_force": 0.1},
    wear={"times": [0.0], "steady": False},
)


def shares_of_rings(slope, kinks, force, edges):
    """Return the force on each ring of a face in full contact (Galin; Sneddon).

    The pressure has the line density ``q = d - g`` with ``g(x) = x int_0^x f'(r) / sqrt(x^2 - r^2)
    dr``. Substitutions remove the roots at kinks and at the radius of each force.
    """
    node, weight = np.polynomial.legendre.leggauss(24)
    kinks = np.union1d(0.0, kinks)

    def gap(x):
        angles = np.arcsin(np.minimum(kinks / x[:, None], 1.0))
        half = np.diff(angles, append=np.pi / 2)[..., None] / 2
        radii = x[:, None, None] * np.sin(angles[..., None] + half * (1 + node))
        return x * ((slope(radii) * half) @ weight).sum(axis=1)

    def integral(values, start):
        cuts = np.union1d([start, 1.0], kinks[kinks > start])
        part, widths = (1 + node) / 2, np.diff(cuts)[:, None]
        x = (cuts[:-1, None] + widths * part**2).ravel()
        return values(x) @ (widths * part * weight).ravel()

    depth = force / 2 + integral(gap, 0.0)
    outside = [
        2 * integral(lambda x, b=b: (depth - gap(x)) * x / np.sqrt((x - b) * (x + b)), b)
        for b in edges[:-1]
    ]
    return np.diff([0.0, *(force - np.array(outside)), force])


# without gmsh, the start of finite elements is as accurate as the march
@pytest.mark.slow
@pytest.mark.gmsh
@pytest.mark.parametrize(("points", "height"), [(16, 1e-2), *nightly((48, 1e-3)), (150, 2e-4)])
def test_starts_of_tables(points, height):
    """Elements are fitted to up to 60 kinks; what they leave out beyond is stated as an error."""
    heights = height * np.random.default_rng(3).uniform(0, 1, points)
    heights[::2] = 0
    radii, edges = np.linspace(0, 1, points), [0.25, 0.5, 0.75, 1.0]
    scene = SCENE.changed(
        methods=["mdr", "fem"],
        load__normal_force=1.0,
        punch={
            "radius": 1.0,
            "ring_edges": edges,
            "wear_coefficients": [1.0, 2.0],
            "profile": {"kind": "table", "radii": radii.tolist(), "heights": heights.tolist()},
        },
    )
    slope = PchipInterpolator(radii, heights).derivative()
    exact = shares_of_rings(slope, radii, 1.0, edges)
    result = run(scene)
    assert result.verdict != "disagree"
    for method, solution in result.solutions.items():
        errors = result.dataset.ring_force.sel(solver=method).isel(time=0) - exact
        stated = float(solution.errors["ring_force"][0])
        assert float(np.abs(errors).max()) <= 1.5 * stated
        assert stated < (1e-5 if points < 60 else 2e-3)


def kinks_of(face, edges=(1.0,)):
    scene = SCENE.changed(
        punch={"radius": 1.0, "ring_edges": list(edges), "wear_coefficients": [1.0, 1.0]}
    )
    return scene.with_heights(face).problem.profile.kinks


KINKED = [
    *((face, edges, (FLAT_RADIUS,), 1e-9) for face in FACES for edges in ((1.0,), (0.3, 1.0))),
    # jumps of the curvature
    (lambda r: np.maximum(r - 0.8, 0) ** 2, (1.0,), (0.8,), 1e-5),
    (lambda r: np.abs(r - 0.25) + np.maximum(r - 0.61, 0) ** 2, (1.0,), (0.25, 0.61), 1e-5),
]


@pytest.mark.parametrize(("face", "edges", "kinks", "within"), KINKED)
def test_kinks_are_found(face, edges, kinks, within):
    assert kinks_of(face, edges) == pytest.approx(kinks, abs=within)


ROUGH = np.random.default_rng(1).uniform(0, 1, 300)
SMOOTH = {
    "flat": lambda r: 0 * r + 1,
    "parabola": lambda r: r**2,
    "power": lambda r: r**5.5,
    "waves": lambda r: 1 + np.sin(20 * r),
    "short waves": lambda r: 1 + np.sin(400 * r),
    "steep": lambda r: 1 + np.tanh(60 * (r - 0.5)),
    "noise": lambda r: 1e-3 * (1 + np.sin(1e4 * r) * np.cos(3e3 * r**2)),
    "roundoff": lambda r: 1e6 + r**2,
    "rough": lambda r: np.interp(r, np.linspace(0, 1, 300), ROUGH),
}


@pytest.mark.parametrize("name", SMOOTH)
def test_smooth_faces_have_no_kinks(name):
    assert kinks_of(SMOOTH[name]) == ()


def test_given_kinks_replace_detected_ones():
    scene = SCENE.changed(punch__radius=2.0, load__normal_force=0.1)
    with_kinks = scene.with_heights(lambda r: 0.1 * r**2, kinks=[0.5, 1.5])
    assert with_kinks.problem.profile.kinks == (0.25, 0.75)
    changed = with_kinks.changed(accuracy__rtol=1e-2)
    assert changed.problem.profile.kinks == (0.25, 0.75)
    # given kinks replace detected ones
    kinked = scene.with_heights(lambda r: np.abs(r - 1.0), kinks=[])
    assert kinked.problem.profile.kinks == ()


@pytest.mark.parametrize("kink", [-0.1, 1.2, float("nan")])
def test_kinks_outside_the_punch_are_refused(kink):
    with pytest.raises(SceneError, match=r"kinks .* give radii from 0 to punch\.radius"):
        SCENE.with_heights(lambda r: r**2, kinks=[kink])


def ball(radius, times, average="line", methods="mdr"):
    scene = natural(
        {"wear_coefficient": 1.0, "profile": {"kind": "ball", "ball_radius": radius}},
        methods=methods,
        load={"normal_force": 1e-4},
        wear={"times": times, "steady": False},
        output={"gradient_average": average},
    )
    return run(scene)


def mean_square_of_ball(radius, average):
    """Return the mean of ``r^2 / (R^2 - r^2)`` over the radius or the area."""
    if average == "line":
        return radius / 2 * np.log((radius + 1) / (radius - 1)) - 1
    return radius**2 * np.log(radius**2 / ((radius - 1) * (radius + 1))) - 1


@pytest.mark.slow
@pytest.mark.gmsh
def test_a_ball_as_wide_as_the_punch_has_no_rms_slope():
    result = ball(1.0, [0.0, 6.4, 106.0], methods="mdr fem")
    assert result.verdict == "agree"
    assert np.isnan(result.dataset.rms_slope).all()
    assert np.isnan(result.dataset.rms_slope_error).all()
    rows = result.summary["left_out_of_promise"]
    (row,) = (row for row in rows if row["quantity"] == "rms_slope")
    assert row["times"] == [0.0, 6.4, 106.0]
    assert "no finite value" in row["reason"]


@pytest.mark.slow
@pytest.mark.parametrize("average", ["line", "area"])
@pytest.mark.parametrize("excess", [1e-7, *nightly(1e-3, 1.0)])
def test_unworn_balls_have_the_slope_in_closed_form(excess, average):
    """At later times only the part in contact has worn; its slope is that of small angles."""
    result = ball(1 + excess, [0.0, 6.4], average)
    slope, error = (result.dataset[name].values[0] for name in ("rms_slope", "rms_slope_error"))
    exact = np.sqrt(mean_square_of_ball(1 + excess, average))
    assert abs(slope[0] / exact - 1) <= error[0]
    assert abs(slope[1] - exact) <= 0.2**2 * exact
    assert result.verdict != "disagree"
