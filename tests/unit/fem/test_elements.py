"""Elements of scikit-fem and of users: which ones work, and which are refused."""

import numpy as np
import pytest
import skfem
from conftest import WITHOUT_GMSH

from ringwear import SceneError, SizeField, bisection, press_flat
from ringwear.fem.elasticity import AxisymmetricElasticity
from ringwear.fem.elements import degree_along_side, is_on_quadrilaterals
from ringwear.fem.far_field import enough_poles
from ringwear.fem.half_space import HalfSpace, pressure_space
from ringwear.fem.weak_form import tables
from ringwear.meshes.by_gmsh import quads
from ringwear.meshes.ground.ground import Ground
from ringwear.meshes.half_space import as_half_space

FLAT = np.array([0.0, 1.0])
TRIANGLES = bisection.mesh(SizeField((0.0, 1.0), 0.01, 0.05, 0.6, 5.0))


def mesh_for(element):
    """Return triangles by bisection or quadrilaterals by gmsh, depending on the element."""
    if not is_on_quadrilaterals(element):
        return TRIANGLES
    if WITHOUT_GMSH:
        pytest.skip(WITHOUT_GMSH)
    mesh = quads.graded(FLAT, 0.05, 0.01, 0.4, 1.0, 2.5).mesh
    # without subdomains, so that the degree is the same everywhere
    return as_half_space(skfem.MeshQuad(mesh.p, mesh.t), FLAT)


class Quadratic(skfem.ElementTriP2):
    """Element of a user, equal to ElementTriP2."""


class Discontinuous(skfem.ElementTriP2):
    """Element whose functions on a side are no polynomials of degree 2."""

    def lbasis(self, X, i):
        """Return a function of the triangle and its gradient."""
        value, gradient = super().lbasis(X, i)
        return (value + 0.1, gradient) if i == 0 else (value, gradient)


class Halved(skfem.ElementQuadP):
    """Element with the degrees of freedom of ElementQuadP and other functions."""

    def lbasis(self, X, i):
        """Return half a function and half its gradient."""
        value, gradient = super().lbasis(X, i)
        return value / 2, gradient / 2


@pytest.mark.parametrize("element", [*map(skfem.ElementQuadP, (3, 4, 9)), Halved(3)])
def test_functions_and_gradients_are_those_of_the_element(element):
    points = np.random.default_rng(1).random((2, 7))
    # a coordinate occurs twice, as in a product rule
    points[0, 3] = points[1, 5]
    values, gradients = tables(element, np.arange(len(element.doflocs)), points)
    assert len(values) == (element.p + 1) ** 2
    for i in range(len(values)):
        value, gradient = element.lbasis(points, i)
        np.testing.assert_array_equal(values[i], value)
        np.testing.assert_array_equal(gradients[i], gradient)


@pytest.mark.parametrize(
    ("element", "degree"),
    [
        (skfem.ElementTriP1(), 1),
        (skfem.ElementTriP1B(), 1),
        (skfem.ElementTriMini(), 1),
        (skfem.ElementTriP2(), 2),
        (skfem.ElementTriP2B(), 2),
        (skfem.ElementTriCCR(), 2),
        (Quadratic(), 2),
        (skfem.ElementTriP4(), 4),
        (skfem.ElementQuad1(), 1),
        (skfem.ElementQuad2(), 2),
        (skfem.ElementQuadS2(), 2),
        (skfem.ElementQuadP(3), 3),
    ],
    ids=lambda value: type(value).__name__ if isinstance(value, skfem.Element) else str(value),
)
def test_flat_punch_by_elements(element, degree):
    """The indentation is F / (2 a E*) = 1/2; ten linear facets have an error of about h^2."""
    assert degree_along_side(element) == degree
    mesh = mesh_for(element)
    solid = AxisymmetricElasticity(mesh, degree, Ground.half_space(0.3), own_element=element)
    poles = enough_poles(float(mesh.p[0].max()), 1e-9)
    half_space = HalfSpace(solid, pressure_space(solid, FLAT), poles)
    error = press_flat(half_space.compliance()).indentation / 0.5 - 1
    assert abs(error) <= (0.1 if degree == 1 else 0.01)


@pytest.mark.parametrize(
    ("element", "reason"),
    [
        (skfem.ElementTriCR(), "not continuous"),
        (skfem.ElementTriP0(), "not continuous"),
        (skfem.ElementDG(skfem.ElementTriP2()), "ElementH1"),
        (skfem.ElementTriHermite(), "ElementH1"),
        (skfem.ElementTriMorley(), "ElementH1"),
        (skfem.ElementTriP1G(), "ElementH1"),
        (skfem.ElementTriRT0(), "ElementH1"),
        (skfem.ElementQuadBFS(), "ElementH1"),
        (skfem.ElementTetP1(), "neither on triangles"),
        (skfem.ElementVector(skfem.ElementTriP2()), "is a vector"),
        (Discontinuous(), "not the polynomials of degree 2"),
    ],
    ids=lambda value: type(value).__name__ if isinstance(value, skfem.Element) else "",
)
def test_unsuitable_elements_are_refused_in_one_line(element, reason):
    with pytest.raises(SceneError, match=reason) as refusal:
        degree_along_side(element)
    assert "\n" not in str(refusal.value)
    assert "use Element" in str(refusal.value)
    assert type(element).__name__ in str(refusal.value)


def test_an_element_has_to_fit_mesh_and_degree():
    with pytest.raises(SceneError, match="use ElementTriP1 to"):
        AxisymmetricElasticity(
            TRIANGLES, 2, Ground.half_space(0.3), own_element=skfem.ElementQuad2()
        )
    with pytest.raises(SceneError, match="give degree = 2"):
        AxisymmetricElasticity(
            TRIANGLES, 3, Ground.half_space(0.3), own_element=skfem.ElementTriP2()
        )
    with pytest.raises(SceneError, match="1 to 4 on triangles"):
        _ = AxisymmetricElasticity(TRIANGLES, 5, Ground.half_space(0.3)).dofs
