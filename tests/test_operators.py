"""The methods as operators: certified for every pressure at once, and faults that show at once."""

from dataclasses import replace

import numpy as np
import pytest
from ringwear.mdr.energy import compliance as mdr_compliance
from ringwear.meshes.compliance import Compliance
from ringwear.meshes.errors import SolverError
from ringwear.studies.crosscheck.operators import OperatorDifference, difference
from ringwear.studies.crosscheck.run import run
from ringwear.studies.methods.fem import fem_model
from ringwear.studies.methods.radial import mdr_model
from ringwear.studies.problem.problem import NaturalScene
from ringwear.studies.progress import Stages
from ringwear.studies.random_scenes import random_scenes
from ringwear.studies.wear.archard import Wear

from ringwear import Scene


def against_mdr(natural: NaturalScene, first: Compliance) -> OperatorDifference:
    """The operator against the MDR on its own space."""
    wear = natural.phases[1]
    return difference(natural, ("fem", "mdr"), Wear(first, wear), Wear(mdr_compliance(first.space), wear))


def five_rings(**changes: object) -> NaturalScene:
    return Scene.load("five_rings").changed(**changes).natural


@pytest.mark.parametrize(
    ("rings", "rtol"),
    [
        (1, 1e-4),
        (2, 1e-4),
        (5, 1e-4),
        (32, 1e-4),
        (1, 1e-6),
        (2, 1e-6),
        (5, 1e-6),
        (32, 1e-6),
    ],
)
def test_every_steady_state_is_certified(rings: int, rtol: float) -> None:
    natural = five_rings(punch__rings=rings, accuracy__rtol=rtol)
    found = against_mdr(natural, fem_model(natural, Stages("test"), twins=False).compliance)
    assert found.rings <= rtol
    # the multipliers see the displacement, on coarse meshes and on fine ones
    assert found.stability >= 0.3


@pytest.mark.parametrize("nu", [0.0, 0.3, 0.49, 0.5])
def test_poisson_ratio_does_not_matter(nu: float) -> None:
    natural = five_rings(half_space__poisson_ratio=nu)
    assert against_mdr(natural, fem_model(natural, Stages("test"), twins=False).compliance).rings <= 1e-4


def true_error(natural: NaturalScene, indentation: np.ndarray) -> float:
    """Relative error against an MDR on a far finer mesh, by degree 9 to 1e-8 of the rim."""
    fine = natural.scene.changed(
        accuracy__rtol=1e-7, accuracy__mdr={"degree": 9, "rim_size": 1e-8, "ring_size": 2e-5}
    ).natural
    exact = Wear(mdr_model(fine, Stages("test"), twins=False).compliance, natural.phases[1]).modal(natural.times)
    return float(np.abs(indentation / exact.indentation - 1).max())


@pytest.mark.parametrize("scene", [*random_scenes(20, 10, most_rings=12)], ids=lambda scene: f"{scene.punch.rings} rings")
def test_history_bounds_the_error(scene: Scene) -> None:
    # the pressure space has its own error, which no comparison on that space can see: it is small beside the dial
    scene = scene.changed(accuracy__rtol=max(scene.accuracy.rtol, 1e-5))
    natural = scene.natural
    model = fem_model(natural, Stages("test"), twins=False)
    wear = Wear(model.compliance, natural.phases[1])
    bound = against_mdr(natural, model.compliance).history
    assert true_error(natural, wear.modal(natural.times).indentation) <= 1.5 * bound + 0.02 * scene.accuracy.rtol


@pytest.mark.parametrize(
    ("fault", "least"), [("fixed boundary", 1e-2), ("modulus", 9e-3), ("lost edge", 1e-2)], ids=lambda value: str(value)
)
def test_faults_show_in_the_rings(fault: str, least: float) -> None:
    natural = five_rings()
    if fault == "fixed boundary":
        natural = five_rings(accuracy__fem={"far_field": "fixed", "truncation": 20.0})
    sound = fem_model(natural, Stages("test"), twins=False).compliance
    if fault == "modulus":
        sound = replace(sound, factor=sound.factor * np.sqrt(1.01))
    if fault == "lost edge":
        # the operator of a mesh whose vertex lies beside the ring edge it is taken for
        moved = sound.space.edges.copy()
        moved[1] += 0.01
        breakpoints = np.interp(sound.space.breakpoints, sound.space.edges, moved)
        elsewhere = replace(sound.space, breakpoints=breakpoints, edges=moved)
        sound = replace(sound, factor=mdr_compliance(elsewhere).factor)
    assert against_mdr(natural, sound).rings >= least


def test_unstable_multipliers_are_refused() -> None:
    natural = five_rings()
    sound = fem_model(natural, Stages("test"), twins=False).compliance
    # one bubble that displaces next to nothing: a checkerboard
    factor = sound.factor.copy()
    factor[:, -1] *= 1e-2
    with pytest.raises(SolverError, match="unstable"):
        against_mdr(natural, replace(sound, factor=factor))


def test_three_operators_in_one_run() -> None:
    result = run(Scene.load("five_rings").changed(methods=["mdr", "bem", "fem"]))
    pairs = {row.methods: row for row in result.operators}
    assert set(pairs) == {("fem", "mdr"), ("fem", "bem"), ("mdr", "bem")}
    theory = pairs["mdr", "bem"]
    assert max(theory.rings, theory.history) <= 1e-9
    assert theory.space <= 1e-6
    assert theory.residual <= 1e-6
    assert pairs["fem", "mdr"].rings == pytest.approx(pairs["fem", "bem"].rings, rel=1e-3)
    # long waves are resolved best
    by_wave = pairs["fem", "mdr"].differences
    assert by_wave[:5].max() < 1e-5 < by_wave[len(by_wave) // 2 :].min()
