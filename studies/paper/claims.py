"""The paper's claims beside our values."""

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
import pandas as pd
import xarray

from .theory import STATIONARY, WEAR_RATIO_OF_WIDTHS, homogeneous, many_rings

VERDICTS = ("holds", "holds with a remark", "does not hold")


class Claim(NamedTuple):
    """A sentence of the paper with a number or a trend in it.

    Parameters
    ----------
    where, says : section and figure, and the sentence
    computed : what we compute for it
    holds : whether that is so
    remark : why it does not hold, or what has to be added
    """

    where: str
    says: str
    computed: str
    holds: bool
    remark: str = ""

    @property
    def verdict(self) -> str:
        """One of `VERDICTS`: `holds`, `holds with a remark` or `does not hold`."""
        return VERDICTS[bool(self.remark) if self.holds else 2]


def tabulate_claims(
    states: xarray.Dataset,
    history: xarray.DataArray,
    by_wear_ratio: xarray.Dataset,
    by_width_ratio: xarray.Dataset,
) -> pd.DataFrame:
    """Return the table of all claims, by the data of Figs. 4, 5, 6 and 7."""
    claims = [
        *claims_on_running_in(states, history),
        *claims_on_wear_ratios(by_wear_ratio),
        *claims_on_width_ratios(by_width_ratio),
    ]
    rows = [
        (claim.where, claim.says, claim.computed, claim.verdict, claim.remark) for claim in claims
    ]
    columns = ["where", "the paper says", "computed", "verdict", "why, or what to add"]
    return pd.DataFrame(rows, columns=columns)


def conclude(claims: pd.DataFrame) -> list[str]:
    """Return how many claims have which verdict, those that do not hold, and what symbols mean."""
    counts = claims.verdict.value_counts().reindex(VERDICTS, fill_value=0)
    refuted = claims[claims.verdict == VERDICTS[2]]
    line, area = homogeneous()
    return [
        "claims: " + ", ".join(f"{count} {verdict}" for verdict, count in counts.items()),
        *(VERDICTS[2] + ": " + refuted["the paper says"] + ": " + refuted["computed"]),
        f"`p0 = F/(2 pi a^2)`, `d0 = F/(2 a E*)`; `t_stat` is the time to {STATIONARY:.1%} of the "
        "displacement difference; `line` is an average over the radius, `area` over the area, and "
        "gradients are `line` where nothing is said. The homogeneous punch has the gradient "
        f"g0 = {line:.8f} (line), {area:.8f} = 4/pi (area), times p/E*.",
    ]


def claims_on_running_in(states: xarray.Dataset, history: xarray.DataArray) -> Iterator[Claim]:
    """Yield claims of section 3.3, Figs. 4 and 5."""
    profile, pressure = states.f_over_d0.values, states.p_over_p0.values
    lengths = np.linalg.norm(pressure, axis=2)
    apart = np.linalg.norm(pressure - pressure[0], axis=2) / lengths
    highest = np.abs(profile - profile[0]).max()
    yield Claim(
        "3.3, Fig. 4",
        "MDR and BEM match within a small tolerance",
        f"{', '.join(states.solver.values).upper()}: profiles within {highest:.1e} d0, pressures "
        f"after the start within {apart[:, 1:].max():.1e} (root mean square over the radius)",
        max(highest, apart[:, 1:].max()) < 0.01,
        "at t = 0 the pressure is infinite at the rim, where no pointwise comparison means "
        "anything",
    )
    slow, fast = pressure[0, -1].max(), pressure[0, -1].min()
    yield Claim(
        "3.3, Eq. 24",
        "in the end slow rings are under more than three times p0, fast rings under less than half",
        f"{slow:.4f} p0 and {fast:.4f} p0",
        slow > 3 and fast < 0.5,
    )
    errors = np.abs(profile[:, -1] - states.limiting_f_over_d0.values).max()
    yield Claim(
        "5",
        "the same limiting profile can be computed by both methods",
        f"marched profiles are within {errors:.0e} d0 of that by direct integration",
        errors < 1e-3,
    )
    seventy = float(states.time[4])
    yield Claim(
        "3.3",
        "for 70 % of the displacement difference only 27 % of the time is needed",
        f"{seventy:.2%} of the time to {STATIONARY:.1%} of the difference",
        0.265 < seventy < 0.275,
        "the limit is reached at no finite time; by the printed 27 % the paper's run ended there, "
        "at 98.25 % to 98.49 % by the rounding",
    )
    line, area = history.sel(time=seventy, solver="mdr").values
    yield Claim(
        "3.3, Fig. 5",
        "this behaviour (70 % of the change in 27 % of the time) is also observed in the gradient",
        f"in the 70 % state the gradient has reached {line:.1%} (line) or {area:.1%} (area) of "
        "its end",
        min(line, area) > 0.7,
    )


def claims_on_wear_ratios(curves: xarray.Dataset) -> Iterator[Claim]:
    """Yield claims of section 4.2, Fig. 6."""
    gradient = curves.direct.sel(gradient_average="line")
    skew = np.abs(gradient / gradient.values[::-1] - 1).max("ratio")
    yield Claim(
        "4.2, Fig. 6",
        "for h2/h1 = 1 the plots are symmetrical for large numbers of rings",
        f"greatest difference between k2/k1 and k1/k2: {write_by_rings(skew)}",
        bool((np.diff(skew) < 0).all()),
        "symmetric in the limit only, sqrt(1 + (4/g0^2) ((k2 - k1)/(k2 + k1))^2)",
    )
    line, area = many_rings(1e16, np.ones(1))[:, 0]
    yield Claim(
        "4.2, Fig. 6",
        "the limiting value for large numbers of rings is about 2.4",
        f"{line:.4f} (line), {area:.4f} (area) = sqrt(1 + 4/g0^2)",
        2.35 < line < 2.45,
        "about 2.4 is what 16 rings give at k2/k1 = 100; the limit is approached from above at "
        "k2/k1 > 1 and from below at k2/k1 < 1",
    )
    outside, inside = gradient.sel(ratio=[0.01, 100.0], method="nearest").sel(rings=4).values
    yield Claim(
        "4.2, Fig. 6",
        "N = 4: with the slower material outside the gradient is much smaller",
        f"{outside:.3f} against {inside:.3f}",
        inside > 1.34 * outside,
    )


def claims_on_width_ratios(curves: xarray.Dataset) -> Iterator[Claim]:
    """Yield claims of section 4.2, Fig. 7."""
    gradient = curves.direct.sel(gradient_average="line")
    thin, equal, wide = gradient.sel(ratio=[0.1, 1.0, 10.0], method="nearest")
    limits = many_rings(WEAR_RATIO_OF_WIDTHS, np.array([10.0, 1e4]))[0]
    yield Claim(
        "4.2, Fig. 7",
        "in all cases the gradient converges to one as h2/h1 increases",
        f"at h2/h1 = 10: {write_by_rings(wide)}",
        bool((wide < equal).all() and (equal < thin).all() and limits[1] < 1.001),
        f"not yet at 10 for many rings, whose limit is {limits[0]:.3f} there, and {limits[1]:.5f} "
        "at 1e4",
    )
    line, area = curves.limit[:, 0].values
    yield Claim(
        "4.2 and 5, Fig. 7",
        "with a small share of slower material (printed: increased) the gradient is much higher",
        f"at h2/h1 = 0.1: {write_by_rings(thin)}",
        bool((thin > 2).all()),
        f"print error; the limit of many rings is {line:.3f} (line), {area:.3f} (area)",
    )


def write_by_rings(values: xarray.DataArray) -> str:
    """Write a value for each number of rings."""
    pairs = zip(values.rings.values, values.values, strict=True)
    return ", ".join(f"{value:.3f} (N = {count})" for count, value in pairs)
