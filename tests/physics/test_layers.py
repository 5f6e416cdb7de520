"""Layered ground: published and independent stiffnesses, agreement of methods, and limits."""

import numpy as np
import pytest
from layered_disc import Layer, fields_under_uniform_pressure
from natural import natural

from ringwear import (
    ContactCells,
    Ground,
    PressureSpace,
    RunningIn,
    Scene,
    Stages,
    energy,
    even_half_space,
    method,
    ring_kernel,
    run,
)
from ringwear.meshes.ground.line_energy import relative_stiffness

TWO_RINGS = {"rings": 2, "wear_coefficients": [1.0, 0.1]}


def layer(thickness, youngs_modulus=1.0, poisson_ratio=0.3):
    return {
        "thickness": thickness,
        "youngs_modulus": youngs_modulus,
        "poisson_ratio": poisson_ratio,
    }


def on(*layers, punch=TWO_RINGS, below=None, rtol=1e-3, times=(0.0, 0.01, 0.1, 1.0), **tables):
    """Return a scene on layers above a half-space of Young's modulus `below`, or a rigid base."""
    base = {"rigid": True} if below is None else {"youngs_modulus": below}
    return natural(punch, times, rtol, half_space={**base, "layers": list(layers)}, **tables)


def compliance(name, scene):
    return method(name).discretise(scene.problem, Stages(name)).compliance


def stiffness_on(compliance):
    """Return the force over the indentation of a flat punch, 1 on a half-space without layers."""
    rings = len(compliance.space.ring_edges) - 1
    return 0.5 / RunningIn(compliance, np.ones(rings)).flat.indentation


@pytest.mark.gmsh
@pytest.mark.parametrize(("ratio", "printed"), [(0.4, 1.472), (1.0, 2.480)])
def test_stiffnesses_printed_by_hayes(ratio, printed):
    """Hayes and others (1972), nu = 0.3; their values are off by 4e-4 and by 1.4e-3."""
    scene = on(layer(1 / ratio), punch={"wear_coefficient": 1.0})
    stiffness = relative_stiffness(scene.problem.ground)
    assert stiffness == pytest.approx(printed, rel=2e-3)
    for name in ("mdr", "bem", "fem"):
        computed_stiffness = stiffness_on(compliance(name, scene))
        assert computed_stiffness == pytest.approx(stiffness, rel=1e-6), name


@pytest.mark.gmsh
@pytest.mark.parametrize("below", [10.0, 0.3])
def test_far_fields_on_layers_give_the_energy_of_the_mdr(below):
    """The energy of a uniform pressure on a mesh that ends at 2.5 a agrees with the MDR."""
    scene = on(layer(0.5), below=below, rtol=1e-5)
    fem = compliance("fem", scene)
    mdr = energy.compliance(fem.space, scene.problem.ground)
    uniform = fem.space.uniform
    energies = [float(np.sum((each.factor @ uniform) ** 2)) for each in (fem, mdr)]
    assert energies[0] == pytest.approx(energies[1], rel=1e-9)


def test_boundary_elements_and_the_mdr_are_the_same_operator():
    ground = Ground((0.1, 0.3), (0.35, 0.1, 2.0), (0.3, 0.45, 0.2))
    edges = np.array([0.0, 0.4, 1.0])
    breakpoints = np.array([0.0, 0.2, 0.36, 0.4, 0.44, 0.6, 0.8, 0.95, 1.0])
    space = PressureSpace(breakpoints, np.full(8, 4), edges)
    matrices = [each.compliance(space, ground).matrix for each in (energy, ring_kernel)]
    assert np.abs(matrices[0] - matrices[1]).max() <= 1e-13 * np.abs(matrices[0]).max()
    # the layers have an effect on the matrix
    assert np.abs(energy.compliance(space).matrix - matrices[0]).max() > 0.1 * matrices[0].max()


def test_equal_layers_equal_a_plain_half_space():
    """Layers of the same material as the base change neither the history nor the steady state."""
    plain = on(layer(1.0), below=1.0).table()
    plain["half_space"] = {"youngs_modulus": 1.0}
    layered = on(layer(0.2), layer(0.3), below=1.0)
    results = [run(each, methods=["mdr", "direct"]).dataset for each in (plain, layered)]
    for name in ("indentation", "relaxation_time", "steady_rms_slope", "steady_displacement_max"):
        values = [each[name].values[np.isfinite(each[name].values)] for each in results]
        # the elements of both scenes differ
        assert values[1] == pytest.approx(values[0], rel=1e-4), name


@pytest.mark.slow
def test_loads_over_time_fixed_indentations_and_wear_along_the_radius():
    along = {"radii": [0.0, 1.0], "values": [0.3, 1.0]}
    over_time = {"times": [0.0, 0.5, 2.0], "values": [0.5, 0.5, 1.0]}
    for changed in (
        {"punch": {"wear_coefficient": along}},
        {"load": {"normal_force": over_time}},
        {"load": {"indentation": 0.01}},
    ):
        result = run(on(layer(0.5), **changed), methods=["mdr", "bem"])
        assert result.verdict == "agree", changed


def test_a_stiff_layer_bends_away_from_a_flat_punch():
    """On soft ground the layer is a plate: only the rim touches, and contact spreads inwards."""
    scene = on(layer(0.5), below=0.01, rtol=1e-2, times=[0.0, 1.0, 10.0])
    assert not scene.problem.full_contact
    assert on(layer(0.5), below=0.5).problem.full_contact
    result = run(scene, methods=["mdr"])
    pressure = result.dataset.pressure.sel(solver="mdr")
    assert pressure.min() == 0
    inner = result.dataset.contact_edge.sel(solver="mdr").values[:, 0]
    assert 0.9 < inner[0] < 0.97
    assert np.all(np.diff(inner) < 0)
    assert result.verdict != "disagree"
    # with tension, the indentation would be smaller
    pulled = 0.5 / relative_stiffness(scene.problem.ground) * scene.problem.units.displacement
    assert float(result.dataset.indentation[0, 0]) > 1.01 * pulled


@pytest.mark.gmsh
def test_stiff_and_soft_layers_under_cells_of_a_shaped_punch():
    """Each pressure has the same energy by the MDR and on triangles that follow interfaces."""
    cells = ContactCells((0.0, 0.4, 1.0), largest=0.02, edge_size=1e-3)
    for ground in (
        Ground.from_youngs_moduli([0.1], [1.0, 10.0], [0.3, 0.2]),
        Ground.from_youngs_moduli([0.3, 0.2], [1.0, 0.1, 5.0], [0.3, 0.4, 0.0]),
        Ground.from_youngs_moduli([0.5], [1.0, np.inf], [0.45, 0.3]),
    ):
        triangles = even_half_space(cells, ground).compliance()
        theory = energy.compliance(triangles.space, ground)
        pressures = [triangles.space.uniform, np.ones(triangles.space.size)]
        for pressure in pressures:
            energies = [pressure @ each.matrix @ pressure for each in (triangles, theory)]
            assert energies[0] == pytest.approx(energies[1], rel=5e-5)


@pytest.mark.slow
@pytest.mark.gmsh
def test_fields_at_an_interface():
    """Displacements and stresses on both sides, of which the radial and the hoop stress jump."""
    moduli = (0.91, 4.55)
    ring = {"wear_coefficient": 1.0}
    scene = on(layer(0.4, moduli[0]), below=moduli[1], punch=ring, times=[])
    inside = run(scene, methods=["fem"]).inside()
    r, z = inside.points
    layers = [Layer(0.4, moduli[0], 0.3), Layer(np.inf, moduli[1], 0.3)]
    steady = inside.labels.index("steady")
    for number in (0, 1):
        side = (np.abs(z - 0.4) < 1e-12) & (inside.layers == number) & (r < 0.9)
        displacement, stress = fields_under_uniform_pressure(layers, number, r[side], z[side])
        missed = np.abs(np.pi * inside.displacement[steady, side] - displacement).max()
        assert missed <= inside.errors["displacement"][steady] * np.abs(displacement).max()
        missed = np.abs(np.pi * inside.stress[steady, side] - stress).max()
        assert missed <= inside.errors["stress"][steady]


def test_an_empty_list_of_layers_is_a_homogeneous_half_space():
    scene = Scene.load("flat_punch").changed(half_space__layers=[], methods=["mdr"])
    result = run(scene)
    assert not scene.problem.ground.layered
    assert result.anchors
    assert result.verdict != "disagree"
