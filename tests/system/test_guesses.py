"""First guesses of users who have not read the manual: they work, or get a line of help.

The line states what to write, also to users of numpy and xarray.
"""

import doctest
import importlib
from html import unescape
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

import ringwear
from ringwear import (
    RingwearError,
    Scene,
    SceneError,
    Study,
    check,
    compare,
    deck,
    fit,
    load,
    plan,
    run,
    study,
    sweep,
)

SCENE = Scene.load("five_rings")
TABLE = pd.DataFrame({"time": [0.1], "indentation": [1.0]})
STUDY = Study("march", SCENE, TABLE)
IN_UNITS = {
    "punch": {"radius": "5 mm", "rings": 2, "wear_coefficients": ["1e-6 mm^3/(N m)", 1e-14]},
    "half_space": {"youngs_modulus": "2 GPa"},
    "load": {"normal_force": "100 N", "sliding_speed": 0.1},
    "wear": {"times": "running-in"},
    "methods": ["mdr", "direct"],
    "accuracy": {"rtol": 1e-3},
}
PARTS = {"half_space": {"youngs_modulus": 1.0}, "load": {"normal_force": 1.0}}


@pytest.fixture(scope="module")
def result():
    methods = ["mdr", "bem", "direct"]
    return run("five_rings", methods=methods, rtol=1e-3, quantities="history,steady")


# the guess, and whether its result is right
WORKING = [
    (lambda _: run("five_rings", "mdr,direct", 1e-2), lambda got: got.answers),
    (
        lambda _: run("flat_punch", methods=("mdr",), quantities="indentation"),
        lambda got: got.answers,
    ),
    (lambda _: run(IN_UNITS), lambda got: got.answers),
    (lambda _: run(Scene.load("flat_punch").table(), ["direct"]), lambda got: got.answers),
    (lambda of: of.plot(), lambda got: got.axes),
    (lambda of: of.plot(kind="steady_state"), lambda got: got.axes),
    (lambda of: of["indentation"], lambda got: got.sizes["solver"] == 3),
    (
        lambda _: Scene(
            punch={"radius": 1, "rings": 2, "wear_coefficients": pd.Series([1.0, 2.0])}, **PARTS
        ),
        lambda got: got.punch.wear_coefficients == [1.0, 2.0],
    ),
    (
        lambda _: sweep("five_rings", {"punch__rings": np.arange(1, 3)}, keep="steady_wear_rate"),
        lambda got: got.rings.values.tolist() == [1, 2],
    ),
    (
        lambda of: compare(of, of),
        lambda got: got.same and len(got.table) and not len(got.scenes),
    ),
    (
        lambda of: fit(SCENE, of.dataset.sel(solver="mdr"), "load.sliding_speed", noise=1e-3),
        lambda got: got.estimates.low.iloc[0] < 1.0 < got.estimates.high.iloc[0],
    ),
    (
        lambda _: fit(SCENE, {"time": [0.1], "indentation": [1.1]}, "load.sliding_speed", 1e-3),
        lambda got: len(got.measurements) == 1,
    ),
    (
        # a constant height leaves the whole face in contact
        lambda _: run(SCENE.with_heights(lambda _: 0.1), methods="mdr", rtol=0.1),
        lambda got: abs(float(got.answers["mdr"]["contact_radius_start"]) - 1.0) < 1e-6,
    ),
]


@pytest.mark.parametrize(("guess", "wanted"), WORKING)
def test_guesses_that_work(guess, wanted, result):
    assert wanted(guess(result))


# the guess, and words of the line that states what to write
TOLD = [
    (lambda of: of.answer, "did you mean result.answers?"),
    (lambda of: of.error("indentatoin"), "did you mean 'indentation'?"),
    (lambda _: SCENE.radius, "did you mean scene.punch.radius?"),
    (lambda _: SCENE.changed(rings=3), "write changed({'punch.rings': 3})"),
    (lambda _: Scene("five_rings"), "write Scene.load('five_rings')"),
    (lambda _: Scene.load(None), "give a Scene, the name of a bundled one"),
    (lambda _: run("five_rings", methods=3), "write ['mdr', 'fem']"),
    (lambda _: check("five_rings", {}), "{'abaqus': 'abaqus.csv'}"),
    (lambda _: sweep("five_rings", {"rings": [1, 2]}), "did you mean punch.rings?"),
    (
        lambda _: sweep("five_rings", ["punch.rings"]),
        "write sweep(scene, {'punch.rings': [2, 4, 8]})",
    ),
    (lambda _: ringwear.Rusult, "did you mean Result?"),
    (lambda of: of.save(3), "3 is no folder: give its name"),
    (lambda _: SCENE.changed("punch.rings", 3), "write changed({'punch.rings': 3})"),
    (lambda _: Scene.from_toml("five_rings.toml"), "write Scene.load(file)"),
    (
        lambda _: run(SCENE.with_heights(lambda _: [1.0, 2.0]), methods="mdr"),
        "return one height for each radius",
    ),
    (lambda _: plan("five_rings", rtol=0.1), "plan(scene.changed({'accuracy.rtol': 0.1}))"),
    (lambda _: check("five_rings", TABLE, columns=["p"]), "such as {'p': 'pressure'}"),
    (lambda _: check("five_rings", TABLE, tol=0.1), "has no argument 'tol'"),
    (lambda _: study(["march"]), "give one of paper, convergence"),
    (lambda _: study("convergence", quantities="depth"), "give functions of the result of a run"),
    (lambda _: study("refinement", meshes=[3]), "meshes has 3: give mesh files"),
    (lambda _: sweep(SCENE, {"punch.rings": [2, 3]}, workers=0), "give a whole number, 1 or more"),
    (lambda _: deck(SCENE, "calculx", "x"), "did you mean 'calculix'?"),
    (lambda _: deck(SCENE, "calculix", "x", size="a"), "size = ['a']: give numbers"),
    (lambda _: fit(SCENE, TABLE, "load.sliding_speed", noise=[1]), "or a text such as '2 um'"),
    (lambda _: fit(SCENE, {"a": np.zeros((2, 2))}, "k"), "is no table: give files"),
    (lambda _: STUDY.conclusion, "did you mean study.conclusions?"),
]


NUMBER = np.float64(-2.0)
# guesses with numbers, texts and arrays of numpy, which messages show as plain ones
OF_NUMPY = [
    (lambda _: check("five_rings", TABLE.assign(indentation=np.inf)), "'indentation': inf;"),
    (lambda _: check("five_rings", TABLE, within=NUMBER), "within = -2.0:"),
    (lambda _: SCENE.changed(times=np.array([0.0, 1.0])), "changed({'wear.times': [0.0, 1.0]})"),
    (lambda _: SCENE.changed({NUMBER: 1.0}), "unknown key -2"),
    (
        lambda _: setattr(SCENE.punch, "radius", -NUMBER),
        "write scene.changed({'punch.radius': 2.0})",
    ),
    (lambda _: run("five_rings", tol=np.float32(0.5)), "did you mean rtol?"),
    (lambda _: run("five_rings", methods=np.array(["mdr", "fen"])), "did you mean 'fem'?"),
    (lambda of: of.error(NUMBER), "no error estimate of -2.0"),
]


@pytest.mark.parametrize(("guess", "words"), TOLD + OF_NUMPY)
def test_wrong_guesses_get_a_line_with_the_right_call(guess, words, result):
    with pytest.raises((RingwearError, AttributeError, TypeError, KeyError)) as refused:
        guess(result)
    line = str(refused.value.args[0])
    assert words in line
    assert not [word for word in ("np.", "array(", "dtype", "\n") if word in line]


def test_an_error_within_a_property_is_reported(result, monkeypatch):
    """The message about unknown names does not hide an error of ringwear itself."""
    monkeypatch.setattr(type(result), "plots", property(lambda _: [].nothing))
    with pytest.raises(AttributeError, match="'list' object has no attribute 'nothing'"):
        _ = result.plots


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
    scene = Scene(**IN_UNITS).changed(methods=["mdr"], wear__times=[0.0, 1.0])
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
    assert result.verdict_in_words == f"{sentence}. Give two, such as mdr and bem."
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
