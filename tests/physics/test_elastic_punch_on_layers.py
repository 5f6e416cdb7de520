"""An elastic flat punch or ball on coats: the compliances of both bodies add."""

import numpy as np
import pytest
from ball_on_pad import Ball, pressed_by
from groups import slow
from independent_layer import start
from layered_disc import Layer, surface_displacements

from ringwear import Scene, SceneError, deck, run

PUNCH = 3.0
# Young's modulus of a coat and of its base; a base without a modulus is rigid
COATS = {"stiff": (10.0, 1.0), "soft": (0.2, 1.0), "pad": (1.0, None)}
RATIO, THICKNESS = 0.3, 0.4


def scene(coat, youngs_modulus, ball, **tables):
    modulus, base = COATS[coat]
    layers = [{"thickness": THICKNESS, "youngs_modulus": modulus, "poisson_ratio": RATIO}]
    ground = {"rigid": True} if base is None else {"youngs_modulus": base, "poisson_ratio": RATIO}
    punch = {"radius": 1.0, "wear_coefficient": 1.0}
    if ball:
        punch |= {"profile": {"kind": "ball", "ball_radius": 4.0}}
    table = {
        "methods": ["mdr", "bem"] if base is None else ["mdr", "bem", "fem"],
        "punch": punch,
        "half_space": ground
        | {"layers": layers, "punch_youngs_modulus": youngs_modulus, "punch_poisson_ratio": 0.2},
        "load": {"normal_force": 0.02},
        "wear": {"times": [0.0]},
        "accuracy": {"rtol": 1e-5},
    }
    return Scene.from_table(table | tables)


def compliance(coat, youngs_modulus):
    """Return the modulus of the contact, and the relative compliance as a function of waves."""
    modulus, base = COATS[coat]
    layers = [Layer(THICKNESS, modulus, RATIO)]
    if base is not None:
        layers.append(Layer(np.inf, base, RATIO))
    of_ground, of_punch = (1 - RATIO**2) / modulus, (1 - 0.2**2) / youngs_modulus

    def relative(s):
        surface = surface_displacements(layers, s) * s / 2
        return (surface + of_punch) / (of_ground + of_punch)

    return 1 / (of_ground + of_punch), relative


@pytest.mark.parametrize("ball", [False, True], ids=["flat", "ball"])
@pytest.mark.parametrize("youngs_modulus", [PUNCH, 0.5])
@pytest.mark.parametrize("coat", ["pad", *slow("stiff", "soft")])
def test_the_start_against_an_independent_equation(coat, youngs_modulus, ball):
    own = scene(coat, youngs_modulus, ball)
    modulus, relative = compliance(coat, youngs_modulus)
    if ball:
        expected = pressed_by(Ball(4.0, THICKNESS, RATIO, relative), 0.02 / modulus, 0.02)
        expected = expected.indentation
    else:
        expected = 0.02 / modulus * start(THICKNESS, RATIO, compliance=relative)
    result = run(own)
    np.testing.assert_allclose(result.dataset.indentation[:, 0], expected, rtol=1e-7)
    # fields beside the edge of a ball's contact may need more cells than there are
    assert result.verdict == "agree" or (ball and result.verdict == "undecided")


@pytest.mark.slow
def test_methods_agree_while_a_ball_wears_a_coat():
    result = run(
        scene("stiff", PUNCH, ball=True, wear={"times": [0.0, 0.1, 1.0]}, accuracy={"rtol": 1e-3})
    )
    assert result.verdict == "agree"


def test_a_hard_punch_is_rigid_and_equal_layers_are_a_half_space():
    rigid, hard = (scene("soft", modulus, ball=False) for modulus in (1e9, 1e12))
    indentations = [run(each, methods=["mdr"]).dataset.indentation.item() for each in (rigid, hard)]
    assert indentations[0] == pytest.approx(indentations[1], rel=1e-8)
    layers = [{"thickness": 0.4, "youngs_modulus": 1.0}]
    bodies = {"youngs_modulus": 1.0, "punch_youngs_modulus": 2.0}
    starts = [
        run(scene("soft", PUNCH, ball=False, half_space=bodies | more)).dataset.indentation
        for more in ({}, {"layers": layers})
    ]
    np.testing.assert_allclose(*starts, rtol=1e-7)


def test_what_an_elastic_punch_on_layers_cannot_have_is_refused(tmp_path):
    with pytest.raises(SceneError, match=r"rigid with punch_youngs_modulus.*leave fem out"):
        run(scene("pad", PUNCH, ball=False), methods=["mdr", "fem"])
    with pytest.raises(SceneError, match=r"punch_youngs_modulus.*rigid punch"):
        deck(scene("soft", PUNCH, ball=False), "calculix", tmp_path / "deck")
