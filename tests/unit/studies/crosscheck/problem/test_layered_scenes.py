"""Layers in scenes: their keys, units and refusals, and meshes with interfaces."""

import numpy as np
import pytest

from ringwear import Scene, SceneError, method
from ringwear.meshes.by_gmsh.outline import truncation_with_interfaces
from ringwear.meshes.half_space import areas
from ringwear.studies.crosscheck.anchors.reading import Reading
from ringwear.studies.crosscheck.problem.unit_names import kind_of
from ringwear.studies.crosscheck.sizes.finite_elements import fem_sizes
from ringwear.studies.crosscheck.sizes.shared import discretisation_key
from ringwear.studies.documented import function_at
from ringwear.studies.named_studies import STUDIES
from ringwear.studies.sweep.axes import Sweep

PAD = {
    "units": "SI",
    "punch": {"radius": "5 mm", "rings": 2, "wear_coefficients": [1e-15, 4e-15]},
    "half_space": {
        "rigid": True,
        "layers": [
            {"thickness": "1 mm", "youngs_modulus": "30 MPa", "poisson_ratio": 0.2},
            {"thickness": 0.002, "youngs_modulus": 3e6},
        ],
    },
    "load": {"normal_force": 2.0},
    "wear": {"times": [0.0, 100.0]},
}


def pad(**changes):
    return Scene.of(PAD).changed(**changes)


def test_layers_in_units_of_the_punch_and_of_the_first_modulus():
    problem = pad().problem
    ground = problem.ground
    assert ground.thicknesses == pytest.approx((0.2, 0.4))
    assert ground.rigid
    # E* = 2 G / (1 - nu) is the unit
    assert ground.shear_moduli[:2] == pytest.approx((0.4, 3e6 / 2.6 / (30e6 / 0.96)))
    assert problem.units.modulus == pytest.approx(30e6 / 0.96)
    assert problem.poisson_ratio == 0.3
    reading = Reading.of(pad()).ground
    assert reading.thicknesses == pytest.approx(ground.thicknesses)
    assert reading.shear_moduli[:2] == pytest.approx(ground.shear_moduli[:2])


def test_a_scene_of_layers_can_be_written_and_read():
    scene = Scene.load("hard_film")
    assert Scene.from_toml(scene.to_toml()).half_space == scene.half_space
    assert kind_of("half_space.layers.0.thickness", Scene) == "length"
    assert kind_of("half_space.layers.1.youngs_modulus", Scene) == "pressure"


def test_one_key_of_a_layer_can_be_changed():
    changed = pad(half_space__layers__1__thickness=0.005)
    assert [layer.thickness for layer in changed.half_space.layers] == [0.001, 0.005]
    assert discretisation_key(changed.problem) != discretisation_key(pad().problem)
    keys = {"half_space.layers.0.thickness": ["0.5 mm", "2 mm"]}
    sweep = Sweep.of({"base": PAD, "axes": keys})
    assert list(sweep.sizes) == ["thickness"]
    assert list(next(iter(sweep.columns.values())).values) == pytest.approx([0.0005, 0.002])


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"half_space__layers": []}, "rigid = true"),
        ({"half_space__youngs_modulus": 1e9}, "rigid = true excludes youngs_modulus"),
        ({"half_space__rigid": False}, "youngs_modulus"),
        ({"half_space__layers__0__thickness": -1.0}, "half_space.layers.0.thickness"),
        ({"half_space__layers__2__thickness": 1.0}, "half_space.layers.2.thickness"),
        ({"half_space__layers__0__hardness": 1.0}, "half_space.layers.0.hardness"),
        ({"half_space__layers__1__youngs_modulus": 1.0}, "layers.0.youngs_modulus"),
    ],
    ids=lambda given: "" if isinstance(given, str) else next(iter(given)),
)
def test_impossible_layers_are_refused_by_key(changes, words):
    with pytest.raises(SceneError, match=words) as refused:
        pad(**changes)
    assert "\n" not in str(refused.value)


def test_too_thin_a_layer_is_refused():
    with pytest.raises(SceneError, match=r"half_space\.layers\.0\.thickness"):
        _ = pad(half_space__layers__0__thickness=1e-6).problem


def test_finite_elements_refuse_layers_that_they_cannot_mesh():
    fem = method("fem")
    for changes, words in (
        ({"accuracy__fem": {"mesher": "bisection"}}, "quadrilaterals"),
        ({"half_space__layers__1__thickness": 4e-5}, "layers.1.thickness"),
        (
            {
                "punch__profile": {"kind": "cone", "slope": 0.1},
                "half_space__layers__0__poisson_ratio": 0.49999,
            },
            "triangles lock",
        ),
        ({"half_space__layers__0__poisson_ratio": 0.5, "accuracy__rtol": 1e-6}, "accuracy.rtol"),
    ):
        assert words in fem.refusal(pad(**changes).problem), changes
    with pytest.raises(SceneError, match="quadrilaterals"):
        fem_sizes(pad(accuracy__fem={"mesher": "gmsh"}).problem)


@pytest.mark.parametrize("name", ["paper", "convergence", "refinement", "march"])
def test_studies_of_the_homogeneous_half_space_refuse_layers(name):
    with pytest.raises(SceneError, match=r"half_space\.layers"):
        function_at(STUDIES[name].place)(pad())


def test_no_interface_nearly_touches_the_outer_boundary():
    assert truncation_with_interfaces((0.5, 1.9, 2.6), 2.5) == 2.5
    assert truncation_with_interfaces((2.2, 2.6), 2.5) == pytest.approx(3.25)


@pytest.mark.gmsh
def test_interfaces_are_lines_of_the_mesh():
    mesh = fem_sizes(pad().problem).mesh
    depths = mesh.p[1, mesh.t]
    for interface in (0.2, 0.6):
        assert not ((depths < interface - 1e-9).any(0) & (depths > interface + 1e-9).any(0)).any()
    # the quarter disc is cut off at the base
    assert depths.max() == pytest.approx(0.6)
    outer = 2.5
    enclosed = (0.6 * np.sqrt(outer**2 - 0.6**2) + outer**2 * np.arcsin(0.6 / outer)) / 2
    assert areas(mesh).sum() == pytest.approx(enclosed, rel=1e-2)
    base = mesh.facets[:, mesh.boundaries["base"]]
    assert np.ptp(mesh.p[1, base]) == 0
