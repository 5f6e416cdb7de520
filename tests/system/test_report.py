"""The page of a run.

It is one file, has the input of the run, and works in a browser, on paper and on a phone.
"""

import base64
import json
import re

import numpy as np
import pandas as pd
import pytest
from browser import Browser, installed
from matplotlib.figure import Figure

from ringwear import Scene, Study, check, main, run

SLIDES = re.compile(r'<script type="application/json" id="slides">(.*?)</script>', re.DOTALL)
RUBBER = Scene.load("rubber").changed(
    title="Stone & binder </script><b> $x_{", methods=["mdr", "bem", "direct"]
)


@pytest.fixture(scope="module")
def result():
    return run(RUBBER)


@pytest.fixture(scope="module")
def page(tmp_path_factory):
    out = tmp_path_factory.mktemp("page")
    (out / "scene.toml").write_text(RUBBER.to_toml(), "utf-8")
    assert main(["run", str(out / "scene.toml"), "--out", str(out)]) == 0
    return out / "report.html"


def page_of(result, folder):
    """Return the text of the page of a result."""
    result.save(folder)
    return (folder / "report.html").read_text("utf-8")


def slides_on(page):
    """Return the data of the slider on a page; None if the page has no slider."""
    data = SLIDES.search(page)
    return json.loads(data[1]) if data else None


def test_a_page_is_one_small_file_that_loads_nothing(page):
    text = page.read_text("utf-8")
    assert len(text) < 3e6
    addresses = re.findall(r'\s(?:src|href|srcset|data|action)="([^"]*)"', text)
    assert addresses
    # addresses are within the page, or contain the data themselves
    assert all(address.startswith(("data:image/png", "#")) for address in addresses)
    assert "default-src 'none'" in text
    # the title is shown as text, even if it contains tags
    assert "Stone &amp; binder &lt;/script&gt;&lt;b&gt;" in text
    tags = re.findall(r"<(\w+)", text)
    assert not {"link", "b"} & set(tags)
    assert tags.count("script") == 2


def test_a_page_has_the_input_of_the_run(page, result):
    text = page.read_text("utf-8")
    for words in ("nm/h", "mean height", "µm", "The methods agree", "anchors", "left out"):
        assert words in text, words
    assert f"{result.answers['mdr']['time_to_99'] / 86400:.4g} days" in text
    # the scene as it was run
    assert re.search(r"<pre>.*poisson_ratio = 0.4999.*</pre>", text, re.DOTALL)


def test_slides_go_from_the_flat_start_to_the_steady_state(page):
    shown = slides_on(page.read_text("utf-8"))
    assert len({*map(len, (shown["labels"], shown["profile"], shown["pressure"]))}) == 1
    assert shown["labels"][0] == "t = 0 s"
    assert shown["labels"][-1] == "steady state"
    assert not any(shown["profile"][0])
    radii, pressure = np.array(shown["radii"]), np.array(shown["pressure"])
    assert radii[-1] <= 5.0 + 1e-6  # mm
    # at the start p = p0 / sqrt(1 - r^2/a^2), in kPa; the mean pressure is 300
    inner = radii < 4.5
    expected = 150 / np.sqrt(1 - (radii[inner] / 5) ** 2)
    np.testing.assert_allclose(pressure[0, inner], expected, rtol=2e-3)
    # one wear rate in the steady state, so pressures are proportional to 1/k
    assert pressure[-1].max() / pressure[-1].min() == pytest.approx(7.5, rel=1e-3)


def test_slides_of_a_sphere_at_fixed_indentation_scale_each_state(tmp_path):
    times = [0.0, 0.05, 1.0]
    scene = Scene.load("sphere").changed(load={"indentation": 0.04}, wear__times=times)
    scene = scene.changed(accuracy__rtol=1e-3)
    shown = slides_on(page_of(run(scene.changed(methods=["mdr"])), tmp_path))
    # heights of the worn and of the unworn face above its plane
    radii, worn = np.array(shown["radii"]), np.array(shown["profile"])
    unworn = radii**2 / 2
    np.testing.assert_allclose(shown["unworn"], unworn, rtol=1e-3)
    np.testing.assert_allclose(worn[0], unworn, rtol=1e-3)
    assert worn[1, 0] > 0.1 * 0.04
    # a worn sphere is flat to a part of its first height, which a common scale would not show
    assert (0.3 * np.array(shown["deepest"]) < worn.max(axis=1)).all()
    # each state has its own scale, because the last pressure is hundreds of times lower
    medians = [np.median([p for p in pressure if p > 0]) for pressure in shown["pressure"]]
    assert (np.array(medians) < shown["highest"]).all()
    assert shown["highest"][0] > 10 * shown["highest"][-1] > 0


@pytest.mark.parametrize(
    ("changes", "states"),
    [
        ({"methods": ["direct"], "wear__times": []}, 1),
        ({"methods": ["mdr-grid"], "wear__steady": False}, 7),
        ({"methods": ["mdr"], "wear__steady": False, "wear__times": [0.0]}, 1),
        ({"output__radii": [0.001], "methods": ["mdr"]}, 0),
    ],
)
def test_every_part_of_a_scene_has_a_page(changes, states, tmp_path):
    result = run(Scene.load("rubber").changed(accuracy__rtol=1e-3, **changes))
    page = page_of(result, tmp_path)
    shown = slides_on(page)
    assert len(shown["labels"] if shown else []) == states
    assert ('id="solid"' in page) == bool(states)


@pytest.mark.slow
@pytest.mark.parametrize(("time", "pressed"), [(1.0, True), (14.5, False)])
def test_the_page_states_why_there_are_no_stresses(time, pressed, tmp_path):
    """The brake is applied at 1 s, and its force is 0 at 14.5 s."""
    brake = Scene.load("duty_cycle").changed(methods=["fem"], accuracy__rtol=0.1)
    result = run(brake.changed(wear__times=[0.0, 1.0, 14.5], output__field_times=[time]))
    page = page_of(result, tmp_path)
    assert ("stress.png is not drawn: nothing presses" in page) != pressed


def test_the_page_of_a_study(tmp_path):
    rows = pd.DataFrame(
        {"method": ["mdr", "<fem>"], "error": [0.000123456, np.nan], "count": [25378, 1]}
    )
    own = Study(
        "march",
        Scene.load("five_rings"),
        rows,
        conclusions=("All is well.", "| a | table |"),
        figures={"curve": Figure()},
        purpose="orders of time",
    )
    files = set(own.save(tmp_path))
    assert files == {"report.html", "march.csv", "curve.png"}
    text = (tmp_path / "report.html").read_text("utf-8")
    assert "| a |" not in text
    picture = base64.b64encode((tmp_path / "curve.png").read_bytes()).decode()
    for words in ("All is well.", "0.0001235", "25378", "&lt;fem&gt;", picture, "orders of time"):
        assert words in text, words


def test_flags_leave_out_figures_or_the_page(command, tmp_path):
    for flags, figures in (
        ("--no-report", {"steady_state.png"}),
        ("", {"steady_state.png", "report.html"}),
        ("--no-figures", set()),
    ):
        command(f"run flat_punch --methods direct --out . {flags}")
        files = {file.name for file in tmp_path.glob("[!.]*")}
        assert files == {"results.nc", "summary.json"} | figures


@pytest.fixture(scope="module")
def browser():
    program = installed()
    if program is None:
        pytest.skip("no Chromium or Chrome is installed: apt-get install chromium")
    opened = Browser(program)
    yield opened
    opened.close()


@pytest.fixture(scope="module")
def page_of_check(tmp_path_factory):
    """Return the page of a check of a node at the rim, where the first pressure is infinite."""
    out, parts = tmp_path_factory.mktemp("check"), np.linspace(0.0, 1.0, 21)
    # the flat start, and any finite number at the rim
    pressures = 1.5e5 / np.sqrt(1 - np.minimum(parts, 0.99) ** 2)
    table = pd.DataFrame({"time": 0.0, "radius": 0.005 * parts, "pressure": pressures})
    check(RUBBER, table, ["mdr"]).save(out)
    return out / "report.html"


def refuse_constant(name):
    raise ValueError(f"{name} is no JSON")


def test_no_page_has_numbers_that_are_not_finite(page, page_of_check):
    first, of_check = (
        json.loads(SLIDES.search(each.read_text("utf-8"))[1], parse_constant=refuse_constant)
        for each in (page, page_of_check)
    )
    assert None not in first["pressure"][0]
    assert of_check["pressure"][0][-1] is None


@pytest.mark.parametrize("kind", ["page", "page_of_check"])
@pytest.mark.parametrize("width", [390, 1280], ids=["phone", "laptop"])
def test_the_slider_in_a_browser(browser, request, kind, width):
    page = request.getfixturevalue(kind)
    browser.open(page, width)
    assert browser.evaluate("document.documentElement.scrollWidth") <= width
    assert browser.evaluate("[...document.images].every(i => i.complete && i.naturalWidth > 0)")
    shown = (
        "[document.getElementById('when').textContent,"
        "document.querySelector('#profile path:last-of-type').getAttribute('d'),"
        "document.querySelector('#pressure path:last-of-type').getAttribute('d'),"
        "document.getElementById('solid').toDataURL()]"
    )
    before = browser.evaluate(shown)
    browser.evaluate(
        "s = document.getElementById('state'); s.value = 0; s.dispatchEvent(new Event('input'))"
    )
    after = browser.evaluate(shown)
    assert before[0] == "steady state"
    assert after[0].startswith("t = ")
    assert all(old != new for old, new in zip(before, after, strict=True))
    # nothing is drawn outside of the frames, and nothing failed or was fetched
    assert browser.evaluate("document.querySelectorAll('svg path').length") == 4
    assert "NaN" not in after[1] + after[2]
    # the curve ends before an infinite pressure
    assert before[2].count(",") - after[2].count(",") == (kind == "page_of_check")
    assert browser.errors == []
    assert {url for url in browser.requests if not url.startswith("data:")} == {page.as_uri()}


def test_on_a_phone_figures_open_in_full_size_and_tables_scroll(browser, page):
    browser.open(page, 390)
    assert browser.evaluate(
        "[...document.querySelectorAll('.wide')].every(frame => frame.clientWidth <= 390 &&"
        "getComputedStyle(frame).overflowX === 'auto')"
    )
    assert browser.evaluate(
        "[...document.querySelectorAll('.wide')].some(frame => frame.scrollWidth > 390)"
    )
    image = "document.querySelector('figure[id] img')"
    assert browser.evaluate(f"{image}.clientWidth") <= 390
    browser.evaluate(f"{image}.closest('a').click()")
    shown = browser.evaluate(
        f"[{image}.clientWidth, {image}.naturalWidth, {image}.closest('figure').scrollWidth,"
        f"{image}.closest('figure').clientWidth, document.documentElement.scrollWidth]"
    )
    assert shown[0] == shown[1] > 1000
    assert shown[2] > shown[3] == 390 == shown[4]
    browser.evaluate("document.querySelector('figure:target .close').click()")
    assert browser.evaluate(f"{image}.clientWidth") <= 390


def test_the_page_prints(browser, page):
    browser.open(page, 1280)
    printed = browser.printed()
    assert printed.startswith(b"%PDF")
    # A4 in points
    assert re.search(rb"/MediaBox\s*\[0 0 59[45][.\d]* 84[12]", printed)
