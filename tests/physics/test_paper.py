"""The study of the paper: quadratures, limits, agreement of methods, and its files."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pandas as pd
import pytest
from scipy.integrate import quad

from ringwear import Rings, Scene, alternating_edges, direct, run, study, sweep
from ringwear.mdr.transforms import profile_transform
from ringwear.studies.paper.running_in import FiveRings, completed_fraction
from ringwear.studies.paper.theory import (
    STATE_PERCENTAGES,
    STATIONARY_FRACTION,
    homogeneous,
    many_rings,
)

RATIOS = 10.0 ** np.linspace(-4, 4, 9)


@pytest.fixture(scope="module")
def five():
    return FiveRings(Scene.load("five_rings"))


@pytest.fixture(scope="module")
def written(tmp_path_factory):
    """Folder with the files of the quick study."""
    out = tmp_path_factory.mktemp("paper")
    study("paper", "five_rings", quick=True).save(out)
    return out


def gradients_of(count, wear_ratios, width_ratio=1.0):
    """Return (2, M) normalised RMS gradients of alternating rings by direct integration."""
    rings = [Rings.alternating(count, width_ratio, ratio) for ratio in wear_ratios]
    pressures = np.stack([np.pi * direct.steady_pressures(*each) for each in rings], axis=1)
    edges = rings[0].ring_edges
    slopes = [direct.rms_slope(edges, pressures, average) for average in ("line", "area")]
    return np.array(slopes) / homogeneous()[:, None]


@pytest.mark.parametrize("width_ratio", [0.1, 10.0])
def test_slopes_against_another_quadrature(width_ratio):
    """Compare the quadrature behind all curves with an adaptive one between ring edges.

    At ring edges, slopes have logarithmic poles.
    """
    edges = alternating_edges(8, width_ratio)
    pressures = np.where(np.arange(8) % 2, 0.01, 1.0)
    steps = direct.pressure_steps(pressures)

    def square(radius):
        return float(direct.disc_slope(edges[1:], np.array(radius)) @ steps) ** 2

    squares = [quad(square, *ends, epsabs=0.0, epsrel=1e-10)[0] for ends in pairwise(edges)]
    assert direct.rms_slope(edges, pressures) == pytest.approx(np.sqrt(sum(squares)), rel=1e-9)


def test_rms_slopes_by_mdr_against_direct_integration():
    """MDR uses line densities, and neither elliptic integrals nor closed forms of rings."""
    base = Scene.load("five_rings").changed(methods=["mdr"], accuracy__rtol=1e-8, wear__times=[])
    ratios = {"punch.wear_ratio": RATIOS.tolist()}
    for average, exact in zip(("line", "area"), gradients_of(5, RATIOS), strict=True):
        averaged = base.changed(output__gradient_average=average)
        slopes = sweep(averaged, ratios, ["steady_rms_slope"]).steady_rms_slope[:, 0]
        unit = homogeneous()[("line", "area").index(average)] * 2 / np.pi
        np.testing.assert_allclose(slopes / unit, exact, rtol=1e-4)


def test_many_rings_approach_their_limit_from_both_sides():
    ratios = np.array([1e-4, 0.1, 10.0, 1e4])
    limit = many_rings(ratios, np.ones(1))
    np.testing.assert_allclose(limit, limit[:, ::-1], rtol=1e-14)
    extreme = many_rings(np.array([0.0, 1e16]), np.ones(1))
    np.testing.assert_allclose(extreme.T, [np.sqrt(1 + 4 / homogeneous() ** 2)] * 2)
    distances = np.array([gradients_of(count, ratios) - limit for count in (32, 64, 128, 256)])
    assert (distances[:, :, :2] < 0).all()
    assert (distances[:, :, 2:] > 0).all()
    assert (np.abs(distances[1:] / distances[:-1]) < 0.65).all()


@pytest.mark.slow
def test_many_rings_of_unequal_width():
    ratio = np.array([0.01])
    for width_ratio in (0.1, 10.0):
        limit = many_rings(ratio, np.array([width_ratio]))
        distances = [
            np.abs(gradients_of(count, ratio, width_ratio) / limit - 1) for count in (64, 128, 256)
        ]
        assert (np.diff(distances, axis=0) < 0).all()
        assert (distances[-1] < 0.02).all()
    # if one material covers nearly all of the face, the punch is homogeneous
    assert many_rings(ratio, np.array([1e9])) == pytest.approx(1.0, abs=1e-6)


@pytest.mark.gmsh
def test_times_of_the_states(five):
    assert float(five.states.time[4]) == pytest.approx(0.27, abs=0.005)
    for way, tolerance in zip(five.states.way.values, (1e-7, 1e-5, 1e-5), strict=True):
        np.testing.assert_allclose(way, np.array(STATE_PERCENTAGES) / 100, atol=tolerance)
    stationary = five.scene.changed(accuracy__rtol=1e-8, wear__times=[five.stationary])
    assert completed_fraction(run(stationary, ["mdr"]).dataset).item() == pytest.approx(
        STATIONARY_FRACTION, rel=1e-9
    )


def test_methods_agree_in_every_state(five):
    assert five.states.solver.values.tolist() == ["mdr", "fem", "bem"]
    for name in ("f_over_d0", "g_over_d0"):
        for later in five.states[name][1:, 1:].values:
            np.testing.assert_allclose(later, five.states[name][0, 1:], atol=1e-3)
    # earlier, only a layer at the rim has worn, which is thinner than any element
    later = five.history[:, :, five.history.time.values > 1e-3].values
    np.testing.assert_allclose(later, later[:, [0, 0, 0]], atol=1e-3)


def test_line_profile_is_equation_three(five):
    """Eq. 3 with its missing f(0), applied to the profile; the study integrates the pressure."""
    radii, states = five.states.radius.values, five.states.sel(solver="mdr")
    inside = np.flatnonzero(radii > 0.02)[:-5]
    by_profile = states.f_over_d0.values @ profile_transform(radii, radii[inside]).T
    by_pressure = states.g_over_d0.values[:, inside]
    np.testing.assert_allclose(by_pressure[1:-1], by_profile[1:-1], atol=1e-2)


def test_steady_state_in_units_of_the_paper(five):
    """Of 25 equal areas, 15 wear slowly and 10 ten times faster.

    Hence the slow rings have the pressure ``p1 = 2 p0 / (0.6 + 0.4 / 10)`` (Eq. 26).
    """
    pressure = five.states.p_over_p0.values
    slow = 2 / (0.6 + 0.4 / 10)
    assert (pressure[0, -1].max(), pressure[0, -1].min()) == pytest.approx((slow, slow / 10))
    assert (pressure > 0).all()
    np.testing.assert_allclose(
        five.states.f_over_d0[0, -1], five.states.limiting_f_over_d0.values, atol=1e-5
    )


@pytest.mark.slow
@pytest.mark.gmsh
def test_the_study_writes_figures_and_tables(written):
    endings = ("png", "csv", "md", "tex")
    expected = {f"fig{number}.{end}" for number in (4, 5, 6, 7) for end in endings}
    expected |= {f"claims.{end}" for end in endings if end != "png"} | {"report.html"}
    assert {file.name for file in written.iterdir() if file.name[0] != "."} == expected
    for number in (6, 7):
        rows = pd.read_csv(written / f"fig{number}.csv")
        assert set(rows.rings) == {2, 4, 8}
        by_fem = rows.dropna()
        assert len(by_fem) >= 50
        np.testing.assert_allclose(by_fem.fem, by_fem.direct, rtol=5e-4)
    assert set(pd.read_csv(written / "fig4.csv").solver) == {"mdr", "fem", "bem"}


@pytest.mark.slow
def test_one_of_ten_claims_does_not_hold(written):
    claims = pd.read_csv(written / "claims.csv")
    assert len(claims) == 10
    (refuted,) = claims[claims.verdict == "does not hold"].values.tolist()
    assert "2.4" in refuted[1]
    assert "2.2840" in refuted[2]
