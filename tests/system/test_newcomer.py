"""First guesses of users who have not read the manual: they work, or get a line of help."""

import doctest
import importlib
from html import unescape
from pathlib import Path

import pytest

import ringwear
from ringwear import Scene, SceneError, load, run

SCENE = {
    "punch": {"radius": "5 mm", "rings": 2, "wear_coefficients": ["1e-6 mm^3/(N m)", 1e-14]},
    "half_space": {"youngs_modulus": "2 GPa"},
    "load": {"normal_force": "100 N", "sliding_speed": 0.1},
    "wear": {"times": "running-in"},
    "methods": ["mdr", "direct"],
    "accuracy": {"rtol": 1e-3},
}


@pytest.fixture(scope="module")
def result():
    return run("five_rings", methods=["mdr", "bem", "direct"], rtol=1e-3)


@pytest.mark.parametrize(
    "call",
    [
        lambda _: run("five_rings", "mdr,direct", 1e-2),
        lambda _: run("flat_punch", methods=("mdr",), quantities="indentation"),
        lambda _: run(SCENE),
        lambda _: run(Scene.load("flat_punch").table(), methods=["direct"]),
        lambda result: result.plot(),
        lambda result: result.plot(kind="steady_state"),
    ],
)
def test_guesses_that_work(call, result):
    assert call(result) is not None


def test_only_public_names_are_listed():
    names = set(dir(ringwear))
    assert names == set(ringwear.__all__)
    assert {"Result", "Scene", "SceneError", "check", "compare", "fit", "run", "sweep"} <= names
    # each is explained in one place, and can be imported
    assert [name for name in names if f"`{name}`" not in ringwear.__doc__] == ["__version__"]
    assert all(hasattr(ringwear, name) for name in names)
    assert ringwear.__version__[0].isdigit()
    assert ringwear.SceneError is SceneError


def test_results_display_themselves(result):
    lines = repr(result).splitlines()
    assert len(lines) <= 10
    assert "The methods agree" in lines[-1]
    assert "data:image/png;base64" in result._repr_html_()


def test_a_bundled_scene_is_printed_to_start_from(command, tmp_path):
    mine = tmp_path / "mine.toml"
    # as an editor on Windows saves it
    mine.write_text(command("scenes sphere").out, "utf-8-sig")
    assert Scene.load(mine) == Scene.load("sphere")
    command("scenes spher", 2)


@pytest.mark.slow
def test_a_result_carries_the_warnings_that_the_command_prints(command):
    """The mean pressure of 1e12 N on 10 mm is 1.4e6 times the modulus; d of 1 s is not run in."""
    scene = Scene(**SCENE).changed(methods=["mdr"], wear__times=[0.0, 1.0])
    result = run(scene.changed(load__normal_force=1e12))
    for words in ("which all methods assume, is not valid", "all times are before the running-in"):
        assert any(words in warning for warning in result.warnings)
    assert list(result.warnings) == list(result.summary["warnings"])
    printed = command("run scene.toml --no-figures --out out", scene=result.scene).out
    for text in (printed, repr(result), unescape(result._repr_html_())):
        assert all(f"warning: {warning}" in text for warning in result.warnings)
    assert load("out").warnings == result.warnings
    assert run("five_rings", methods=["direct"]).warnings == ()


@pytest.mark.slow
def test_one_method_alone_has_one_wording(command):
    result = run("five_rings", methods=["mdr"], rtol=1e-2)
    assert result.verdict == result.summary["verdict"] == "undecided"
    sentence = "One method alone is undecided: there is nothing to compare it with"
    assert result.verdict_in_words == f"{sentence}."
    result.save("saved")
    page = Path("saved/report.html").read_text("utf-8")
    printed = command("run five_rings --methods mdr --rtol 1e-2 --no-figures").out
    for text in (repr(result), repr(load("saved")), page, printed):
        assert f"{sentence}. " in text
        assert "0 of 0" not in text
        assert "one method" not in text.replace(sentence, "").lower()
    assert '<p class="verdict undecided">' in page


@pytest.mark.parametrize(
    "module",
    [
        "ringwear",
        "ringwear.studies.crosscheck.result.run",
        "ringwear.studies.check.check",
        "ringwear.studies.comparison",
        "ringwear.studies.extremes",
        "ringwear.studies.study.orders",
        "ringwear.studies.crosscheck.scene.scene",
        "ringwear.studies.crosscheck.wear.full_contact",
        "ringwear.studies.crosscheck.wear.wearing_punch",
        "ringwear.meshes.pressure_space",
        "ringwear.meshes.compliance",
        "ringwear.fem.half_space",
        *(
            pytest.param(f"ringwear.studies.{name}", marks=pytest.mark.slow)
            for name in ("sweep.sweep", "named_studies", "study.study")
        ),
    ],
)
def test_examples_in_docstrings_run(module):
    done = doctest.testmod(importlib.import_module(module))
    assert done.attempted
    assert not done.failed
