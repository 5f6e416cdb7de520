"""The paper's claims beside our values: `claims.toml` says what is judged, and how.

Here are the quantities that it names. A pandas series has a value for each number of rings.
"""

import time
import tomllib
from importlib.resources import files
from string import Formatter
from typing import Any

import numpy as np
import pandas as pd
import xarray

from ...mdr import direct
from ...meshes.radial import alternating_edges, ring_areas
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


def judge_claims(quantities: Quantities) -> pd.DataFrame:
    """Return the table of all claims."""
    text = (files("ringwear.studies") / "paper" / "claims.toml").read_text("utf-8")
    return pd.DataFrame(judge(claim, quantities) for claim in tomllib.loads(text)["claim"])


def judge(claim: dict[str, Any], quantities: Quantities) -> dict[str, str]:
    """Return the row of a claim: what is computed for it, and the verdict."""
    write, remark = Writer().vformat, claim.get("remark", "")
    holds = all(is_so(condition, quantities) for condition in claim["holds_if"])
    methods = quantities.get(claim.get("uncertainty", ""))
    return {
        "where": claim["where"],
        "the paper says": claim["says"],
        "computed": write(claim["computed"], (), quantities),
        "verdict": VERDICTS[bool(remark) if holds else 2],
        "why, or what to add": write(remark, (), quantities),
        "uncertainty": "" if methods is None else f"{np.ptp(methods):.0e}",
    }


def is_so(condition: str, quantities: Quantities) -> bool:
    """Return whether all values of a quantity are as a condition says.

    Conditions are "name < number", "name > number", "name increases" and "name decreases".
    """
    name, relation, *bound = condition.split()
    values = np.asarray(Formatter().get_field(name, (), quantities)[0])
    match relation:
        case "<":
            so = values < float(*bound)
        case ">":
            so = values > float(*bound)
        case "increases":
            so = np.diff(values) > 0
        case _:
            so = np.diff(values) < 0
    return bool(so.all())


def conclude(claims: pd.DataFrame) -> list[str]:
    """Return how many claims have which verdict, and those that do not hold."""
    counts = claims.verdict.value_counts().reindex(VERDICTS, fill_value=0)
    refuted = claims[claims.verdict == VERDICTS[2]]
    return [
        "claims: " + ", ".join(f"{count} {verdict}" for verdict, count in counts.items()),
        *(VERDICTS[2] + ": " + refuted["the paper says"] + ": " + refuted["computed"]),
    ]


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
    least, greatest = float(slowest.min()), float(slowest.max())
    return {
        **_measure_states(five),
        **_measure_ring_forces(five),
        **_measure_way(five),
        **_measure_cost(five),
        "counts": slowest.rings.values[[0, -1]],
        "slowest": [least, greatest],
        "slowest_factor": greatest / least,
    }


def _measure_states(five: FiveRings) -> Quantities:
    edges, coefficients = five.problem.rings
    states, fast, middles = five.states, coefficients == 1, (edges[1:] + edges[:-1]) / 2
    profile, pressure = states.f_over_d0.values, states.p_over_p0.values
    differences = np.linalg.norm(pressure - pressure[0], axis=2)
    late = five.evolutions["mdr"].states(five.stationary * np.array([1.0, 3.0, 10.0]))
    errors = np.abs(profile[:, -1] - five.limiting.f_over_d0.values).max(axis=1)
    # in the 10 % state
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
    # after fast rings, and slow ones, are last further than 0.1 p0 from their end
    moving = np.abs(states.ring_force.values - 1) * steady > 0.1 * P0
    settled = [
        times[np.flatnonzero(moving[:, rings].any(axis=1))[-1] + 1] for rings in (fast, ~fast)
    ]
    return {
        "carried": carried,
        "carried_at_first": carried[:2],
        "carried_least": carried.min(),
        "centre": forces[:, 0],
        "settled": settled,
        "settled_ratio": settled[0] / settled[1],
    }


def _measure_way(five: FiveRings) -> Quantities:
    rates = five.history.way[0, 1:].differentiate("time")
    early, late = rates.interp(time=five.states.time.values[[1, 5]]).values
    seventy, stationary = (
        np.array([evolution.time_of(way) for evolution in five.evolutions.values()])
        for way in (0.7, STATIONARY)
    )
    return {
        "rates": rates,
        "slowing": early / late,
        "seventy": seventy / stationary,
        "stationary": STATIONARY,
    }


def _measure_cost(five: FiveRings) -> Quantities:
    start = time.perf_counter()
    direct.rms_slope(five.problem.ring_edges, direct.steady_pressures(*five.problem.rings))
    integrated = time.perf_counter()
    Evolution(five.problem, five.evolutions["mdr"].wear.compliance).states(np.ones(1))
    integration, march = integrated - start, time.perf_counter() - integrated
    return {"milliseconds": [1e3 * integration, 1e3 * march], "cost": integration / march}


def tabulate_by_rings(curves: xarray.Dataset, names: dict[float, str]) -> list[pd.DataFrame]:
    """Return tables of the gradients, averaged over the radius and over the area.

    A row for each number of rings, a column for each ratio; some ratios have names.
    """
    return [
        curves.direct.sel(average=average).to_pandas().rename(columns=names)
        for average in curves.average.values
    ]


def measure_wear_ratios(curves: xarray.Dataset, many: tuple[int, ...]) -> Quantities:
    """Return what claims about Fig. 6 name.

    Parameters
    ----------
    many : numbers of rings that are compared with the limit of many rings
    """
    names = {1e-4: "lowest", 0.01: "hundredth", 100.0: "hundred", 1e4: "highest"}
    by_ratio, by_ratio_area = tabulate_by_rings(curves, names)
    counts, ratios, both = curves.rings.values, curves.ratio.values, curves.direct.values
    line, decades = both[:, 0], np.log10(ratios)
    of_many = [direct_gradients(alternating_edges(count), ratios)[0] for count in many]
    all_rings = np.vstack([line, *of_many])
    skew = np.abs(all_rings / all_rings[:, ::-1] - 1).max(axis=1)
    alone = [direct_gradients(alternating_edges(count), EXTREMES)[0] for count in counts]
    changes, middle = np.abs(np.gradient(line, decades, axis=1)), np.abs(decades) <= 2
    within = np.trapezoid(changes[:, middle], decades[middle]) / np.trapezoid(changes, decades)
    steepest = 10 ** np.abs(decades[changes.argmax(axis=1)])
    lowest = by_ratio.min(axis=1)
    return {
        "wear": by_ratio,
        "wear_area": by_ratio_area,
        "order": by_ratio["hundred"] / by_ratio["hundredth"],
        "limit": many_rings(EXTREMES, np.ones(1))[:, 0],
        "skew": pd.Series(skew, [*counts, *many]),
        "skew_of_many": skew[-1],
        "from_alone": np.abs(line[:, [0, -1]] / alone - 1).max(),
        "within_hundred": within.min(),
        "steepest": [steepest.min(), steepest.max()],
        "change_above": np.abs(both[:, :, 200] / both[:, :, 150] - 1).max(),
        "change_below": np.abs(both[:, :, 0] / both[:, :, 50] - 1).max(),
        "lowest_gradients": lowest[lowest < 1 - 1e-6],
        "lowest_at": ratios[line[0].argmin()],
    }


def measure_width_ratios(curves: xarray.Dataset, by_wear_ratio: pd.DataFrame) -> Quantities:
    """Return what claims about Fig. 7 name, by the table of Fig. 6."""
    names = {0.1: "thin", 1.0: "equal", 10.0: "wide"}
    by_ratio, by_ratio_area = tabulate_by_rings(curves, names)
    rings = Rings.alternating(8, 0.1, WEAR_RATIO_OF_WIDTHS)
    forces = direct.steady_pressures(*rings) * ring_areas(rings.ring_edges)
    slow_area = {
        name: [
            ring_areas(alternating_edges(count, ratio))[1::2].sum() / np.pi
            for count in by_ratio.index
        ]
        for ratio, name in names.items()
    }
    return {
        "width": by_ratio,
        "width_area": by_ratio_area,
        "figures_differ": (by_ratio["equal"] / by_wear_ratio["hundredth"] - 1).abs().max(),
        "slow_area": pd.DataFrame(slow_area, by_ratio.index),
        "limit_of_wide": many_rings(np.array([WEAR_RATIO_OF_WIDTHS]), np.array([10.0, 100.0, 1e4]))[
            0
        ],
        "thin_carry": forces[1::2].sum(),
        "thin_alone": direct_gradients(rings.ring_edges, EXTREMES)[0, 0],
        "thin_limit": curves.limit.values[:, 0],
    }
