"""The paper's claims beside our values: `claims.toml` says what is judged, and how.

Here are the quantities that it names. A pandas series has a value for each number of rings.
"""

import operator
import time
import tomllib
from importlib.resources import files
from string import Formatter
from typing import Any

import numpy as np
import pandas as pd
import xarray

from ...mdr import direct
from ...meshes.radial import Array, alternating_edges, ring_areas
from ..problem.problem import P0, Rings
from .gradients import WEAR_RATIO_OF_WIDTHS, direct_gradients, homogeneous, many_rings
from .running_in import STATIONARY, Evolution, FiveRings

VERDICTS = ("holds", "holds with a remark", "does not hold")
EXTREMES = np.array([0.0, np.inf])  # wear ratios that leave all force to the slower rings
Quantities = dict[str, Any]


class Writer(Formatter):
    """Writes every value of a series, with its label."""

    def format_field(self, value: Any, format_spec: str) -> str:
        if not isinstance(value, pd.Series):
            return format(value, format_spec)
        written = (
            f"{each:{format_spec}} ({f'N = {label}' if isinstance(label, int) else label})"
            for label, each in value.items()
        )
        return ", ".join(written)


def judge_claims(quantities: Quantities) -> list[dict[str, str]]:
    """Return the rows of all claims."""
    text = (files("ringwear.studies") / "paper" / "claims.toml").read_text("utf-8")
    return [judge(claim, quantities) for claim in tomllib.loads(text)["claim"]]


def judge(claim: dict[str, Any], quantities: Quantities) -> dict[str, str]:
    """Return the row of a claim: what is computed for it, and the verdict."""
    write, remark = Writer().vformat, claim.get("remark", "")
    holds = all(is_so(condition, quantities) for condition in claim["holds_if"])
    uncertainty = claim.get("uncertainty", "")
    if uncertainty in quantities:
        uncertainty = f"{np.ptp(quantities[uncertainty]):.0e}"
    return {
        "where": claim["where"],
        "the paper says": claim["says"],
        "computed": write(claim["computed"], (), quantities),
        "verdict": VERDICTS[bool(remark) if holds else 2],
        "why, or what to add": write(remark, (), quantities),
        "uncertainty": uncertainty,
    }


def is_so(condition: str, quantities: Quantities) -> bool:
    """Return whether all values of a quantity are as a condition says.

    Conditions are "name < number", "name > number", "name increases" and "name decreases".
    """
    relations = {"<": operator.lt, ">": operator.gt}
    name, relation, *bound = condition.split()
    values = np.asarray(Formatter().get_field(name, (), quantities)[0])
    if bound:
        return bool(relations[relation](values, float(bound[0])).all())
    steps = np.diff(values)
    return bool(np.all(steps > 0 if relation == "increases" else steps < 0))


def conclude(rows: list[dict[str, str]]) -> list[str]:
    """Return how many claims have which verdict, and those that do not hold."""
    verdicts = [row["verdict"] for row in rows]
    counts = [f"{verdicts.count(verdict)} {verdict}" for verdict in VERDICTS]
    refuted = [
        f"{row['verdict']}: {row['the paper says']}: {row['computed']}"
        for row in rows
        if row["verdict"] == VERDICTS[2]
    ]
    return [f"claims: {', '.join(counts)}", *refuted]


def definitions() -> str:
    """Return what the symbols in the table mean."""
    line, area = homogeneous()
    return (
        f"`p0 = F/(2 pi a^2)`, `d0 = F/(2 a E*)`; `t_stat` is the time to {STATIONARY:.1%} of the "
        "displacement difference; `line` is an average over the radius, `area` over the area, and "
        "gradients are `line` where nothing is said. The homogeneous punch has the gradient "
        f"g0 = {line:.8f} (line), {area:.8f} = 4/pi (area), times p/E*. Uncertainties of the "
        "running-in are the greatest difference of MDR, FEM and BEM; gradients of limiting "
        "profiles (4.2) are by direct integration, to 1e-12."
    )


def measure_running_in(five: FiveRings, slowest: xarray.DataArray) -> Quantities:
    """Return what claims about the running-in (section 3.3, Figs. 4 and 5) and its cost name.

    What every method measures is an array of values by MDR, FEM and BEM.
    """
    in_fast = slowest / np.maximum(slowest.wear_ratio, 1 / slowest.wear_ratio)
    least, greatest = float(slowest.min()), float(slowest.max())
    return {
        **_measure_states(five),
        **_measure_ring_forces(five),
        **_measure_way(five),
        **_measure_cost(five),
        "counts": slowest.rings.values[[0, -1]],
        "slowest": [least, greatest],
        "slowest_factor": greatest / least,
        "slowest_factor_in_fast": float(in_fast.max() / in_fast.min()),
    }


def _measure_states(five: FiveRings) -> Quantities:
    edges, coefficients = five.problem.rings
    states, fast, middles = five.states, coefficients == 1, (edges[1:] + edges[:-1]) / 2
    profile, pressure = states.f_over_d0.values, states.p_over_p0.values
    differences = np.linalg.norm(pressure - pressure[0], axis=2)
    late = five.evolutions["mdr"].states(five.stationary * np.array([1.0, 3.0, 10.0]))
    errors = np.abs(profile[:, -1] - five.limiting.f_over_d0.values).max(axis=1)
    worn = (states.f_over_d0 + states.least_wear_over_d0)[:, 1]
    at_middles = worn.interp(radius=middles).values
    return {
        "solvers": ", ".join(five.evolutions).upper(),
        "profile_difference": np.abs(profile - profile[0]).max(),
        "pressure_difference": (differences / np.linalg.norm(pressure[0], axis=1))[:, 1:].max(),
        "unsteady": np.abs(late.p_over_p0 / five.limiting.p_over_p0 - 1).max("radius").values,
        "slow": pressure[0, -1].max(),
        "fast": pressure[0, -1].min(),
        "limiting_errors": pd.Series(errors, list(five.evolutions)),
        "lowest": pressure.min(axis=(1, 2)),
        "rim": worn.values[:, -1] / at_middles[:, -1],
        "lead": at_middles[:, fast].min(axis=1) / at_middles[:, ~fast].max(axis=1),
        "line": states.gradient[:, 0, 4].values,
        "area": states.gradient[:, 1, 4].values,
    }


def _measure_ring_forces(five: FiveRings) -> Quantities:
    edges, coefficients = five.problem.rings
    steady, fast = direct.steady_pressures(edges, coefficients), coefficients == 1
    forces = five.states.ring_force.values[0]
    carried = forces[:, fast] @ (steady * ring_areas(edges))[fast]
    times = 2 * np.linspace(0, 1, 2001) ** 3
    states = five.evolutions["mdr"].states(five.stationary * times)
    change = np.abs(states.ring_force.values - 1) * steady

    def times_to_settle(scale: Array | float) -> list[float]:
        """Return when the fast rings, and the slow ones, come within 0.1 of their end for good."""
        moving = (change > 0.1 * scale)[::-1]
        return [times[-moving[:, rings].any(axis=1).argmax()] for rings in (fast, ~fast)]

    settled = times_to_settle(P0)
    return {
        "carried": carried,
        "carried_at_first": carried[:2],
        "centre": forces[:, 0],
        "settled": settled,
        "settled_ratio": settled[0] / settled[1],
        "carried_least": carried.min(),
        "settled_relative": times_to_settle(steady),
    }


def _measure_way(five: FiveRings) -> Quantities:
    way, times = five.history.way[0, 1:], five.states.time.values
    rates = way.differentiate("time")
    early, late = rates.interp(time=times[[1, 5]]).values
    printed = five.stationary * times[4] / np.array([0.275, 0.27, 0.265])
    stationary = [evolution.time_of(STATIONARY) for evolution in five.evolutions.values()]
    seventy = [evolution.time_of(0.7) for evolution in five.evolutions.values()]
    return {
        "rates": rates,
        "slowing": early / late,
        "seventy": np.divide(seventy, stationary),
        "stationary": STATIONARY,
        "ended": five.evolutions["mdr"].states(printed).way.values,
    }


def _measure_cost(five: FiveRings) -> Quantities:
    start = time.perf_counter()
    direct.rms_slope(five.problem.ring_edges, direct.steady_pressures(*five.problem.rings))
    integrated = time.perf_counter()
    Evolution(five.problem, five.evolutions["mdr"].compliance).states(np.ones(1))
    integration, march = integrated - start, time.perf_counter() - integrated
    return {"milliseconds": [1e3 * integration, 1e3 * march], "cost": integration / march}


def measure_gradients(
    wear: xarray.Dataset, width: xarray.Dataset, many: tuple[int, ...]
) -> Quantities:
    """Return what claims about Figs. 6 (`wear`) and 7 (`width`) name.

    Parameters
    ----------
    many : numbers of rings that are compared with the limit of many rings
    """
    wear_line, wear_area = tabulate_by_rings(wear, "lowest hundredth equal hundred highest")
    width_line, width_area = tabulate_by_rings(width, "thin equal wide")
    return {
        "wear": wear_line,
        "wear_area": wear_area,
        "width": width_line,
        "width_area": width_area,
        "order": wear_line["hundred"] / wear_line["hundredth"],
        "figures_differ": np.abs(width_line["equal"] / wear_line["hundredth"] - 1).max(),
        **_measure_limit(wear, many),
        **_measure_shape(wear),
        **_measure_widths(width),
    }


def tabulate_by_rings(curves: xarray.Dataset, ratios: str) -> list[pd.DataFrame]:
    """Return tables of the gradients at equally spaced ratios, a row for each number of rings.

    One is averaged over the radius, one over the area.
    """
    names, rows = ratios.split(), curves.rings.values
    chosen = curves.direct.values[:, :, :: 200 // (len(names) - 1)]
    return [pd.DataFrame(chosen[:, average], rows, names) for average in (0, 1)]


def _measure_limit(wear: xarray.Dataset, many: tuple[int, ...]) -> Quantities:
    counts, ratios = [*wear.rings.values, *many], wear.ratio.values
    more = [direct_gradients(alternating_edges(count), ratios)[0] for count in many]
    curves = np.vstack([wear.direct[:, 0], more])
    limit = many_rings(EXTREMES, np.ones(1))[:, 0]
    skew = np.abs(curves / curves[:, ::-1] - 1).max(axis=1)
    distance = np.abs(curves[:, [0, -1]] / limit[0] - 1).max(axis=1)
    return {
        "limit": limit,
        "skew_of_many": skew[-1],
        "skew": pd.Series(skew, counts),
        "skew_power": power_of_fall(counts, skew),
        "distance": pd.Series(distance, counts),
    }


def power_of_fall(counts: Any, values: Array) -> float:
    """Return the power of the number of rings by which the last two of the values fall."""
    return float(np.log(values[-2] / values[-1]) / np.log(counts[-1] / counts[-2]))


def _measure_shape(wear: xarray.Dataset) -> Quantities:
    counts, ratios, both = wear.rings.values, wear.ratio.values, wear.direct.values
    curves = both[:, 0]
    alone = [direct_gradients(alternating_edges(count), EXTREMES)[0] for count in counts]
    decades = np.log10(ratios)
    changes, middle = np.abs(np.gradient(curves, decades, axis=1)), np.abs(decades) <= 2
    within = np.trapezoid(changes[:, middle], decades[middle]) / np.trapezoid(changes, decades)
    steepest = 10 ** np.abs(decades[changes.argmax(axis=1)])
    lowest = pd.Series(curves.min(axis=1), counts)
    return {
        "from_alone": np.abs(curves[:, [0, -1]] / alone - 1).max(),
        "within_hundred": within.min(),
        "steepest": [steepest.min(), steepest.max()],
        "change_above": np.abs(both[:, :, 200] / both[:, :, 150] - 1).max(),
        "change_below": np.abs(both[:, :, 0] / both[:, :, 50] - 1).max(),
        "lowest_gradients": lowest[lowest < 1 - 1e-6],
        "lowest_at": ratios[curves[0].argmin()],
        "below_one": ratios[curves[0] < 1 - 1e-6][[0, -1]],
    }


def _measure_widths(width: xarray.Dataset) -> Quantities:
    counts, curves = width.rings.values, width.direct[:, 0].values
    rings = Rings.alternating(8, 0.1, WEAR_RATIO_OF_WIDTHS)
    forces = direct.steady_pressures(*rings) * ring_areas(rings.ring_edges)
    slow_area = [
        [ring_areas(alternating_edges(count, ratio))[1::2].sum() / np.pi for ratio in (0.1, 1, 10)]
        for count in counts
    ]
    limit = many_rings(np.array([WEAR_RATIO_OF_WIDTHS]), np.array([10.0, 100.0, 1e4]))[0]
    distance = width.limit.values[0, 0] - curves[:, 0]
    return {
        "slow_area": pd.DataFrame(slow_area, counts, ["thin", "equal", "wide"]),
        "over_widths": curves,
        "limit_of_wide": limit,
        "thin_carry": forces[1::2].sum(),
        "thin_alone": direct_gradients(rings.ring_edges, EXTREMES)[0, 0],
        "thin_limit": width.limit.values[:, 0],
        "thin_distance": pd.Series(distance, counts),
        "thin_power": power_of_fall(counts, distance),
    }
