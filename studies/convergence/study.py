"""Orders of convergence in the element size and the degree.

Finite elements and MDR, graded and uniform meshes.

For finite elements one base mesh is subdivided: an order is only as clean as its sequence of
meshes.

Theory, for displacements of degree k and pressures of degree q: energies (d0, displacements,
relaxation times) are of order 2k on graded meshes and of order 1, set by the singular rim, on
uniform ones. By MDR the energy norm of a pressure is half an order weaker than the mean square: d0
is of order 2q+3, a history with its mean squares of order 2q+2, the RMS gradient of order 2q. Even
degrees come up to 2q+3, odd ones down: plane waves ``exp(ikx)`` at kh = 0.7 give 5.34, 6.60, 9.21,
10.77 (Fourier analysis, in the tests). Under a smooth pressure twelve elements see the limit;
graded to the rim, degree 4 meets roundoff before.

On quadrilaterals whose layers shrink by ``q``, the degree k itself is raised (hp). A layer ends one
layer off the singular point: polynomials converge there as ``r^k`` with ``r = (1-sqrt q)/(1+sqrt
q)``, by Bernstein's ellipse (Gui & Babuška 1986), and energies as ``r^2k``: a factor of 9 per
degree for q = 1/4. Layers further in have lower degrees, but ever less energy: they take some of
the factor, and powers of k make it greater at first.
"""

import argparse
from pathlib import Path

import numpy as np

from ..figures.style import legend_below, new_figure
from ..problem.defaults import FACTOR
from ..problem.scene import Scene
from ..tables import Table, write_page
from .cases import DIGITS, QUAD_DEGREES, SMOOTH, refinements
from .orders import ORDER_FIELDS, Sequence, draw_errors, draw_orders, refined, verdicts

GAIN = (
    (1 + FACTOR**0.5) / (1 - FACTOR**0.5)
) ** 2  # factor per degree on quadrilaterals, by theory


def conduct(scene: Scene, out: Path, options: argparse.Namespace) -> list[str]:
    """Refine everything.

    Writes `convergence.csv`, `orders.csv`, `convergence.md` and `convergence.png`.
    """
    conclusions: list[str] = []
    sequences = refined(
        refinements(scene.problem, options.quick), out / "convergence.csv", conclusions
    )
    orders = Table(out / "orders.csv", ORDER_FIELDS, (one.summary() for one in sequences))
    conclusions[:0] = conclude(sequences)
    draw(sequences, out / "convergence.png")
    write_page(out / "convergence.md", "Orders of convergence", conclusions, {"Orders": orders})
    return [*conclusions, orders.markdown()]


def of(sequences: list[Sequence], name: str, quantity: str = "d0") -> list[Sequence]:
    """Sequences of a quantity whose name begins so."""
    return [one for one in sequences if one.quantity == quantity and one.name.startswith(name)]


def conclude(sequences: list[Sequence]) -> list[str]:
    """The orders of d0 in a line, how all orders agree with theory, and what a degree gains on
    quadrilaterals.
    """
    graded, uniform = (
        ", ".join(
            f"{one.name[4:6]} {one.order:.2f}"
            for one in of(sequences, "FEM P")
            if one.name.endswith(mesh)
        )
        for mesh in ("graded", "uniform")
    )
    return [
        f"d0 converges with order {graded} on graded meshes (theory 4, 6, 8), but {uniform} on "
        "uniform ones (1).",
        verdicts(sequences),
        *(
            f"On quadrilaterals each degree takes the error of d0 down by {10**one.order:.1f} "
            "(theory: in the end "
            f"{GAIN:.0f}), to {one.errors[-1]:.0e} at degree {-np.log10(one.sizes[-1]):.0f}."
            for one in of(sequences, "FEM quads")
        ),
    ]


def draw(sequences: list[Sequence], path: Path) -> None:
    """Finite elements by size and by unknowns, MDR under a singular and a smooth pressure, and
    errors by degree.
    """
    figure = new_figure(9, 14)
    (elements, unknowns), (singular, smooth), (punch, rings) = figure.subplots(3, 2)
    error = r"relative error of the flat start, $|d_0 / (F/2aE^*) - 1|$"
    size = r"element size over the base mesh's, $h/h_0 = 1/n$"
    draw_orders(elements, of(sequences, "FEM P"), size, error, "finite elements, by size")
    size = r"$(1-\sqrt{q})/(1+\sqrt{q})$, $q$ the ratio of neighbouring sizes"
    draw_orders(
        singular, of(sequences, "MDR degree"), size, error, "MDR, elements graded to the rim"
    )
    size, title = (
        "element size over the punch radius, $h/a$",
        r"MDR, smooth pressure $\exp(-2r^2/a^2)$",
    )
    draw_orders(smooth, of(sequences, "MDR", SMOOTH), size, "fraction of energy lost", title)
    by_unknowns = {
        one.name.removesuffix(DIGITS): (one.unknowns, one.errors) for one in of(sequences, "FEM")
    }
    draw_errors(
        unknowns, by_unknowns, xlabel="unknowns", ylabel=error, title="finite elements, by unknowns"
    )
    unknowns.set_xscale("log")
    legend_below(unknowns, ncols=2)
    for axes, what in ((punch, "flat start"), (rings, "rings on quadrilaterals")):
        raised = [
            one
            for one in sequences
            if one.name.endswith(DIGITS) and (one.quantity == "d0") == (axes is punch)
        ]
        if not raised:
            # without gmsh there are no quadrilaterals
            axes.set_visible(False)
            continue
        names = [
            f"{one.name.split(',')[0]}, {one.quantity}: {10**one.order:.1f} per degree"
            for one in raised
        ]
        curves = {
            name: (-np.log10(one.sizes), one.errors)
            for name, one in zip(names, raised, strict=True)
        }
        draw_errors(
            axes,
            curves,
            xlabel="polynomial degree $k$",
            ylabel="relative error",
            title=f"degree raised, {what}",
        )
        theory, label = (
            1e-5 * GAIN ** (4.0 - np.array(QUAD_DEGREES)),
            f"theory for quads: {GAIN:.0f} per degree",
        )
        axes.semilogy(QUAD_DEGREES, theory, color="0.8", linewidth=4, zorder=0, label=label)
        legend_below(axes)
    figure.savefig(path)
