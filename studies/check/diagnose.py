"""What the error of another program's results looks like.

Faults that people make are put into our own results. The part of their error that a fault explains
is the confidence in it.
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from scipy.interpolate import interp1d
from scipy.optimize import minimize_scalar

from ...meshes.errors import RingwearError
from ...meshes.radial import Array
from ..methods.base import method
from ..methods.norms import Results
from ..problem.quantities import QUANTITIES
from ..progress import Stages
from .comparison import Comparison


@dataclass(frozen=True)
class Diagnosis:
    """What an error looks like.

    Parameters
    ----------
    name : of the fault
    size : its number
    words : what the results look like, with the number
    confirm : what would confirm it
    confidence : up to 1: the part of the error that the fault explains
    """

    name: str
    size: float
    words: str
    confirm: str
    confidence: float


def diagnose(comparison: Comparison, least: float = 0.6) -> list[Diagnosis]:
    """Return what the error of their results looks like, the most confident first.

    Parameters
    ----------
    comparison : Comparison
    least : float
        Confidence below which nothing is said.

    Returns
    -------
    list of Diagnosis
        Empty if nothing fits, or if the error is below the accuracy that the scene asks for.

    Notes
    -----
    A fault that the scene cannot have, such as another radius of a punch with a profile that is
    given up to the rim, is passed over.
    """
    theirs, problem = comparison.theirs, comparison.scene.problem
    forces = problem.loading.at(comparison.times / problem.units.time).force
    ours = {"normal_force": forces * problem.units.force, **comparison.ours}
    with np.errstate(all="ignore"):
        usable = {name: np.isfinite(theirs[name] / ours[name]) for name in theirs}
    ours = {name: np.where(at, ours[name], np.nan) for name, at in usable.items() if at.any()}
    comparison = replace(comparison, ours=ours)
    if _distance(comparison, ours) <= problem.rtol:
        return []
    faults = [*_of_model(comparison), *_of_numbers(comparison), *_of_pressure(comparison)]
    likely = [fault for fault in faults if fault.confidence > least]
    return sorted(likely, key=lambda fault: -fault.confidence)


def _misfit(comparison: Comparison, results: Results, name: str) -> Array:
    """Return theirs less other results over ours, NaN where it cannot be compared."""
    return (comparison.theirs[name] - results[name]) / comparison.ours[name]


def _distance(comparison: Comparison, results: Results) -> float:
    """Return the root mean square misfit of results, each quantity of equal weight."""
    misfits = [_misfit(comparison, results, name) ** 2 for name in results]
    return float(np.sqrt(sum(np.nansum(misfit) / misfit.size for misfit in misfits)))


def _explained(comparison: Comparison, predicted: Results) -> float:
    """Return the part of the error of the quantities predicted that the prediction explains."""
    whole = _distance(
        comparison, {name: comparison.ours[name] + 0 * predicted[name] for name in predicted}
    )
    return (whole - _distance(comparison, predicted)) / (whole or 1.0)


def _solve(comparison: Comparison, **changes: Any) -> Results:
    """Return our results with changes of the scene, to a thousandth; ours if it cannot have them."""
    try:
        scene = comparison.scene.changed(
            wear__times=comparison.times.tolist(),
            output__radii=comparison.radii.tolist() or None,
            output__quantities=list(comparison.ours),
            accuracy__rtol=1e-3,
            **changes,
        )
        solved = method("mdr").solve(scene.problem, Stages("mdr")).results
    except RingwearError:
        return comparison.ours
    units = scene.problem.units
    return comparison.ours | {
        name: solved[name] * getattr(units, QUANTITIES[name].unit)
        for name in comparison.ours.keys() & solved.keys()
    }


def _of_model(comparison: Comparison) -> Iterator[Diagnosis]:
    """Return faults of what has been modelled."""
    problem, punch, ours = comparison.scene.problem, comparison.scene.punch, comparison.ours
    wear = np.array(punch.coefficients)
    swapped = _solve(
        comparison,
        punch__wear_coefficients=(wear.min() + wear.max() - wear).tolist(),
        punch__wear_coefficient=None,
        punch__wear_ratio=None,
    )
    yield Diagnosis(
        "swapped materials",
        1.0,
        "the wear coefficients of two materials are swapped",
        "late pressures are greatest where wear is least",
        _explained(comparison, swapped),
    )
    for size in (2.0, 0.5):
        edges = punch.ring_edges and [size * edge for edge in punch.ring_edges]
        widened = _solve(comparison, punch__radius=size * punch.radius, punch__ring_edges=edges)
        yield Diagnosis(
            "radius for diameter",
            size,
            f"a punch of {size:.3g} times the radius: a diameter for a radius, or the reverse",
            "the radius in the model where pressures end",
            _explained(comparison, widened),
        )
    plane = 1 - problem.poisson_ratio**2
    for size in (plane, 1 / plane):
        stiffened = _solve(
            comparison,
            half_space__plane_strain_modulus=size * problem.units.modulus,
            half_space__youngs_modulus=None,
        )
        yield Diagnosis(
            "Poisson's ratio",
            size,
            f"a half-space {size:.4g} times as stiff: E for E/(1 - nu^2), or the reverse",
            "with a Poisson's ratio of 0 the error is gone",
            _explained(comparison, stiffened),
        )
    lengths = [name for name in ours if QUANTITIES[name].unit == "displacement"]
    depths = [name for name in lengths if name != "profile"]
    if not depths:
        return
    low = np.hstack([(ours[name] - comparison.theirs[name]).ravel() for name in depths])
    offset = float(np.nanmedian(low))
    # relative error of d0 of a clamped half-space over a/R (`study truncation`)
    clamped = np.interp(problem.poisson_ratio, [0, 0.3, 0.45, 0.5], [0.94, 1.09, 1.51, 1.91])
    reach = clamped * problem.units.displacement / 2 / (offset or 1.0)
    truncated = {name: ours[name] - offset * (name in depths) for name in lengths}
    yield Diagnosis(
        "truncated half-space",
        reach,
        f"displacements too small by one length: a half-space truncated at about {reach:.3g} a",
        "a half-space twice as large has half the error",
        _explained(comparison, truncated) * (offset > 0),
    )
    last = float(comparison.times[-1])
    step = last / 50
    stepped = _solve(comparison, wear__march="implicit", wear__step=step)
    size = step * np.nanmedian(
        np.hstack([((comparison.theirs[n] - ours[n]) / (stepped[n] - ours[n])).ravel() for n in depths])
    )
    drift = {name: ours[name] + size / step * (stepped[name] - ours[name]) for name in lengths}
    yield Diagnosis(
        "first-order time step",
        size,
        f"steps of first order in time, of about {size:.3g} (below 0: explicit ones)",
        "half the time step has half the error",
        _explained(comparison, drift),
    )
    histories = {name: interp1d(comparison.times, ours[name], axis=0) for name in lengths}

    def shift(late: float) -> Results:
        times = np.maximum(comparison.times - late, comparison.times[0])
        return {name: history(times) for name, history in histories.items()}

    late = minimize_scalar(lambda late: _distance(comparison, shift(late)), bounds=(0, last)).x
    yield Diagnosis(
        "late start",
        late,
        f"a history that starts about {late:.3g} too late",
        "with this taken off the times the error is gone",
        _explained(comparison, shift(late)),
    )


def _of_numbers(comparison: Comparison) -> Iterator[Diagnosis]:
    """Return faults of numbers that are off by a factor, each quantity by its own."""
    ours, plane = comparison.ours, 1 - comparison.scene.problem.poisson_ratio**2
    ratios = {name: 1 + float(np.nanmedian(_misfit(comparison, ours, name))) for name in ours}
    size = max(ratios.values(), key=lambda ratio: abs(np.log(abs(ratio) or 1.0)))
    factors = {2 * np.pi: "2 pi missing", 1e3: "units", 1e6: "units", 1e9: "units"}
    factors[plane] = "Poisson's ratio"
    power = abs(np.log(abs(size) or 1.0))
    nearest = min(factors, key=lambda factor: abs(power - abs(np.log(factor))))
    yield Diagnosis(
        factors[nearest] if abs(power - abs(np.log(nearest))) < 0.01 else "constant factor",
        size,
        "over ours at all times and radii: "
        + ", ".join(f"{name} {ratio:.4g}" for name, ratio in ratios.items()),
        "units; the load; the sum of 2 pi r p dr beside it; results with a Poisson's ratio of 0",
        _explained(comparison, {name: ours[name] * ratios[name] for name in ours}),
    )


def _of_pressure(comparison: Comparison) -> Iterator[Diagnosis]:
    """Return faults of the mesh, by the place and the sign of errors of pressure."""
    if "pressure" not in comparison.ours or len(comparison.radii) < 2:
        return
    error = np.nan_to_num(_misfit(comparison, comparison.ours, "pressure"))
    squares = error**2 * np.gradient(comparison.radii)
    early = squares[: (len(squares) + 1) // 2, comparison.radii > 0.8 * comparison.radii[-1]]
    size = float(np.abs(error).max())
    yield Diagnosis(
        "coarse rim",
        size,
        f"errors of pressure, to {size:.2g}, that are at the rim and fall as it wears",
        "half the element size at the rim changes the first pressures most",
        1 - float(np.sqrt(1 - early.sum() / (squares.sum() or 1.0))),
    )
    yield Diagnosis(
        "checkerboard",
        size,
        f"errors of pressure, to {size:.2g}, that change their sign from radius to radius",
        "means of neighbours lose it: pressures are too rich for the displacements",
        -float(np.sum(error[:, 1:] * error[:, :-1]) / (np.sum(error**2) or 1.0)),
    )
