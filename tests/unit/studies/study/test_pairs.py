"""Measures of pairs of elements equal those of an eigensolver and of wear in full contact."""

import numpy as np
import pytest
from scipy.linalg import eigh

from ringwear import Compliance, RunningIn, Scene, energy
from ringwear.studies.study.way import Case
from ringwear.studies.study.ways.pairs import (
    Meshes,
    Pressures,
    basis,
    condense,
    displacement_by_name,
    solution_on,
)

CASE = Case.of(Scene.load("five_rings").changed(wear__times=[0.0, 0.1, 1.0]))
RINGS = CASE.problem.merged


def test_measures_equal_those_of_an_eigensolver_and_of_wear_in_full_contact():
    """An eigensolver of the full energies, and wear in full contact, use the same pressures."""
    displacement, pressures = displacement_by_name("P3"), Pressures("wear rate continuous", 2)
    mesh = Meshes(RINGS).halved(0, on_quadrilaterals=False)
    condensed = condense(mesh, displacement, RINGS, 0.3)
    of_pressures = basis(condensed.space, pressures, RINGS, condensed.half_space.solid)
    compared = solution_on(CASE.problem, condensed, of_pressures).compared
    jumping = Pressures("broken at ring edges", 2)
    embedding = basis(condensed.space, jumping, RINGS, condensed.half_space.solid)
    degrees, edges = np.full(len(condensed.space.degrees), 2), RINGS.ring_edges
    space = type(condensed.space)(condensed.space.breakpoints, degrees, edges)
    compliance = Compliance(space, (embedding.T @ condensed.fem_factor.T).T)
    joined = space.joined(RINGS.wear_coefficients).toarray()
    energies = [joined.T @ each.matrix @ joined for each in (compliance, energy.compliance(space))]
    least = eigh(*energies, eigvals_only=True)[0]
    assert float(compared["least_eigenvalue"]) == pytest.approx(least, rel=1e-6)
    worn = RunningIn(compliance, RINGS.wear_coefficients).modal(CASE.problem.times[1:])
    assert compared["indentation"][1:] == pytest.approx(worn.indentation, rel=1e-9)
    at_radii = worn.pressure @ space.matrix(CASE.problem.face.radii).T
    np.testing.assert_allclose(compared["pressure"][1:], at_radii, rtol=1e-6, atol=1e-8)
