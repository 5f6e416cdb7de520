"""The page of a run.

All in one file, says what was asked, and works in a browser, on paper and on a phone.
"""

from __future__ import annotations

import argparse
import json
import re
from collections.abc import Iterator
from html.parser import HTMLParser
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from browser import Browser, installed

from ringwear import Scene, run
from ringwear.studies.cli import main
from ringwear.studies.crosscheck.dataset import Result
from ringwear.studies.report.page import write_report, write_study
from ringwear.studies.report.slides import slides

NASTY = "Stone & binder </script><b> $x_{"


class Loads(HTMLParser):
    """Everything that a page would load, and the text of its data."""

    def __init__(self) -> None:
        super().__init__()
        self.addresses: list[str] = []
        self.tags: list[str] = []

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.tags.append(tag)
        self.addresses += [
            value or ""
            for name, value in attrs
            if name in ("src", "href", "srcset", "data", "action")
        ]


@pytest.fixture(scope="module")
def result() -> Result:
    return run(Scene.load("rubber").changed(title=NASTY, methods=["mdr", "direct"]))


@pytest.fixture(scope="module")
def page(tmp_path_factory: pytest.TempPathFactory) -> Path:
    out = tmp_path_factory.mktemp("page")
    scene = out / "scene.toml"
    scene.write_text(
        Scene.load("rubber").changed(title=NASTY, methods=["mdr", "direct"]).to_toml(), "utf-8"
    )
    assert main(["run", str(scene), "--out", str(out / "out")]) == 0
    return out / "out" / "report.html"


def test_a_page_is_one_small_file_that_loads_nothing(page: Path) -> None:
    text = page.read_text("utf-8")
    assert len(text) < 3e6
    loads = Loads()
    loads.feed(text)
    assert loads.addresses
    assert all(address.startswith("data:image/png") for address in loads.addresses)
    assert "default-src 'none'" in text
    assert "link" not in loads.tags
    # the title is text, whatever is in it
    assert "Stone &amp; binder &lt;/script&gt;&lt;b&gt;" in text
    assert "b" not in loads.tags
    assert loads.tags.count("script") == 2


def test_a_page_says_what_was_asked(page: Path, result: Result) -> None:
    text = page.read_text("utf-8")
    for told in (
        "Running-in takes",
        "days",
        "nm/h of height",
        "has worn by",
        "µm",
        "The methods agree",
        "anchors",
        "within the",
        "Modelled",
        "left out",
    ):
        assert told in text, told
    assert f"{result.answers['mdr']['time_to_99'] / 86400:.3g} days" in text
    # the scene as it was run
    (scene,) = re.findall(r"<pre>(.*?)</pre>", text, re.DOTALL)
    assert "poisson_ratio = 0.4999" in scene


def test_slides_go_from_the_flat_start_to_the_steady_state(result: Result) -> None:
    found = slides(result)
    assert found is not None
    assert len({*map(len, (found["labels"], found["profile"], found["pressure"]))}) == 1
    assert found["labels"][0].endswith("unworn")
    assert found["labels"][-1] == "steady state"
    assert not any(found["profile"][0])
    radii = np.array(found["radii"])
    assert radii[-1] <= 5.0 + 1e-6  # mm
    # at the start p = p0 / sqrt(1 - r^2/a^2), in kPa; the mean pressure is 300
    inner = radii < 4.5
    expected = 150 / np.sqrt(1 - (radii[inner] / 5) ** 2)
    np.testing.assert_allclose(np.array(found["pressure"][0])[inner], expected, rtol=2e-3)
    # in the steady state one wear rate, so pressures as the inverse wear coefficients
    last = np.array(found["pressure"][-1])
    assert last.max() / last.min() == pytest.approx(7.5, rel=1e-3)
    json.dumps(found, allow_nan=False)


@pytest.mark.parametrize(
    ("changes", "states"),
    [
        ({"methods": ["direct"], "wear__times": []}, 1),
        ({"methods": ["mdr-grid"], "wear__steady": False}, 7),
        ({"methods": ["mdr"], "wear__steady": False, "wear__times": [0.0]}, 49),
        ({"output__radii": [0.001], "methods": ["mdr"]}, 50),
    ],
)
def test_every_part_of_a_scene_has_a_page(
    changes: dict[str, Any], states: int, tmp_path: Path
) -> None:
    result = run(Scene.load("rubber").changed(accuracy__rtol=1e-3, **changes))
    write_report(result, tmp_path, tmp_path / "report.html")
    found = slides(result)
    assert len(found["labels"] if found else []) == states
    assert ('id="solid"' in (tmp_path / "report.html").read_text("utf-8")) == bool(states)


def test_the_page_of_a_study(tmp_path: Path) -> None:
    (tmp_path / "rows.csv").write_text("method,error\nmdr,0.000123456\n<fem>,\n", "utf-8")
    (tmp_path / "curve.png").write_bytes(b"\x89PNG")
    page = tmp_path / "report.html"
    write_study(
        ("march", "orders of marches"),
        Scene.load("five_rings"),
        ["All is well.", "| a | table |"],
        tmp_path,
        page,
    )
    text = page.read_text("utf-8")
    for told in (
        "All is well.",
        "0.0001235",
        "&lt;fem&gt;",
        "data:image/png;base64,iVBORw==",
        "orders of marches",
    ):
        assert told in text
    assert "| a |" not in text


def test_a_study_has_its_page_among_its_files(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def conduct(_: Scene, out: Path, __: argparse.Namespace) -> list[str]:
        (out / "rows.csv").write_text("a,b\n1,2\n", "utf-8")
        return ["Done."]

    monkeypatch.setattr("ringwear.studies.time_steps.conduct", conduct)
    assert main(["study", "march", "--out", str(tmp_path)]) == 0
    assert json.loads((tmp_path / ".ringwear.json").read_text("utf-8")) == {
        "study march": ["report.html", "rows.csv"]
    }
    assert "Done." in (tmp_path / "report.html").read_text("utf-8")


def test_flags_leave_out_what_they_say(tmp_path: Path) -> None:
    quick = ["run", "flat_punch", "--methods", "direct", "--out", str(tmp_path)]
    for flags, kept in (
        (["--no-report"], {"steady_state.png"}),
        ([], {"steady_state.png", "report.html"}),
        (["--no-figures"], set()),
    ):
        assert main([*quick, *flags]) == 0
        assert {file.name for file in tmp_path.glob("[!.]*")} == {
            "results.nc",
            "summary.json",
        } | kept


@pytest.fixture(scope="module")
def browser() -> Iterator[Browser]:
    program = installed()
    if program is None:
        pytest.skip("no Chromium or Chrome is installed: apt-get install chromium")
    one = Browser(program)
    yield one
    one.close()


WIDTHS = {"phone": 390, "laptop": 1280}


@pytest.mark.parametrize("width", WIDTHS.values(), ids=WIDTHS)
def test_the_slider_in_a_browser(browser: Browser, page: Path, width: int) -> None:
    browser.open(page, width)
    assert browser.evaluate("document.documentElement.scrollWidth") <= width
    assert browser.evaluate(
        "[...document.images].every(one => one.complete && one.naturalWidth > 0)"
    )
    label = "document.getElementById('when').textContent"
    curve = "document.querySelector('#profile path:last-of-type').getAttribute('d')"
    painted = "document.getElementById('solid').toDataURL()"
    assert browser.evaluate(label) == "steady state"
    before = [browser.evaluate(one) for one in (label, curve, painted)]
    browser.evaluate(
        "s = document.getElementById('state'); s.value = 20; s.dispatchEvent(new Event('input'))"
    )
    after = [browser.evaluate(one) for one in (label, curve, painted)]
    assert all(one != other for one, other in zip(before, after, strict=True))
    assert "% run in" in after[0]
    # nothing is drawn outside of the frames, and nothing failed or was fetched
    assert browser.evaluate("document.querySelectorAll('svg path').length") == 4
    assert "NaN" not in after[1]
    assert browser.errors == []
    assert {address for address in browser.requests if not address.startswith("data:")} == {
        page.as_uri()
    }


def test_the_page_prints(browser: Browser, page: Path) -> None:
    browser.open(page, 1280)
    printed = browser.printed()
    assert printed.startswith(b"%PDF")
    # A4 in points
    assert re.search(rb"/MediaBox\s*\[0 0 59[45][.\d]* 84[12]", printed)
