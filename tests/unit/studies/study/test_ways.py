"""Orders of ways to refine, each with a cap on its error, and stresses on the axis."""

from dataclasses import replace

import numpy as np
import pytest
from closed_forms import PowerPunch, flat_punch
from groups import nightly, slow

from ringwear import (
    Ground,
    PressureSpace,
    Scene,
    SceneError,
    SizeField,
    alternating_edges,
    bisection,
    energy,
    press_flat,
)
from ringwear.mdr.uniform_grid import UniformGrid
from ringwear.meshes.half_space import contact_radii, quality
from ringwear.studies.accuracy import GRADINGS_OF_ONE_RING
from ringwear.studies.study.declared import observed_orders
from ringwear.studies.study.errors import STRESS, error
from ringwear.studies.study.measure import measure
from ringwear.studies.study.orders import DIFFERS
from ringwear.studies.study.record import Record
from ringwear.studies.study.reference import Reference, reference, shaped_start
from ringwear.studies.study.way import ALL, Case, Part
from ringwear.studies.study.ways import naive
from ringwear.studies.study.ways.axis_stresses import (
    DEPTHS,
    boussinesq_stresses,
    element_stresses,
)
from ringwear.studies.study.ways.finite_elements import (
    EVEN,
    GRADED,
    adaptive,
    coarsest,
    halved,
    layered,
    poles_without_error,
    subdivisions,
)
from ringwear.studies.study.ways.radial import graded_radii, uniform_radii
from ringwear.studies.study.ways.subdivision import subdivided
from ringwear.studies.study.ways.truncated import exact_disc, far_fields

FIVE = Case.of(Scene.load("five_rings"))
ONE = FIVE.with_one_ring()


@pytest.fixture(scope="module")
def exact():
    return reference(FIVE, (STRESS,))


def exact_start():
    """Return the closed form of the start of a flat punch under the force 1: ``F / (2 a E*)``."""
    return Reference({"time": np.zeros(1), "indentation": np.array([0.5])}, lambda _: 1e-14)


def order(sizes, errors):
    """Return the order between the two finest levels."""
    return float(np.log(errors[-2] / errors[-1]) / np.log(sizes[-2] / sizes[-1]))


def fits_of(case, way, exact, *quantities):
    """Return the observed order of each quantity of a way, by name and `when`."""
    table = measure([case], [way], quantities, Record(), exact=lambda _: exact)
    fits = observed_orders(table, {case.name: [way]})
    return {(row["quantity"], row["when"]): row for row in fits.to_dict("records")}


@pytest.mark.parametrize(
    ("way", "within"),
    [
        (uniform_radii("mdr", 1, (16, 32)), 0.02),
        (uniform_radii("mdr", 2, (16, 32)), 0.02),
        (uniform_radii("bem", 1, (16, 32)), 0.02),
        (subdivisions(EVEN[True], 1, (1, 2), quads=True), 0.15),
    ],
    ids=lambda value: getattr(value, "name", ""),
)
def test_cells_of_one_size_have_the_orders_of_the_singular_rim(exact, way, within):
    fits = fits_of(FIVE, way, exact, "indentation", "pressure")
    assert fits["indentation", "start"]["order"] == pytest.approx(1, abs=within)
    assert fits["pressure", "start"]["order"] == pytest.approx(0.5, abs=within)


def test_pressures_of_mdr_have_the_order_of_their_mean_square(exact):
    """With degree 2, pressures have the order 3, and the history the order 6."""
    fits = fits_of(FIVE, graded_radii("mdr", 2, (0.5, 0.6)), exact, "pressure", "indentation")
    assert fits["pressure", "later"]["order"] == pytest.approx(3, abs=0.2)
    assert fits["indentation", "later"]["order"] == pytest.approx(6, abs=0.3)


@pytest.mark.parametrize(("degree", "cap"), [(1, 2e-8), (2, 2e-12), (3, 5e-11), (4, 2e-13)])
def test_indentation_by_mdr_on_cells_graded_to_the_rim(degree, cap):
    """The orders are 2 degree + 3; with degree 4, the order approaches 11 until roundoff."""
    way = graded_radii("mdr", degree, GRADINGS_OF_ONE_RING[degree])
    exact = exact_start()
    table = measure([ONE], [way], ("indentation",), Record(), exact=lambda _: exact)
    sizes, errors = table[["size", "error"]].to_numpy().T
    assert errors.min() > 0
    assert errors[-1] <= cap
    between = np.diff(np.log(errors)) / np.diff(np.log(sizes))
    if degree < 4:
        assert between[-1] == pytest.approx(2 * degree + 3, abs=0.15)
    else:
        assert 10.5 < between[0] < between[1] < between[2] < 11


@pytest.mark.gmsh
@pytest.mark.parametrize(
    ("ratio", "cap"), [*nightly((0.0, 3e-12)), (0.3, 3e-12), *nightly((0.45, 5e-12))]
)
def test_indentation_on_quadrilaterals_by_the_degree(ratio, cap):
    """Two more degrees reduce the error by 20 or more, towards a factor of 9 for each."""
    case = replace(ONE, problem=replace(ONE.problem, ground=Ground.half_space(ratio)))
    way, exact = layered(range(5, 12), rings=1), exact_start()
    table = measure([case], [way], ("indentation",), Record(), exact=lambda _: exact)
    errors = table["error"].to_numpy()
    # finite elements are always too stiff
    assert max(errors) < 0
    assert (errors[:-2] / errors[2:]).min() >= 20
    assert (errors[0] / errors[-1]) ** (1 / (len(errors) - 1)) >= 0.7 * 9
    assert abs(errors[-1]) <= cap


@pytest.mark.parametrize("degree", [2, 3, *slow(4)])
def test_adaptive_energy_errors_fall_at_the_best_order_and_are_indicated(degree, exact):
    fem = FIVE.problem.fem.model_copy(update={"degree": degree})
    case = replace(FIVE, problem=replace(FIVE.problem, fem=fem))
    way = adaptive(range({2: 8, 3: 9, 4: 19}[degree]))
    table = measure([case], [way], ("energy",), Record(), exact=lambda _: exact)
    ratio = table["estimate"] / table["error"]
    assert 1 < ratio.min() < ratio.max() < 10
    (row,) = observed_orders(table, {case.name: [way]}).to_dict("records")
    # N^(-1/2) is the size of elements in the plane, and the energy norm of the error its power k
    assert row["order"] == pytest.approx(degree, abs=0.5)


@pytest.mark.slow
@pytest.mark.gmsh
def test_adaptive_meshes_need_at_most_twice_the_unknowns_of_graded_ones():
    from ringwear.studies.study.ways.finite_elements import by_tolerance

    rtols = [10.0 ** (-half / 2) for half in range(2, 11)]
    settings = {"mesher": "gmsh", "degree": None}
    ways = [by_tolerance("graded", rtols, settings), adaptive(range(21)), halved(range(4))]
    times = np.geomspace(1e-2, 20.0, 10).tolist()
    case = Case.of(Scene.load("five_rings").changed(wear__times=times))
    table = measure([case], ways, ("pressure",), Record(), exact=reference)
    reached = table[(table["when"] == "later") & (table["error"] <= 1e-3)]
    needed = reached.groupby("way")["unknowns"].min()
    assert needed["adaptive triangles"] <= 2 * needed["graded"]
    assert "uniform triangles" not in needed


def test_poles_make_the_truncation_negligible():
    assert len(poles_without_error(FIVE.problem, coarsest(FIVE.problem))) > 4


def paper_grid(count):
    return UniformGrid(alternating_edges(5), np.array([0.1, 1, 0.1, 1, 0.1]), count)


@pytest.mark.parametrize("count", [50, 100, 200])
def test_the_papers_march_blows_up_above_its_limit_only(count):
    """The limit is twice the shortest relaxation time of the grid, that of a wave of two cells."""
    grid = paper_grid(count)
    profiles = np.vstack([np.zeros(count + 1), np.eye(count + 1)])
    unworn, *worn = (grid.coefficients * grid.contact(profile)[0] for profile in profiles)
    rates = np.linalg.eigvals(np.array(worn).T - unworn[:, None])
    limit = 2 / np.abs(rates).max()
    assert rates.real.max() <= 1e-6
    assert limit == pytest.approx(grid.stability_limit(), rel=0.1)
    until = np.array([1000 * limit])
    pressures, *_ = grid.march(until, 0.95 * limit)
    assert 0 < pressures.min() < pressures.max() < 1
    with pytest.raises(SceneError, match=r"wear\.step"):
        grid.march(until, 1.05 * limit)


@pytest.mark.parametrize("ratio", [0.0, 0.3, 0.5])
def test_truncation_by_every_far_field(ratio):
    """Far fields at R = 4 a to 7 a against six poles on the same mesh."""
    ground = Ground.half_space(ratio)
    case = replace(ONE, problem=replace(ONE.problem, ground=ground))
    ways, exact = far_fields((4, 5, 6, 7), ground), exact_start()
    table = measure([case], ways, ("indentation",), Record(), exact=lambda _: exact)
    fits = observed_orders(table, {case.name: ways}).set_index("way")
    assert not fits["remark"].str.startswith(DIFFERS).any()
    assert fits["theory"].tolist() == [1, 5, 9, 13]
    caps = {"clamped": 0.3, "1 pole": 7e-5, "2 poles": 3e-8, "3 poles": 2e-11}
    for far_field, cap in caps.items():
        assert fits["finest error"][far_field] <= cap


def errors_on_layers(ground, radii):
    """Return the error (R,) of the start by the name of each far field on layers."""
    case = replace(ONE, problem=replace(ONE.problem, ground=ground))
    table = measure([case], far_fields(radii, ground), ("indentation",), Record(), exact=exact_disc)
    return {name: rows["error"].to_numpy() for name, rows in table.groupby("way")}


@pytest.mark.slow
@pytest.mark.gmsh
def test_truncation_on_layers():
    """Stiffness against the theory; far from the layers, loads have the orders of poles."""
    film = Scene.load("hard_film").problem.ground
    errors = errors_on_layers(film, (2.5, 4.0, 8.0, 16.0))
    assert abs(errors["1 load"][0] / errors["1 load"][-1]) > (16 / 2.5) ** 4.5
    assert 0.9 < np.log(errors["clamped"][2] / errors["clamped"][3]) / np.log(2) < 1
    assert abs(errors["2 loads"][0]) < 1e-7
    assert np.abs(errors["4 loads"]).max() < 1e-9
    # a clamped boundary causes no error on a rigid base
    pad = Scene.load("polishing_pad").problem.ground
    assert abs(errors_on_layers(pad, (4.0,))["clamped"][0]) < 1e-9
    # incompressible layers are extrapolated for each far field
    rubber = Ground.from_youngs_moduli([0.2], [1.0, np.inf], [0.5, 0.0])
    assert abs(errors_on_layers(rubber, (4.0,))["clamped"][0]) < 5e-8


def on_axis(ratio):
    """Return stresses zz and rr on the axis under a flat punch of force 1."""
    return flat_punch(0 * DEPTHS, DEPTHS, ratio)[1][:, [1, 0]]


@pytest.mark.parametrize("ratio", [0.0, 0.3, 0.5])
def test_stresses_on_the_axis_are_those_of_the_flat_punch(ratio):
    space = PressureSpace.graded([0.0, 1.0], 1e-13, 0.3, 5)
    pressed = press_flat(energy.compliance(space))
    stresses = boussinesq_stresses(space, pressed.pressure[None], ratio)[0]
    np.testing.assert_allclose(stresses, on_axis(ratio), atol=1e-6)


def test_stresses_of_elements_on_the_axis_converge_to_them():
    half_space = subdivisions(GRADED[False], 4, (1,)).solve(ONE.problem, 1).half_space
    pressed = press_flat(half_space.compliance())
    stresses = element_stresses(half_space, pressed.pressure[None])[0]
    np.testing.assert_allclose(stresses, on_axis(0.3), atol=2e-3 / np.pi)


def test_errors_are_signed_numbers_or_norms(exact):
    values = dict(exact.values)
    values["indentation"] = values["indentation"] * 0.99
    values["pressure"] = values["pressure"] * 1.01
    assert error(Part("indentation", "start"), values, exact.values, FIVE.problem) == pytest.approx(
        -0.01
    )
    assert error(Part("pressure", "later"), values, exact.values, FIVE.problem) == pytest.approx(
        0.01, rel=1e-6
    )
    assert np.isnan(error(Part("no_such", ALL), values, exact.values, FIVE.problem))


def test_the_reference_states_its_own_error(exact):
    assert exact.errors(Part("indentation", "start")) == 1e-14
    assert 0 < exact.errors(Part("pressure", "later")) < 1e-6
    values = exact.values["indentation"]
    assert values[0] == 0.5


def test_starts_in_closed_form():
    base, force = Scene.load("sphere").changed(load__normal_force=0.01), 0.01
    ball = base.changed(punch__profile={"kind": "parabola", "curvature_radius": 3.0})
    cone = base.changed(punch__profile={"kind": "cone", "slope": 0.1})
    for scene, exact in ((ball, PowerPunch(1 / 6, 2)), (cone, PowerPunch(0.1, 1))):
        start, radius = shaped_start(scene), exact.contact_radius(force)
        # in units of F / (a E*)
        assert start["indentation"] * force == pytest.approx(exact.indentation(radius), rel=1e-12)
        assert start["contact_radius"] == pytest.approx(radius, rel=1e-12)
    # no closed form if the whole face of the sphere is in contact, or if the force varies
    assert not shaped_start(ball.changed(load__normal_force=1e9))
    rising = {"times": [0.0, 1.0], "values": [0.01, 0.02]}
    assert not shaped_start(ball.changed(load__normal_force=rising))


@pytest.mark.slow
def test_the_naive_choice_is_accurate_in_an_ordinary_scene():
    """The truncation errs by 1.1 a/R = 1.1e-3, and a punch of one material has no ring edges."""
    problem = Scene.load("flat_punch").changed(wear__times=[0.0, 10.0]).problem
    start = naive.solve(problem, outer=1000.0)["indentation"][0]
    # Eq. 10: the flat start of the force 1; the mesh of equal elements has the size 1/20
    assert abs(start / 0.5 - 1) < 0.02
    # the steady pressure of one material is uniform (Eq. 24)
    assert naive.solve(problem)["pressure"][1] == pytest.approx(1 / np.pi, rel=5e-3)


@pytest.mark.parametrize("count", [1, 2, 3])
def test_subdivision(count):
    base = bisection.mesh(SizeField((0.0, 1.0), 1e-5, 1e-4, 0.8, 20.0))
    fine = subdivided(base, count)
    assert fine.nelements == count**2 * base.nelements
    # triangles at the arc lose some quality, because their points are moved onto it
    assert quality(fine).min() > 0.5 * quality(base).min()
    # every vertex of the base is kept, and the points of the arc have its radius
    assert np.isin(contact_radii(base), contact_radii(fine)).all()
    far = fine.p[:, np.unique(fine.facets[:, fine.boundaries["far"]])]
    assert np.hypot(*far) == pytest.approx(20.0, rel=1e-12)
