"""The study of the paper: limits from both sides, methods against each other, and the files it writes."""

from __future__ import annotations

import argparse
import csv
import sys
from pathlib import Path

import numpy as np
import pytest
from mpmath import mp
from ringwear.mdr import direct
from ringwear.mdr.transforms import profile_transform
from ringwear.meshes.errors import SceneError
from ringwear.meshes.radial import alternating_edges, ring_areas
from ringwear.studies.methods.radial import mdr_model
from ringwear.studies.paper import arrangement, relaxation
from ringwear.studies.paper import study as paper
from ringwear.studies.paper.gradients import (
    RINGS,
    WEAR_RATIOS,
    FemGrams,
    alternating_pressures,
    compliance_grams,
    direct_gradients,
    homogeneous,
    many_rings,
    normalised,
    odd_and_even,
    slower_rings_alone,
)
from ringwear.studies.paper.running_in import SHARES, STATIONARY, RunningIn, paper_punch, running_in
from ringwear.studies.progress import Stages, silent
from threadpoolctl import threadpool_limits

from ringwear import Scene


@pytest.fixture(scope="module")
def scene() -> Scene:
    return Scene.load("five_rings")


@pytest.fixture(scope="module")
def found(scene: Scene) -> RunningIn:
    with threadpool_limits(1):
        return running_in(scene, silent)


@pytest.fixture(scope="module")
def written(scene: Scene, tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, list[str]]:
    """Everything, in its smaller version."""
    out = tmp_path_factory.mktemp("paper")
    return out, paper.conduct(scene, out, argparse.Namespace(fig=None, bem3d=False, quick=True), silent)


def read(path: Path) -> list[dict[str, str]]:
    with path.open(encoding="utf-8", newline="") as file:
        return list(csv.DictReader(file))


def test_homogeneous_punch() -> None:
    line, area = homogeneous()
    assert area == pytest.approx(4 / np.pi, rel=1e-12)
    assert line == pytest.approx(0.97399573592, rel=1e-10)


@pytest.mark.parametrize("rings", [2, 16, 64])
@pytest.mark.parametrize("width_ratio", [0.1, 1.0, 10.0])
def test_quadrature(rings: int, width_ratio: float, monkeypatch: pytest.MonkeyPatch) -> None:
    edges = alternating_edges(rings, width_ratio)
    values = direct_gradients(edges, np.array([1e-4, 3.0, 1e4]))
    monkeypatch.setattr(direct, "EDGE_NODES", 2 * direct.EDGE_NODES)
    np.testing.assert_allclose(values, direct_gradients(edges, np.array([1e-4, 3.0, 1e4])), rtol=1e-12)


@pytest.mark.parametrize("ratio", [1e-9, 0.1, 0.1999999, 0.2000001, 0.7, 1 - 1e-6])
def test_slope_where_series_and_closed_form_meet(ratio: float) -> None:
    found = direct.disc_slope(np.array([1.0]), np.array([ratio]), np.array([1 - ratio]))[0]
    with mp.workdps(40):
        exact = 4 / mp.pi * (mp.ellipe(mp.mpf(ratio) ** 2) - mp.ellipk(mp.mpf(ratio) ** 2)) / ratio
    assert found == pytest.approx(float(exact), rel=1e-9 if ratio > 0.99 else 1e-13)


def test_one_quadratic_form_serves_all_wear_ratios() -> None:
    ratios = np.array([1e-4, 0.3, 1.0, 20.0])
    edges = alternating_edges(5, 0.7)
    for ratio, values in zip(ratios, direct_gradients(edges, ratios).T, strict=True):
        pressures = direct.steady_pressures(edges, odd_and_even(5) @ [1.0, ratio])
        np.testing.assert_allclose(odd_and_even(5) @ alternating_pressures(edges, np.array([ratio]))[:, 0], pressures)
        for average, value, unit in zip(("line", "area"), values, homogeneous(), strict=True):
            assert value == pytest.approx(direct.rms_slope(edges, pressures, average) * np.pi / unit, rel=1e-12)


def test_gradient_by_mdr(scene: Scene) -> None:
    """The other theory: line densities, no elliptic integrals, no closed form of a ring."""
    natural = paper_punch(scene.changed(accuracy__rtol=1e-8), rings=4).natural
    grams = compliance_grams(mdr_model(natural, Stages("mdr")).compliance)
    found = normalised(grams, alternating_pressures(natural.edges, WEAR_RATIOS))
    np.testing.assert_allclose(found, direct_gradients(natural.edges, WEAR_RATIOS), rtol=1e-4)


@pytest.mark.parametrize(("rings", "width_ratio"), [(2, 1.0), (4, 0.1), (8, 10.0)])
def test_gradient_by_finite_elements(scene: Scene, rings: int, width_ratio: float) -> None:
    with threadpool_limits(1):
        values = FemGrams(scene).gradients(rings, width_ratio, WEAR_RATIOS)
    np.testing.assert_allclose(values, direct_gradients(alternating_edges(rings, width_ratio), WEAR_RATIOS), rtol=1e-3)


def test_many_rings_from_both_sides() -> None:
    limit = many_rings(np.array([0.0, 1e-4, 0.1, 10.0, 1e4, np.inf]), np.array(1.0))
    np.testing.assert_allclose(limit, limit[:, ::-1], rtol=1e-14)
    np.testing.assert_allclose(limit[:, 0], np.sqrt(1 + 4 / homogeneous() ** 2))
    ratios = np.array([1e-4, 0.1, 10.0, 1e4])
    distances = np.array([direct_gradients(alternating_edges(n), ratios) - limit[:, 1:5] for n in (32, 64, 128, 256)])
    assert (distances[:, :, :2] < 0).all()
    assert (distances[:, :, 2:] > 0).all()
    assert (np.abs(distances[1:] / distances[:-1]) < 0.65).all()


def test_many_rings_of_unequal_width() -> None:
    ratio = np.array([0.01])
    for width_ratio in (0.1, 10.0):
        limit = many_rings(ratio, np.array(width_ratio))
        distances = [np.abs(direct_gradients(alternating_edges(n, width_ratio), ratio) / limit - 1) for n in (64, 128, 256)]
        assert (np.diff(distances, axis=0) < 0).all()
        assert (distances[-1] < 0.02).all()
    # a material that is everywhere leaves a homogeneous punch
    assert many_rings(ratio, np.array(1e9)) == pytest.approx(1.0, abs=1e-6)


def test_symmetric_for_many_rings_only() -> None:
    skew = [direct_gradients(alternating_edges(n), np.array([0.01, 100.0]))[0] for n in (2, 16, 256)]
    quotients = [abs(values[1] / values[0] - 1) for values in skew]
    assert quotients[0] > 1.5
    assert quotients[2] < 0.02


@pytest.mark.parametrize("odd", [True, False])
def test_extreme_ratios_leave_the_slower_rings_alone(odd: bool) -> None:
    edges = alternating_edges(6, 2.0)
    value = direct_gradients(edges, np.array([1e9 if odd else 1e-9]))[:, 0]
    np.testing.assert_allclose(slower_rings_alone(edges, odd), value, rtol=1e-8)


def test_times_of_the_states(found: RunningIn) -> None:
    assert 100 * found.times[SHARES.index(0.7)] / found.stationary == pytest.approx(27, abs=0.5)
    for states in found.states.values():
        np.testing.assert_allclose(states.share, SHARES, atol=1e-3)
    assert found.reference.share(np.array([found.stationary]))[0] == pytest.approx(STATIONARY, rel=1e-9)


def test_methods_agree_in_every_state(found: RunningIn) -> None:
    first, *others = found.states.values()
    assert others
    for other in others:
        np.testing.assert_allclose(other.profile, first.profile, atol=1e-3)
        np.testing.assert_allclose(other.line_profile[1:], first.line_profile[1:], atol=1e-3)
    # at first only the rim wears, in a layer thinner than any element
    later = found.curve_times > 1e-3 * found.stationary
    for curves in found.curves.values():
        np.testing.assert_allclose(curves["line"][later], found.curves["mdr"]["line"][later], atol=1e-3)


def test_line_profile_is_equation_three(found: RunningIn) -> None:
    """Eq. 3 with its missing f(0), on the profile; the study takes it from the pressure."""
    natural = found.reference.natural
    inside = natural.radii > 0.02
    for state in (1, 3, 5):
        states = found.states["mdr"]
        by_profile = profile_transform(natural.radii, natural.radii[inside]) @ states.profile[state]
        np.testing.assert_allclose(states.line_profile[state][inside][:-5], by_profile[:-5], atol=1e-2)


def test_steady_pressures_in_units_of_the_paper(found: RunningIn) -> None:
    pressure = found.states["mdr"].pressure[-1]
    assert pressure.max() == pytest.approx(3.125)
    assert pressure.min() == pytest.approx(0.3125)
    assert (found.states["mdr"].pressure > 0).all()


def test_relaxation_times(scene: Scene, monkeypatch: pytest.MonkeyPatch) -> None:
    ratios = np.array([1e-4, 1.0, 10.0, 1e4])
    monkeypatch.setattr(relaxation, "WEAR_RATIOS", ratios)
    spectrum = relaxation.spectrum(scene, (5, 16), silent)
    assert spectrum.times[5][2, 0] == pytest.approx(0.3440589002, rel=1e-6)
    assert spectrum.times[16][1, 0] == pytest.approx(spectrum.homogeneous, rel=1e-6)
    limit = spectrum.many_rings(ratios)
    distances = [np.abs(spectrum.times[n][:, 0] / limit - 1)[[0, -1]] for n in (5, 16)]
    assert (distances[1] < distances[0]).all()


@pytest.mark.parametrize("slow_first", [True, False])
def test_arrangements_keep_the_shares(slow_first: bool) -> None:
    largest, smallest = (arrangement.best(3, slow_first, sign) for sign in (1.0, -1.0))
    equal = arrangement.gradient(arrangement.ring_edges(np.zeros(3), slow_first), slow_first)[0]
    assert smallest.line < equal < largest.line
    slow = odd_and_even(3)[:, 0 if slow_first else 1]
    for one in (largest, smallest):
        assert ring_areas(one.edges) @ slow / np.pi == pytest.approx(arrangement.SLOW_SHARE)


def test_files(written: tuple[Path, list[str]]) -> None:
    out, conclusions = written
    for name in ("fig4.png", "fig5.png", "fig6.png", "fig7.png", "relaxation.png"):
        assert (out / name).stat().st_size > 20_000
    for figure, ratio in (("fig6", "wear_ratio"), ("fig7", "width_ratio")):
        rows = read(out / f"{figure}.csv")
        assert list(rows[0]) == ["rings", ratio, "method", "line", "area"]
        for rings in (2, 4, 8):
            assert sum(row["rings"] == str(rings) and row["method"] == "direct" for row in rows) >= 200
        by_fem = [row for row in rows if row["method"] == "fem"]
        assert len(by_fem) >= 20
        curves = {(row["rings"], row[ratio]): float(row["line"]) for row in rows if row["method"] == "direct"}
        for row in by_fem:
            assert float(row["line"]) == pytest.approx(curves[row["rings"], row[ratio]], rel=1e-3)
    states = read(out / "fig4.csv")
    assert {row["state_percent"] for row in states} == {"0", "10", "30", "50", "70", "90", "100"}
    assert {"mdr", "fem"} <= {row["method"] for row in read(out / "fig5.csv")}
    assert any("2.284" in line for line in conclusions)


def test_claims(written: tuple[Path, list[str]]) -> None:
    out, conclusions = written
    rows = [line for line in (out / "claims.md").read_text("utf-8").splitlines() if line.startswith("| ") and "**" in line]
    assert len(rows) > 25
    assert all(line.count(" | ") == 5 for line in rows)
    refuted = [line for line in rows if "does not hold" in line]
    assert len(refuted) == 1
    assert "2.4" in refuted[0]
    assert any(line.startswith("claims:") for line in conclusions)


def test_one_figure_only(scene: Scene, tmp_path: Path) -> None:
    paper.conduct(scene, tmp_path, argparse.Namespace(fig=5, bem3d=False, quick=True), silent)
    assert sorted(file.name for file in tmp_path.iterdir()) == ["fig5.csv", "fig5.png"]


def test_missing_library(scene: Scene, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "tamaas", None)
    with pytest.raises(SceneError, match="bem3d"):
        paper.conduct(scene, tmp_path, argparse.Namespace(fig=6, bem3d=True, quick=True), silent)


@pytest.mark.slow
def test_three_dimensions() -> None:
    pytest.importorskip("tamaas")
    from ringwear.studies.paper import three_dimensions as bem3d

    coarse, fine = bem3d.grid_errors(48), bem3d.grid_errors(128)
    assert fine.indentation < 2e-3
    assert fine.flat_forces < 2e-3
    assert fine.steady_forces < coarse.steady_forces / 1.8


def test_curves_cover_the_paper() -> None:
    assert RINGS == (2, 4, 8, 16, 32, 64)
    for ratio in (1e-4, 0.01, 1.0, 100.0, 1e4):
        assert ratio in WEAR_RATIOS
