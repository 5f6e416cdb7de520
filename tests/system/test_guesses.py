"""First guesses of users of numpy and xarray: they work, or a line states what to write."""

import numpy as np
import pandas as pd
import pytest

import ringwear
from ringwear import (
    RingwearError,
    Scene,
    Study,
    check,
    compare,
    deck,
    fit,
    plan,
    run,
    study,
    sweep,
)

SCENE = Scene.load("five_rings")
TABLE = pd.DataFrame({"time": [0.1], "indentation": [1.0]})
STUDY = Study("march", SCENE, TABLE)
PARTS = {"half_space": {"youngs_modulus": 1.0}, "load": {"normal_force": 1.0}}


@pytest.fixture(scope="module")
def result():
    return run("five_rings", methods=["mdr", "direct"], rtol=1e-2, quantities="history,steady")


# the guess, and whether its result is right
WORKING = [
    (lambda of: of["indentation"], lambda got: got.sizes["solver"] == 2),
    (lambda of: of["time"], lambda got: got.ndim == 1),
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
        lambda _: sweep(
            "five_rings",
            {"punch.wear_ratio": {"linspace": np.array([1.0, 10.0, 2.0])}},
            keep="steady_wear_rate",
        ),
        lambda got: got.wear_ratio.values.tolist() == [1.0, 10.0],
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
    (lambda _: run("five_rings", method="fem"), "did you mean methods?"),
    (lambda _: run("five_rings", methods=3), "write ['mdr', 'fem']"),
    (lambda _: run("five_rings", quantities="presure"), "did you mean 'pressure'?"),
    (lambda _: check("five_rings", {}), "{'abaqus': 'abaqus.csv'}"),
    (lambda _: sweep("five_rings", {"rings": [1, 2]}), "did you mean punch.rings?"),
    (
        lambda _: sweep("five_rings", ["punch.rings"]),
        "write sweep(scene, {'punch.rings': [2, 4, 8]})",
    ),
    (lambda _: compare("five_rings", "rubber"), "compare scenes in the same units"),
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
