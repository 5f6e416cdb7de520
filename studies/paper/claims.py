"""Compare the paper's claims with computed values."""

from collections.abc import Iterator

import numpy as np
import pandas as pd
import xarray

from .theory import FIG7_WEAR_RATIO, STATIONARY_FRACTION, homogeneous, many_rings

FINDINGS = ("holds", "holds with a remark", "does not hold")


# a row of the table of claims
Row = dict[str, str]


def claim(where: str, says: str, computed: str, holds: bool, remark: str = "") -> Row:
    """Return the row of a claim of the paper: a sentence with a number or a trend.

    Parameters
    ----------
    where : section and figure
    says : sentence of the paper
    computed : computed values that the claim is checked against
    holds : whether the claim holds
    remark : why the claim does not hold, or what has to be added to it
    """
    return {
        "where": where,
        "the paper says": says,
        "computed": computed,
        "finding": FINDINGS[bool(remark) if holds else 2],
        "why, or what to add": remark,
    }


def tabulate_claims(
    states: xarray.Dataset,
    history: xarray.DataArray,
    by_wear_ratio: xarray.Dataset,
    by_width_ratio: xarray.Dataset,
) -> pd.DataFrame:
    """Return the table of all claims, checked with the data of Figs. 4, 5, 6 and 7."""
    return pd.DataFrame(
        [
            *claims_on_running_in(states, history),
            *claims_on_wear_ratios(by_wear_ratio),
            *claims_on_width_ratios(by_width_ratio),
        ]
    )


def conclusions_of_claims(claims: pd.DataFrame) -> list[str]:
    """Return sentences: numbers of claims by finding, claims that do not hold, and symbols."""
    counts = claims.finding.value_counts().reindex(FINDINGS, fill_value=0)
    refuted = claims[claims.finding == FINDINGS[2]]
    line, area = homogeneous()
    return [
        "claims: " + ", ".join(f"{count} {finding}" for finding, count in counts.items()),
        *(FINDINGS[2] + ": " + refuted["the paper says"] + ": " + refuted["computed"]),
        "`p0 = F/(2 pi a^2)`, `d0 = F/(2 a E*)`; `t_stat` is the time to "
        f"{STATIONARY_FRACTION:.1%} of the displacement difference; `line` is an average over the "
        "radius, `area` over the area, and gradients are `line` if nothing else is stated. The "
        f"homogeneous punch has the gradient g0 = {line:.8f} (line), {area:.8f} = 4/pi (area), "
        "times p/E*.",
    ]


def claims_on_running_in(states: xarray.Dataset, history: xarray.DataArray) -> Iterator[Row]:
    """Yield rows of claims of section 3.3, Figs. 4 and 5."""
    profile, pressure = states.f_over_d0.values, states.p_over_p0.values
    norms = np.linalg.norm(pressure, axis=2)
    pressure_differences = np.linalg.norm(pressure - pressure[0], axis=2) / norms
    profile_difference = np.abs(profile - profile[0]).max()
    yield claim(
        "3.3, Fig. 4",
        "MDR and BEM match within a small tolerance",
        f"{', '.join(states.solver.values).upper()}: profiles within {profile_difference:.1e} d0, "
        f"pressures after the start within {pressure_differences[:, 1:].max():.1e} (root mean "
        "square over the radius)",
        max(profile_difference, pressure_differences[:, 1:].max()) < 0.01,
        "at t = 0 the pressure is infinite at the rim, so that a pointwise comparison there is "
        "meaningless",
    )
    slow, fast = pressure[0, -1].max(), pressure[0, -1].min()
    yield claim(
        "3.3, Eq. 24",
        "in the end slow rings are under more than three times p0, fast rings under less than half",
        f"{slow:.4f} p0 and {fast:.4f} p0",
        slow > 3 and fast < 0.5,
    )
    errors = np.abs(profile[:, -1] - states.limiting_f_over_d0.values).max()
    yield claim(
        "5",
        "the same limiting profile can be computed by both methods",
        f"marched profiles are within {errors:.0e} d0 of the profile by direct integration",
        errors < 1e-3,
    )
    seventy = float(states.time[4])
    yield claim(
        "3.3",
        "for 70 % of the displacement difference only 27 % of the time is needed",
        f"{seventy:.2%} of the time to {STATIONARY_FRACTION:.1%} of the difference",
        0.265 < seventy < 0.275,
        "the limit is not reached at any finite time; the printed 27 % implies that the paper's "
        "run ended at 98.25 % to 98.49 % of the difference, depending on rounding",
    )
    line, area = history.sel(time=seventy, solver="mdr").values
    yield claim(
        "3.3, Fig. 5",
        "this behaviour (70 % of the change in 27 % of the time) is also observed in the gradient",
        f"in the 70 % state the gradient has reached {line:.1%} (line) or {area:.1%} (area) of "
        "its final value",
        min(line, area) > 0.7,
    )


def claims_on_wear_ratios(curves: xarray.Dataset) -> Iterator[Row]:
    """Yield rows of claims of section 4.2, Fig. 6."""
    gradient = curves.direct.sel(gradient_average="line")
    asymmetry = np.abs(gradient / gradient.values[::-1] - 1).max("ratio")
    yield claim(
        "4.2, Fig. 6",
        "for h2/h1 = 1 the plots are symmetrical for large numbers of rings",
        f"greatest difference between k2/k1 and k1/k2: {write_by_rings(asymmetry)}",
        bool((np.diff(asymmetry) < 0).all()),
        "symmetric only in the limit, sqrt(1 + (4/g0^2) ((k2 - k1)/(k2 + k1))^2)",
    )
    line, area = many_rings(1e16, np.ones(1))[:, 0]
    yield claim(
        "4.2, Fig. 6",
        "the limiting value for large numbers of rings is about 2.4",
        f"{line:.4f} (line), {area:.4f} (area) = sqrt(1 + 4/g0^2)",
        2.35 < line < 2.45,
        "16 rings at k2/k1 = 100 have about 2.4; the limit is approached from above for "
        "k2/k1 > 1 and from below for k2/k1 < 1",
    )
    outside, inside = gradient.sel(ratio=[0.01, 100.0], method="nearest").sel(rings=4).values
    yield claim(
        "4.2, Fig. 6",
        "N = 4: with the slower material outside the gradient is much smaller",
        f"{outside:.3f} (slower material outside), {inside:.3f} (inside)",
        inside > 1.34 * outside,
    )


def claims_on_width_ratios(curves: xarray.Dataset) -> Iterator[Row]:
    """Yield rows of claims of section 4.2, Fig. 7."""
    gradient = curves.direct.sel(gradient_average="line")
    thin, equal, wide = gradient.sel(ratio=[0.1, 1.0, 10.0], method="nearest")
    limits = many_rings(FIG7_WEAR_RATIO, np.array([10.0, 1e4]))[0]
    yield claim(
        "4.2, Fig. 7",
        "in all cases the gradient converges to one as h2/h1 increases",
        f"at h2/h1 = 10: {write_by_rings(wide)}",
        bool((wide < equal).all() and (equal < thin).all() and limits[1] < 1.001),
        f"not yet at 10 for many rings: their limit is {limits[0]:.3f} there, and {limits[1]:.5f} "
        "at 1e4",
    )
    line, area = curves.limit[:, 0].values
    yield claim(
        "4.2 and 5, Fig. 7",
        "with a small share of slower material (printed: increased) the gradient is much higher",
        f"at h2/h1 = 0.1: {write_by_rings(thin)}",
        bool((thin > 2).all()),
        f"print error; the limit of many rings is {line:.3f} (line), {area:.3f} (area)",
    )


def write_by_rings(values: xarray.DataArray) -> str:
    """Return a text with a value for each number of rings N."""
    pairs = zip(values.rings.values, values.values, strict=True)
    return ", ".join(f"{value:.3f} (N = {count})" for count, value in pairs)
