"""Answers of the challenge on layered ground, against limits and independent solutions."""

from importlib import import_module

import numpy as np
import pandas as pd
import pytest
from groups import slow
from independent import CONSTANT, Pieces, Punch
from independent_layer import kernel, start, wave_numbers
from numpy.polynomial.legendre import leggauss
from scipy.linalg import cholesky, solve_triangular
from scipy.special import j0

from ringwear import Scene, run
from ringwear.studies.challenge.answers import read_answers
from ringwear.studies.challenge.problems import layered_problems, name_of

PROBLEMS = {int(name_of(path)[:2]): path for path in layered_problems()}
ANSWERS = {number: read_answers(path) for number, path in PROBLEMS.items()}


def module_of(number, name):
    """Return a script in the folder of a problem."""
    return import_module(f"ringwear.studies.challenge.{name_of(PROBLEMS[number])}.{name}")


@pytest.mark.parametrize("poisson_ratio", ANSWERS[13]["poisson_ratio"].unique())
def test_bonded_layers_against_an_independent_solution(poisson_ratio):
    answers = ANSWERS[13]
    for row in answers[answers["poisson_ratio"] == poisson_ratio].itertuples():
        exact = 0.5 / start(1 / row.radius_over_thickness, row.poisson_ratio)
        assert float(row.value) == pytest.approx(exact, rel=row.bound)


@pytest.mark.parametrize("poisson_ratio", [*slow(0.3), 0.5])
def test_the_ball_by_boundary_elements(poisson_ratio):
    scene = module_of(14, "make").case(1e-2, poisson_ratio)
    dataset = run(scene, methods=["bem"], rtol=1e-4).dataset
    rows = ANSWERS[14].set_index(["normal_force", "poisson_ratio", "quantity"])["value"]
    for quantity in ("indentation", "contact_radius"):
        answer = float(rows[1e-2, poisson_ratio, quantity])
        assert float(dataset[quantity][0, 0]) == pytest.approx(answer, rel=1e-7)


@pytest.mark.parametrize("poisson_ratio", [0.3, 0.5])
def test_the_equation_of_the_ball(poisson_ratio):
    """Its kernel is that of the tests; its pressures carry the force; a thick layer is Hertz's."""
    fredholm = module_of(14, "fredholm")
    x = np.geomspace(1e-3, 30, 50)
    assert fredholm.kernel(x, poisson_ratio) == pytest.approx(kernel(x, poisson_ratio), rel=1e-12)
    ball, contact = fredholm.Ball(10.0, 0.25, poisson_ratio), 0.5
    # r^2 = c^2 (1 - u^2), in which the pressure is smooth
    u, weights = (1 + leggauss(16)[0]) / 2, leggauss(16)[1] / 2
    radii = contact * np.sqrt(1 - u**2)
    pressures = [fredholm.pressed_to(ball, contact, radius).pressure for radius in radii]
    force = 2 * np.pi * contact**2 * (weights * u) @ pressures
    assert fredholm.pressed_to(ball, contact, 0.1).normal_force == pytest.approx(force, rel=1e-10)
    # the ball of radius R on a half-space (Sneddon, Int. J. Eng. Sci. 3, 1965, 47)
    logarithm = np.log((10 + contact) / (10 - contact)) / 2
    exact = [(contact**2 + 100) * logarithm - 10 * contact, contact * logarithm]
    thick = ball._replace(thickness=1e6)
    pressed = fredholm.pressed_to(thick, contact, 0.1)
    assert [pressed.normal_force, pressed.indentation] == pytest.approx(exact, rel=1e-5)


def test_the_deflection_of_the_road_by_dimensionality_reduction():
    dataset = run(Scene.load(PROBLEMS[15]), methods=["mdr"], rtol=1e-8).dataset
    rows = ANSWERS[15].set_index(["depth", "layer", "quantity"])
    answer = rows.loc[(0.0, 1, "displacement")]
    deflection = float(dataset["steady_displacement_max"][0])
    assert float(answer["value"]) == pytest.approx(deflection, rel=answer["bound"])


def test_displacements_and_tractions_of_the_road_are_continuous():
    rows = ANSWERS[15].set_index(["depth", "layer", "quantity"])
    for depth, above in ((6.0, 1), (16.0, 2)):
        for quantity in ("displacement", "stress_zz"):
            sides = [rows.loc[(depth, layer, quantity)] for layer in (above, above + 1)]
            values = [float(side["value"]) for side in sides]
            assert values[0] == pytest.approx(values[1], rel=sides[0]["bound"])
    pressure = float(rows.loc[(0.0, 1, "stress_zz")]["value"])
    assert pressure == pytest.approx(-100.0, rel=1e-8)


def test_equal_layers_are_the_half_space_of_boussinesq():
    """Stresses below a disc: Johnson, Contact Mechanics, section 3.4."""
    layered_disc = module_of(15, "layered_disc")
    nu = 0.3
    layers = [layered_disc.Layer(h, 2.0, nu) for h in (0.5, 0.7, np.inf)]
    for layer, depth in ((0, 0.0), (0, 0.5), (1, 0.5), (2, 1.2), (2, 4.0)):
        fields = layered_disc.fields_on_axis(layers, layer, depth)
        slant = np.hypot(1, depth)
        assert fields.stress_zz == pytest.approx((depth / slant) ** 3 - 1, abs=1e-12)
        radial = -(1 + 2 * nu) / 2 + (1 + nu) * depth / slant - (depth / slant) ** 3 / 2
        assert fields.stress_rr == pytest.approx(radial, abs=1e-12)
        moved = (1 + nu) / 2 * (1 / slant + (1 - 2 * nu) * (slant - depth))
        assert fields.displacement == pytest.approx(moved, rel=1e-12)


class OnPad(Punch):
    """The independent history of `independent`, with the layer's compliance added."""

    def __init__(self, thickness, poisson_ratio, *punch):
        self.pad = thickness, poisson_ratio
        super().__init__(*punch)

    def _triangular_energy(self):
        half_space = super()._triangular_energy()
        thickness, poisson_ratio = self.pad
        s, lengths = wave_numbers(thickness, 2.0)
        bessel = j0(np.outer(self.radius, s)) * self.length[:, None] / 2
        transforms = np.zeros((self.first[-1], len(s)))
        for number, lower in enumerate(self.orthogonal):
            on = self.owner == number
            moments = self._legendre(number, self.local[on]).T @ bessel[on]
            columns = slice(self.first[number], self.first[number + 1])
            transforms[columns] = solve_triangular(lower, moments, lower=True)
        weights = 4 * np.pi * lengths * (kernel(s * thickness, poisson_ratio) - 1)
        return cholesky(half_space.T @ half_space + (transforms * weights) @ transforms.T)


@pytest.mark.parametrize(("degree", "rtol"), [(12, 2e-6), *slow((16, 2e-8))])
def test_rings_on_the_pad_against_an_independent_solution(degree, rtol):
    answers = ANSWERS[16].astype({"value": float})
    wear, force = np.array([1.0, 10.0, 1.0, 10.0, 1.0]), 2.0
    pieces = Pieces(np.linspace(0, 1, 6), wear, wear)
    punch = OnPad(0.1, 0.3, pieces, np.append(np.inf, np.full(5, 1e-6)), degree)
    (slowest,) = answers[answers["quantity"] == "relaxation_time"]["value"]
    assert slowest == pytest.approx(punch.times[0], rel=1e-9)
    later = answers[answers["time"] > 0]
    times, radii = later["time"].unique(), later["radius"].dropna().unique()
    pressures = punch.pressures(CONSTANT, times)
    indentation = punch.depths(CONSTANT, times, pressures)
    of_pressures, of_heights, _ = punch.fields(radii)
    fields = {
        "pressure": pressures @ of_pressures.T,
        "profile": punch.worn(indentation, pressures) @ of_heights.T,
    }
    assert table_of(later, "indentation").ravel() == pytest.approx(force * indentation, rel=1e-9)
    for quantity, values in fields.items():
        assert table_of(later, quantity) == pytest.approx(force * values, rel=rtol)


def table_of(answers, quantity):
    """Return the values of a quantity, with a row for each time and a column for each radius."""
    rows = answers[answers["quantity"] == quantity]
    return pd.pivot_table(rows.fillna(0.0), "value", "time", "radius", sort=True).to_numpy()
