"""Methods compared as operators, for every pressure at once, by whole runs."""

from dataclasses import replace

import pytest
from independent import true_errors
from random_scenes import draw

from ringwear import Scene, SceneError, compare_operators, method, run, study

FIVE = Scene.load("five_rings")


@pytest.mark.slow
def test_the_operator_difference_bounds_the_error_of_histories(random_seed):
    scene = draw("flat", 20, random_seed, most_rings=3)
    # a comparison on the pressure space does not include the error of that space, which is small
    # relative to rtol
    rtol = max(scene.accuracy.rtol, 1e-5)
    scene = scene.changed(accuracy__rtol=rtol)
    error = true_errors(run(scene, methods=["mdr", "fem"]))["fem"]["indentation"][0].max()
    (pair,) = compare_operators(scene, ["mdr", "fem"])
    assert error <= 1.5 * pair.history + 0.02 * rtol


@pytest.mark.slow
def test_three_methods_are_compared_as_operators():
    pairs = {row.methods: row for row in compare_operators(FIVE, ["mdr", "bem", "fem"])}
    assert set(pairs) == {("fem", "mdr"), ("fem", "bem"), ("mdr", "bem")}
    theory = pairs["mdr", "bem"]
    assert max(theory.rings, theory.history) <= 1e-9
    assert theory.space <= 1e-6
    assert pairs["fem", "mdr"].rings == pytest.approx(pairs["fem", "bem"].rings, rel=1e-3)
    # long waves are resolved best
    by_wave = pairs["fem", "mdr"].differences
    assert by_wave[:5].max() < 1e-5 < by_wave[len(by_wave) // 2 :].min()


@pytest.mark.gmsh
@pytest.mark.parametrize("name", ["five_rings", "washer"])
def test_large_differences_of_operators_are_in_the_shaded_part(name):
    scene = Scene.load(name).changed(accuracy__rtol=1e-3)
    (pair,) = compare_operators(scene, ["mdr", "fem"])
    resolved = pair.wavelengths > pair.shortest_resolved
    assert pair.differences[~resolved].max() > 0.1
    assert pair.differences[resolved].max() < 0.1
    results = study("operators", scene)
    (axes,) = results.figures["operator_difference"].axes
    (shaded,) = axes.patches
    assert shaded.get_x() == pytest.approx(axes.get_xlim()[0])
    end = (shaded.get_x() + shaded.get_width()) * scene.punch.radius
    assert end == pytest.approx(pair.shortest_resolved)
    # the table has the same numbers
    row = results.table.set_index("quantity").loc["all pressures"]
    assert row["unknowns"] == len(results.tables["modes"]) == len(pair.differences)
    assert row["error"] == pytest.approx(pair.space, rel=1e-6)


def test_a_study_of_operators_says_that_multipliers_are_unstable():
    class Unstable(type(method("fem"))):
        name = "unstable"

        def discretise(self, problem, stages):
            sound = super().discretise(problem, stages)
            # one bubble causes almost no displacement, like a checkerboard
            factor = sound.compliance.factor.copy()
            factor[:, -1] *= 1e-2
            return replace(sound, compliance=replace(sound.compliance, factor=factor))

    def conclusion(*methods):
        return study("operators", FIVE, quick=True, methods=methods).conclusions[0]

    assert "the multipliers are stable" in conclusion("fem", "mdr")
    assert "the multipliers are UNSTABLE" in conclusion(Unstable(), "mdr")


@pytest.mark.parametrize(
    ("scene", "methods", "remedy"),
    [
        ("sphere", ["mdr", "bem"], "leave out punch.recess and punch.profile"),
        ("five_rings", ["mdr", "direct"], "give methods = ['fem', 'mdr']"),
    ],
)
def test_what_cannot_be_compared_as_operators_is_refused(scene, methods, remedy):
    with pytest.raises(SceneError, match=remedy.replace("[", r"\[")):
        compare_operators(scene, methods, rtol=1e-2)
