"""The study of the paper.

Limits from both sides, methods against each other, and the files it writes.
"""

from __future__ import annotations

import argparse
import csv
from pathlib import Path

import numpy as np
import pytest
from conftest import Prepare
from mpmath import mp

from ringwear import Scene
from ringwear.mdr import direct
from ringwear.mdr.transforms import profile_transform
from ringwear.meshes.radial import alternating_edges, ring_areas
from ringwear.studies.extremes.reference import Reference
from ringwear.studies.paper import study as paper
from ringwear.studies.paper.gradients import (
    WEAR_RATIOS,
    compliance_grams,
    direct_gradients,
    fem_grams,
    gradients,
    homogeneous,
    many_rings,
    odd_and_even,
)
from ringwear.studies.paper.running_in import (
    CURVE,
    SHARES,
    STATIONARY,
    FiveRings,
    five_rings,
    many_ring_times,
    relaxation_times,
)


@pytest.fixture(scope="module")
def five() -> FiveRings:
    return five_rings(Scene.load("five_rings").problem)


@pytest.fixture(scope="module")
def written(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, list[str]]:
    """Everything, in its smaller version."""
    out = tmp_path_factory.mktemp("paper")
    return out, conduct(out)


def conduct(out: Path, fig: int | None = None) -> list[str]:
    return paper.conduct(Scene.load("five_rings"), out, argparse.Namespace(fig=fig, quick=True))


def read(path: Path) -> list[dict[str, str]]:
    with path.open(encoding="utf-8", newline="") as file:
        return list(csv.DictReader(file))


@pytest.mark.parametrize("rings", [2, 16, 64])
@pytest.mark.parametrize("width_ratio", [0.1, 1.0, 10.0])
def test_slopes_against_carlsons_integrals(rings: int, width_ratio: float) -> None:
    """The quadrature that all curves rest on, against one of another kind."""
    edges = alternating_edges(rings, width_ratio)
    line, _ = direct.slope_gram(edges, odd_and_even(rings))
    np.testing.assert_allclose(line, Reference(edges).grams[0], rtol=1e-9)


@pytest.mark.parametrize("ratio", [1e-9, 0.1, 0.1999999, 0.2000001, 0.7, 1 - 1e-6])
def test_slope_where_series_and_closed_form_meet(ratio: float) -> None:
    value = direct.disc_slope(np.array([1.0]), np.array([ratio]))[0]
    with mp.workdps(40):
        exact = 4 / mp.pi * (mp.ellipe(mp.mpf(ratio) ** 2) - mp.ellipk(mp.mpf(ratio) ** 2)) / ratio
    assert value == pytest.approx(float(exact), rel=1e-9 if ratio > 0.99 else 1e-13)


def test_one_quadratic_form_serves_all_wear_ratios() -> None:
    ratios = np.array([1e-4, 0.3, 1.0, 20.0])
    edges = alternating_edges(5, 0.7)
    for ratio, values in zip(ratios, direct_gradients(edges, ratios).T, strict=True):
        pressures = direct.steady_pressures(edges, odd_and_even(5) @ [1.0, ratio])
        alone = [direct.rms_slope(edges, pressures, average) for average in ("line", "area")]
        np.testing.assert_allclose(values, np.array(alone) * np.pi / homogeneous(), rtol=1e-12)


def test_gradient_by_mdr(prepare: Prepare) -> None:
    """The other theory: line densities, no elliptic integrals, no closed form of a ring."""
    ready = prepare("five_rings", "mdr", accuracy__rtol=1e-8)
    edges = ready.problem.ring_edges
    values = gradients(compliance_grams(ready.compliance), edges, WEAR_RATIOS)
    np.testing.assert_allclose(values, direct_gradients(edges, WEAR_RATIOS), rtol=1e-4)


@pytest.mark.parametrize(("rings", "width_ratio"), [(2, 1.0), (4, 0.1), (8, 10.0)])
def test_gradient_by_finite_elements(rings: int, width_ratio: float) -> None:
    edges, grams = (
        alternating_edges(rings, width_ratio),
        fem_grams(Scene.load("five_rings").problem, rings, width_ratio),
    )
    np.testing.assert_allclose(
        gradients(grams, edges, WEAR_RATIOS), direct_gradients(edges, WEAR_RATIOS), rtol=5e-4
    )


def test_many_rings_from_both_sides() -> None:
    limit = many_rings(np.array([0.0, 1e-4, 0.1, 10.0, 1e4, np.inf]), np.ones(1))
    np.testing.assert_allclose(limit, limit[:, ::-1], rtol=1e-14)
    np.testing.assert_allclose(limit[:, 0], np.sqrt(1 + 4 / homogeneous() ** 2))
    ratios = np.array([1e-4, 0.1, 10.0, 1e4])
    distances = np.array(
        [direct_gradients(alternating_edges(n), ratios) - limit[:, 1:5] for n in (32, 64, 128, 256)]
    )
    assert (distances[:, :, :2] < 0).all()
    assert (distances[:, :, 2:] > 0).all()
    assert (np.abs(distances[1:] / distances[:-1]) < 0.65).all()


def test_many_rings_of_unequal_width() -> None:
    ratio = np.array([0.01])
    for width_ratio in (0.1, 10.0):
        limit = many_rings(ratio, np.array([width_ratio]))
        distances = [
            np.abs(direct_gradients(alternating_edges(n, width_ratio), ratio) / limit - 1)
            for n in (64, 128, 256)
        ]
        assert (np.diff(distances, axis=0) < 0).all()
        assert (distances[-1] < 0.02).all()
    # a material that is everywhere leaves a homogeneous punch
    assert many_rings(ratio, np.array([1e9])) == pytest.approx(1.0, abs=1e-6)


@pytest.mark.parametrize("odd", [True, False])
def test_extreme_ratios_leave_the_slower_rings_alone(odd: bool) -> None:
    edges = alternating_edges(6, 2.0)
    nearly, alone = direct_gradients(edges, np.array([1e9, np.inf] if odd else [1e-9, 0.0])).T
    np.testing.assert_allclose(alone, nearly, rtol=1e-8)
    slow = odd_and_even(6)[:, 0 if odd else 1]
    line = direct.rms_slope(edges, slow / (ring_areas(edges) @ slow), "line")
    assert alone[0] == pytest.approx(line * np.pi / homogeneous()[0], rel=1e-12)


def test_times_of_the_states(five: FiveRings) -> None:
    assert 100 * five.times[SHARES.index(0.7)] / five.stationary == pytest.approx(27, abs=0.5)
    np.testing.assert_allclose(five.reference.share(five.times), SHARES, atol=1e-7)
    np.testing.assert_allclose(five.coarser.share(five.times), SHARES, atol=1e-3)
    assert five.reference.share(np.array([five.stationary]))[0] == pytest.approx(
        STATIONARY, rel=1e-9
    )


def test_methods_agree_in_every_state(five: FiveRings) -> None:
    first, *others = five.states.values()
    assert len(others) == 2
    for other in others:
        np.testing.assert_allclose(other.profile, first.profile, atol=1e-3)
        np.testing.assert_allclose(other.line_profile[1:], first.line_profile[1:], atol=1e-3)
    # at first only the rim wears, in a layer thinner than any element
    for curve in five.curves.values():
        np.testing.assert_allclose(
            curve.gradients[CURVE > 1e-3], five.curves["mdr"].gradients[CURVE > 1e-3], atol=1e-3
        )


def test_line_profile_is_equation_three(five: FiveRings) -> None:
    """Eq. 3 with its missing f(0), on the profile; the study takes it from the pressure."""
    radii, states = five.reference.problem.radii, five.states["mdr"]
    inside = np.flatnonzero(radii > 0.02)[:-5]
    by_profile = states.profile @ profile_transform(radii, radii[inside]).T
    np.testing.assert_allclose(states.line_profile[1:-1, inside], by_profile[1:-1], atol=1e-2)


def test_steady_state_in_units_of_the_paper(five: FiveRings) -> None:
    """Of 25 equal areas 15 are slow and 10 fast.

    ``p1 = 1/(2 (0.6 + 0.04))`` ... times ``2 p0`` (Eq. 26).
    """
    states = five.states["mdr"]
    slow = 2 / (0.6 + 0.4 / 10)
    assert (states.pressure[-1].max(), states.pressure[-1].min()) == pytest.approx(
        (slow, slow / 10)
    )
    assert (states.pressure > 0).all()
    np.testing.assert_allclose(states.profile[-1], five.limiting["profile"], atol=1e-5)


def test_relaxation_times() -> None:
    times = relaxation_times(Scene.load("five_rings").problem, (5, 16))
    slowest = {count: values[:, 0] for count, values in times.items()}
    # of one material the rings do not matter
    assert slowest[16].max() == pytest.approx(slowest[5].max(), rel=1e-6)
    distances = {
        count: np.abs(one / many_ring_times(one.max()) - 1)[[0, -1]]
        for count, one in slowest.items()
    }
    assert (distances[16] < distances[5]).all()


def test_files(written: tuple[Path, list[str]]) -> None:
    out, conclusions = written
    names = ("fig4", "fig5", "fig6", "fig7", "relaxation")
    assert {file.name for file in out.iterdir()} == {
        *(f"{name}{end}" for name in names for end in (".png", ".csv")),
        "claims.csv",
        "paper.md",
    }
    for name, ratio in (("fig6", "wear_ratio"), ("fig7", "width_ratio")):
        rows = read(out / f"{name}.csv")
        values = {(row["method"], row["rings"], row[ratio]): float(row["line"]) for row in rows}
        assert {count for method, count, _ in values if method == "direct"} == {"2", "4", "8"}
        by_fem = {key: value for key, value in values.items() if key[0] == "fem"}
        assert len(by_fem) >= 20
        for (_, *key), value in by_fem.items():
            assert value == pytest.approx(values["direct", *key], rel=5e-4)
    assert {row["state_percent"] for row in read(out / "fig4.csv")} == {
        "0",
        "10",
        "30",
        "50",
        "70",
        "90",
        "100",
    }
    assert {row["method"] for row in read(out / "fig5.csv")} == {"mdr", "fem", "bem"}
    assert any("2.284" in line for line in conclusions)


def test_claims(written: tuple[Path, list[str]]) -> None:
    out, conclusions = written
    claims = read(out / "claims.csv")
    assert len(claims) == 30
    (refuted,) = (row for row in claims if row["verdict"] == "does not hold")
    assert "2.4" in refuted["the paper says"]
    assert refuted["why, or what to add"]
    assert any(line.startswith("claims:") for line in conclusions)


def test_one_figure_only(tmp_path: Path) -> None:
    conduct(tmp_path, fig=5)
    assert sorted(file.name for file in tmp_path.iterdir()) == ["fig5.csv", "fig5.png", "paper.md"]
