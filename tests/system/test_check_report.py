"""Texts, page and figures of a check are about the checked results first, then about ours."""

import json
import re
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pandas as pd
import pytest

from ringwear import Scene, check, load, main, run

SCENE = Scene(
    title="Two materials",
    units="SI",
    methods=["mdr", "bem"],
    punch={"radius": 0.01, "ring_edges": [0.005, 0.01], "wear_coefficients": [1e-15, 1e-13]},
    half_space={"plane_strain_modulus": 2e9},
    load={"normal_force": 100.0, "sliding_speed": 0.1},
    wear={"times": [0.0, 1e4]},
    accuracy={"rtol": 1e-3},
)
DEPTH = 100 / (2 * 0.01 * 2e9)
"""Indentation of the flat start, F / (2 a E*), in metres."""


def start(factor):
    """Return the indentation of the flat start times a factor."""
    return pd.DataFrame({"time": [0.0], "indentation": [factor * DEPTH]})


def text_of(page):
    """Return the text of a page in its order, without images and styles."""
    text = re.sub(r"(?s)<(style|script).*?</\1>", "", page)
    return re.sub(r"\s+", " ", re.sub(r"<[^>]*>", " ", text))


def banners_on(page):
    """Return colour, word and sentence of the verdict on each program."""
    return re.findall(r'(?s)<p class="verdict (\S+)"><strong>(.*?)</strong>(.*?)</p>', page)


@pytest.fixture(scope="module", params=[0.941, 1.001], ids=["wrong", "right"])
def folder(request, tmp_path_factory):
    out = tmp_path_factory.mktemp("check")
    (out / "scene.toml").write_text(SCENE.to_toml(), "utf-8")
    start(request.param).to_csv(out / "abaqus.csv", index=False)
    call = ["check", str(out / "scene.toml"), str(out / "abaqus.csv"), "--out", str(out / "out")]
    assert main(call) == (0 if request.param > 1 else 3)
    return out / "out", request.param


def test_the_page_begins_with_the_verdict_on_the_file(folder):
    out, factor = folder
    page = (out / "report.html").read_text("utf-8")
    assert re.search(r"<title>(.*?)</title>", page)[1] == "abaqus.csv checked against Two materials"
    ((colour, word, sentence),) = banners_on(page)
    right = factor > 1
    assert (colour, word) == (("agree", "within 1 %") if right else ("disagree", "not within 1 %"))
    assert "abaqus.csv: " in sentence
    explained = re.search(r"(explains?|is consistent with) the difference", sentence)
    assert bool(explained) != right
    text = text_of(page)
    # the first table has the errors of the file; our own methods come after it
    table = text.index("quantity within 1 %")
    error = "0.1 % too high" if right else "5.9 % too low"
    row = text.index(f"indentation {'yes' if right else 'NO'} {error} t = 0 s")
    ours = text.index("Our own methods")
    assert text.index(word) < table < row < ours < text.index("The methods agree")
    assert ours < text.index("Our answer")


def test_the_printed_text_begins_with_the_verdict_on_the_results():
    checked = check(SCENE, {"abaqus": start(0.941)})
    printed = str(checked).splitlines()
    assert printed[0] == "abaqus checked against Two materials"
    assert printed[2].startswith("abaqus: 1 of 1 quantities differ ")
    assert printed[2].endswith(" more than 0.01: indentation")
    assert printed[3].startswith("abaqus: indentation: 5.9 % too low")
    assert printed[-1].startswith("Our own methods: The methods agree")
    shown = checked._repr_html_()
    assert shown.index("5.9 % too low") < shown.index("The methods agree") < shown.index("<img")


def test_results_that_are_read_back_say_the_same(folder):
    out, factor = folder
    text = str(load(out))
    assert text.splitlines()[0] == "abaqus.csv checked against Two materials"
    assert ("within 0.01 of ours" in text) == (factor > 1)
    summary = json.loads((out / "summary.json").read_text("utf-8"))
    assert summary["check"]["passes"] == (factor > 1)
    assert summary["verdict"] == "agree"


def test_the_banner_says_that_our_methods_disagree(tmp_path):
    """Results within the tolerance then prove nothing, and the check does not pass."""
    checked = check(SCENE, {"abaqus": start(1.001)})
    judgement = SimpleNamespace(verdict="disagree", anchors=(), left_out_of_promise=())
    checked = replace(checked, result=replace(checked.result, judgement=judgement))
    checked.save(tmp_path / "out")
    page = (tmp_path / "out" / "report.html").read_text("utf-8")
    assert '<p class="verdict undecided"><strong>within 1 %</strong>' in page
    assert "our own methods disagree" in page
    assert not checked.passes


def steady_table():
    """Return late pressures whose largest error is on the slow ring, and the weighted one not.

    In the steady state k p is one constant. With the wear coefficients k and 100 k, an error of the
    pressure counts ten times as much on the outer ring in the norm of the pressure.
    """
    radii = np.linspace(0.00025, 0.00975, 39)
    areas, wear = np.pi * np.array([25e-6, 75e-6]), np.array([1.0, 100.0])
    slow = 100 / np.sum(areas / wear)
    pressure = np.where(radii < 0.005, slow, slow / 100)
    table = pd.DataFrame({"time": 1e9, "radius": radii, "pressure": pressure, "profile": np.nan})
    table.loc[5, "pressure"] += 0.1 * slow
    table.loc[38, "pressure"] += 0.05 * slow
    return table.drop(columns="profile"), slow


def test_text_table_and_figure_name_the_same_place():
    table, slow = steady_table()
    checked = check(SCENE, {"abaqus": table})
    (field,) = checked.together.field_comparisons[0].fields
    _, index = field.largest
    assert field.radii[index] == pytest.approx(0.0015)
    (row,) = checked.rows
    assert row.radius == pytest.approx(0.0015)
    # 10 % of the pressure there, and of the root mean square of k p^2, which the slow ring carries
    assert row.there == pytest.approx(0.1, abs=1e-3)
    weights = np.array([25 * 1.0, 75 * 100.0]), np.array([slow, slow / 100])
    rms = np.sqrt(np.sum(weights[0] * weights[1] ** 2) / np.sum(weights[0]))
    assert row.largest == pytest.approx(0.1 * slow / rms, rel=0.05)
    assert row.largest == pytest.approx(field.relative[field.largest], rel=1e-6)
    assert row.error == pytest.approx(float(field.norms.max()), rel=1e-6)
    line = next(line for line in checked.texts.lines if "pressure: root mean square error" in line)
    assert "at one radius largest at t = 1e+06 s" not in line
    titles = [axes.get_title(loc="left") for axes in checked.plot("difference").axes]
    (largest,) = [title for title in titles if "largest" in title]
    assert "r = 1.5 mm" in largest
    assert "r = 1.5 mm: 10 % too high" in line


@pytest.fixture(scope="module")
def stepped():
    """Return a scene, and its results by implicit steps of first order, 2500 s long."""
    times = [0.0, 1e3, 3e3, 1e4, 2e4, 3e4, 5e4]
    scene = SCENE.changed(methods=["mdr"], punch__wear_coefficients=[5e-15, 1e-15])
    scene = scene.changed(wear__times=times, accuracy__rtol=1e-4)
    return scene, run(scene.changed(wear__march="implicit", wear__step=2500.0)).dataset


@pytest.mark.slow
def test_the_length_of_a_time_step_has_a_unit(stepped):
    scene, dataset = stepped
    checked = check(scene, {"theirs": dataset[["pressure", "profile", "indentation"]]})
    (diagnosis,) = [each for each in checked.mistakes("theirs") if "step" in each.name]
    number, unit = re.search(r"about (\S+) (s|min|h) long", diagnosis.words).groups()
    seconds = float(number) * {"s": 1, "min": 60, "h": 3600}[unit]
    assert seconds == pytest.approx(2500, rel=0.1)


@pytest.mark.slow
def test_results_of_ringwear_have_quantities_that_no_mistake_is_known_to_change(stepped):
    """Results with the RMS slope, for example, are diagnosed by their other quantities."""
    checked = check(*stepped)
    assert "first-order time step" in {mistake.name for mistake in checked.mistakes()}


def test_an_order_of_convergence_is_never_minus_zero():
    """Errors that do not fall have the order 0."""
    files = {"coarse": start(1.02), "finer": start(1.020001), "finest": start(1.02)}
    checked = check(SCENE.changed(methods=["mdr"]), files, sizes=(0.4, 0.2, 0.1))
    (line,) = [line for line in checked.texts.lines if line.startswith("refinement: indentation")]
    assert "order 0 (between successive sizes: 0, 0)" in line


@pytest.mark.slow
def test_results_that_cannot_be_compared_do_not_pass(tmp_path):
    """Pressures jump at ring edges, where there is nothing to compare."""
    table = pd.DataFrame({"time": [1e4], "radius": [0.005], "pressure": [1.0]})
    checked = check(SCENE.changed(methods=["mdr"]), {"abaqus": table})
    (line,) = checked.texts.lines
    assert line.startswith("abaqus: none of its results ")
    assert not checked.passes
    checked.save(tmp_path)
    page = (tmp_path / "report.html").read_text("utf-8")
    ((colour, word, sentence),) = banners_on(page)
    assert (colour, word) == ("undecided", "not compared")
    assert "looks like" not in sentence


def test_errors_below_our_own_estimate_are_undecided(tmp_path):
    """A tolerance far below our error estimate cannot be checked."""
    checked = check(SCENE.changed(methods=["mdr"]), {"abaqus": start(1.0)}, within=1e-15)
    (row,) = checked.rows
    assert 1e-15 < abs(row.error) <= row.stated
    assert checked.texts.lines[0].endswith("or within our own error estimate: indentation")
    checked.save(tmp_path)
    ((colour, word, _),) = banners_on((tmp_path / "report.html").read_text("utf-8"))
    assert (colour, word) == ("undecided", "undecided")
