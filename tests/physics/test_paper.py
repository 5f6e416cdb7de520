"""The study of the paper: quadratures, limits, agreement of methods, and its files."""

import numpy as np
import pandas as pd
import pytest

from ringwear import Scene, run, study
from ringwear.studies.paper.running_in import FiveRings

pytestmark = pytest.mark.slow

# states of Fig. 4 by the completed fraction of the change of the greatest displacement, and the
# fraction at which the paper's run ends
FRACTIONS, LAST_FRACTION = (0, 0.1, 0.3, 0.5, 0.7, 0.9, 1), 0.984


@pytest.fixture(scope="module")
def five():
    return FiveRings(Scene.load("five_rings"))


@pytest.fixture(scope="module")
def written(tmp_path_factory):
    """Folder with the files of the quick study."""
    out = tmp_path_factory.mktemp("paper")
    study("paper", "five_rings", quick=True).save(out)
    return out


@pytest.mark.gmsh
def test_times_of_the_states(five):
    assert float(five.states.time[4]) == pytest.approx(0.27, abs=0.005)
    for way, tolerance in zip(five.states.way.values, (1e-7, 1e-5, 1e-5), strict=True):
        np.testing.assert_allclose(way, FRACTIONS, atol=tolerance)
    stationary = five.scene.changed(accuracy__rtol=1e-8, wear__times=[five.stationary])
    worn = run(stationary, ["mdr"]).dataset
    completed = (worn.displacement_max - 1) / (worn.steady_displacement_max - 1)
    assert completed.item() == pytest.approx(LAST_FRACTION, rel=1e-9)


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
    # g(x) = f(0) + x int_0^x f'(r) / sqrt(x^2 - r^2) dr, with a constant slope between radii
    x, profile = radii[inside, None], states.f_over_d0.values
    angles = np.arcsin(np.minimum(radii / x, 1.0))
    slopes = np.diff(profile) / np.diff(radii)
    by_profile = profile[:, :1] + slopes @ (x * np.diff(angles)).T
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


@pytest.mark.gmsh
def test_the_study_writes_figures_and_tables(written):
    # the many rows of curves are no tables for a paper
    expected = {f"fig{number}.{end}" for number in (4, 5, 6, 7) for end in ("png", "csv")}
    expected |= {f"claims.{end}" for end in ("csv", "md", "tex")} | {"report.html"}
    assert {file.name for file in written.iterdir() if file.name[0] != "."} == expected
    for number in (6, 7):
        rows = pd.read_csv(written / f"fig{number}.csv")
        assert set(rows.rings) == {2, 4, 8}
        by_fem = rows.dropna()
        assert len(by_fem) >= 30
        np.testing.assert_allclose(by_fem.fem, by_fem.direct, rtol=5e-4)
    assert set(pd.read_csv(written / "fig4.csv").solver) == {"mdr", "fem", "bem"}


def test_one_of_ten_claims_does_not_hold(written):
    claims = pd.read_csv(written / "claims.csv")
    assert len(claims) == 10
    (refuted,) = claims[claims.finding == "does not hold"].values.tolist()
    assert "2.4" in refuted[1]
    assert "2.2840" in refuted[2]
