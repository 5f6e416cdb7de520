"""The table that compares all pairs of spaces, and its conclusions in sentences."""

from collections.abc import Iterator

import numpy as np
import pandas as pd

STABLE, UNSTABLE, SINGULAR = "yes", "no", "singular"
"""Values of the column `stable` of the table."""
UNSTABLE_ORDER = 1.0
"""A pair is unstable if its least eigenvalue falls with this order of the element size or faster.

In theory the order is 0 for stable pairs and 2 for pairs with checkerboards.
"""
LOCKING_GROWTH = 3.0
"""A displacement locks if the error of d0 grows by more than this factor towards nu = 1/2."""
QUANTITIES_WITH_ORDERS = ("least eigenvalue", "p at the start", "p(t)")
"""Columns of the table whose observed orders are in it, too."""


def choose(table: pd.DataFrame, orders: pd.DataFrame, several_rings: bool) -> pd.DataFrame:
    """Return one row per pair: whether it is stable, and its errors on the finest mesh.

    Parameters
    ----------
    table : one row per level; levels of the families near incompressibility are ignored
    orders : observed order of each quantity in each family
    several_rings : whether rings differ in wear, so that worn pressures jump at ring edges
    """
    rows = table[~table.family.str.startswith("locking") & table["least eigenvalue"].notna()]
    observed = orders.pivot_table(index="refined", columns="quantity", values="least squares")
    pairs = []
    for family, levels in rows.groupby("family", sort=False):
        finest = levels.iloc[-1]
        order = observed.reindex([family], columns=list(QUANTITIES_WITH_ORDERS)).iloc[0]
        stable = STABLE if order["least eigenvalue"] < UNSTABLE_ORDER else UNSTABLE
        if pd.isna(finest["d0"]):
            stable = SINGULAR
        pairs.append(
            {
                "displacement": finest["displacement"],
                "degree": finest["degree"],
                "pressure": finest["pressure"],
                "pressure degree": finest["pressure degree"],
                "stable": stable,
                "suits": suitable_use(stable, finest["pressure"], several_rings),
                "least eigenvalue": finest["least eigenvalue"],
                "order of eigenvalue": order["least eigenvalue"],
                "d0": abs(finest["d0"]),
                "p at the start": finest["p at the start"],
                "order of p at the start": order["p at the start"],
                "d(t)": finest["d(t)"],
                "p(t)": finest["p(t)"],
                "order of p(t)": order["p(t)"],
                "condition number": finest["condition number"],
            }
        )
    return pd.DataFrame(pairs)


def suitable_use(stable: str, kind: str, several_rings: bool) -> str:
    """Return the computations that a pair may be used for, in words."""
    if stable == SINGULAR:
        return "nothing: it is refused"
    if stable == UNSTABLE:
        return "d0 and wear, but no pressure before wear"
    if kind == "continuous" and several_rings:
        return "the start, and punches of one material"
    return "the start and wear"


def conclude(choice: pd.DataFrame, table: pd.DataFrame) -> Iterator[str]:
    """Yield the conclusions: stability, continuity at ring edges, condition numbers, locking.

    Parameters
    ----------
    choice : table of `choose`
    table : one row per level, with the families near incompressibility
    """
    if not len(choice):
        return
    pairs = dict(tuple(choice.groupby("stable")))
    if STABLE in pairs:
        eigenvalues = pairs[STABLE]["least eigenvalue"]
        yield (
            f"{len(eigenvalues)} of {len(choice)} pairs are stable: their least eigenvalues on the "
            f"finest mesh lie between {eigenvalues.min():.2g} and {eigenvalues.max():.2g}, and d0 "
            f"errs by at most {pairs[STABLE]['d0'].max():.1e}."
        )
    if UNSTABLE in pairs:
        unstable = pairs[UNSTABLE]
        yield (
            f"{len(unstable)} pairs have checkerboards ({_names(unstable)}): their least "
            f"eigenvalues fall with order {_span(unstable['order of eigenvalue'], '.2f')}. The "
            "pressure of the flat start is wrong by "
            f"{_span(unstable['p at the start'], '.2g')} times its norm. The indentation d0 "
            f"(errors up to {unstable['d0'].max():.1e}) and the worn pressure p(t) (up to "
            f"{unstable['p(t)'].max():.1e}) do not show it."
        )
    if SINGULAR in pairs:
        yield (
            f"{len(pairs[SINGULAR])} pairs are singular ({_names(pairs[SINGULAR])}): condensing "
            "them raises an error."
        )
    yield from _conclude_ring_edges(choice)
    yield from _conclude_condition_numbers(pairs)
    yield from _conclude_locking(table)


def _conclude_ring_edges(choice: pd.DataFrame) -> Iterator[str]:
    """Yield how large the error of a worn pressure is if it is continuous over ring edges."""
    continuous = choice[choice["suits"].str.contains("one material")]
    broken = choice[choice["suits"] == "the start and wear"]
    if len(continuous) and len(broken):
        yield (
            "Pressures that are continuous over ring edges are stable, but wear makes the pressure "
            f"jump there: p(t) errs by {_span(continuous['p(t)'], '.1e')} and converges with order "
            f"{_span(continuous['order of p(t)'], '.2f')}; pressures that may jump there err by "
            f"{_span(broken['p(t)'], '.1e')}."
        )


def _conclude_condition_numbers(pairs: dict[str, pd.DataFrame]) -> Iterator[str]:
    """Yield the condition numbers of stable and unstable pairs."""
    if {STABLE, UNSTABLE} <= pairs.keys():
        stable, unstable = (pairs[kind]["condition number"] for kind in (STABLE, UNSTABLE))
        yield (
            f"The condition number of the compliance is at most {stable.max():.0e} for stable "
            f"pairs, and at least {unstable.min():.0e} for pairs with checkerboards."
        )


def _conclude_locking(table: pd.DataFrame) -> Iterator[str]:
    """Yield which displacements lock as Poisson's ratio tends to 1/2."""
    rows = table[table.family.str.startswith("locking") & table["d0"].notna()]
    names_by_locking = {True: list[str](), False: list[str]()}
    highest_ratio = 0.5
    for name, levels in rows.groupby("displacement", sort=False):
        errors = levels["d0"].abs().to_numpy(float)
        highest_ratio = float(levels["poisson ratio"].iloc[-1])
        names_by_locking[bool(errors[-1] > LOCKING_GROWTH * errors[0])].append(
            f"{name} ({errors[0]:.1e} to {errors[-1]:.1e})"
        )
    for locks, names in names_by_locking.items():
        if names:
            growth = "more than threefold (locking)" if locks else "at most threefold"
            yield (
                f"From nu = 0.3 to {highest_ratio:g} the error of d0 grows {growth}: "
                f"{', '.join(names)}."
            )


def _names(pairs: pd.DataFrame) -> str:
    """Return pairs as a list: each displacement with its pressures, their kind and degree."""
    return "; ".join(
        f"{displacement} with pressures "
        + ", ".join(f"{kind} of degree {degree}" for kind, degree in zip(*columns, strict=True))
        for displacement, columns in (
            (name, (group["pressure"], group["pressure degree"]))
            for name, group in pairs.groupby("displacement", sort=False)
        )
    )


def _span(values: pd.Series, form: str) -> str:
    """Return the least and the greatest value as a text, or one value if both have one text."""
    low, high = (f"{value:{form}}" for value in (np.nanmin(values), np.nanmax(values)))
    return low if low == high else f"{low} to {high}"
