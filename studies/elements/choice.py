"""The table to choose a pair of spaces from, and what it says in sentences."""

from collections.abc import Iterator

import numpy as np
import pandas as pd

STABLE, UNSTABLE, SINGULAR = "yes", "no", "singular"
"""Whether a pair is stable, in the table."""
FALLING = 1.0
"""Order of the least eigenvalue in the size from which a pair counts as unstable."""
LOCKS = 3.0
"""Times by which the error of d0 grows towards incompressibility if a displacement locks."""
ORDERS = ("least eigenvalue", "p at the start", "p(t)")
"""Quantities whose observed orders are in the table."""


def choose(table: pd.DataFrame, orders: pd.DataFrame, several_rings: bool) -> pd.DataFrame:
    """Return a row for each pair: whether it is stable, and its errors on the finest mesh.

    Parameters
    ----------
    table : of levels, those near incompressibility among them
    orders : observed, of each family
    several_rings : of different wear; pressures then jump at ring edges
    """
    rows = table[~table.family.str.startswith("locking") & table["least eigenvalue"].notna()]
    observed = orders.pivot_table(index="refined", columns="quantity", values="least squares")
    chosen = []
    for family, levels in rows.groupby("family", sort=False):
        finest = levels.iloc[-1]
        order = observed.reindex([family], columns=list(ORDERS)).iloc[0]
        stable = STABLE if order["least eigenvalue"] < FALLING else UNSTABLE
        if pd.isna(finest["d0"]):
            stable = SINGULAR
        chosen.append(
            {
                "displacement": finest["displacement"],
                "degree": finest["degree"],
                "pressure": finest["pressure"],
                "pressure degree": finest["pressure degree"],
                "stable": stable,
                "suits": suited(stable, finest["pressure"], several_rings),
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
    return pd.DataFrame(chosen)


def suited(stable: str, kind: str, several_rings: bool) -> str:
    """Return what a pair may be used for."""
    if stable == SINGULAR:
        return "nothing: it is refused"
    if stable == UNSTABLE:
        return "d0 and wear, but no pressure before wear"
    if kind == "continuous" and several_rings:
        return "the start, and punches of one material"
    return "the start and wear"


def conclude(choice: pd.DataFrame, table: pd.DataFrame) -> Iterator[str]:
    """Yield what the table says, a sentence each."""
    if not len(choice):
        return
    by = dict(tuple(choice.groupby("stable")))
    if STABLE in by:
        least = by[STABLE]["least eigenvalue"]
        yield (
            f"{len(least)} of {len(choice)} pairs are stable: their least eigenvalues on the "
            f"finest mesh lie between {least.min():.2g} and {least.max():.2g}, and d0 errs by at "
            f"most {by[STABLE]['d0'].max():.1e}."
        )
    if UNSTABLE in by:
        wrong = by[UNSTABLE]
        yield (
            f"{len(wrong)} pairs have checkerboards ({_names(wrong)}): their least eigenvalues "
            f"fall with order {_span(wrong['order of eigenvalue'], '.2f')}. The pressure of the "
            f"flat start is wrong by {_span(wrong['p at the start'], '.2g')} times its norm. The "
            f"indentation d0 (errors up to {wrong['d0'].max():.1e}) and the worn pressure p(t) (up "
            f"to {wrong['p(t)'].max():.1e}) do not show it."
        )
    if SINGULAR in by:
        yield (
            f"{len(by[SINGULAR])} pairs are singular ({_names(by[SINGULAR])}): condensing them "
            "raises an error."
        )
    yield from _of_ring_edges(choice)
    yield from _of_condition(by)
    yield from _of_locking(table)


def _of_ring_edges(choice: pd.DataFrame) -> Iterator[str]:
    """Yield what continuity over ring edges costs a worn pressure."""
    failing = choice[choice["suits"].str.contains("one material")]
    broken = choice[choice["suits"] == "the start and wear"]
    if len(failing) and len(broken):
        yield (
            "Pressures that are continuous over ring edges are stable, but wear makes the pressure "
            f"jump there: p(t) errs by {_span(failing['p(t)'], '.1e')} and converges with order "
            f"{_span(failing['order of p(t)'], '.2f')}; those that may jump err by "
            f"{_span(broken['p(t)'], '.1e')}."
        )


def _of_condition(by: dict[str, pd.DataFrame]) -> Iterator[str]:
    """Yield the condition numbers of stable and unstable pairs."""
    if {STABLE, UNSTABLE} <= by.keys():
        stable, unstable = (by[kind]["condition number"] for kind in (STABLE, UNSTABLE))
        yield (
            f"The condition number of the compliance is at most {stable.max():.0e} for stable "
            f"pairs, at least {unstable.min():.0e} for those with checkerboards."
        )


def _of_locking(table: pd.DataFrame) -> Iterator[str]:
    """Yield which displacements lock as Poisson's ratio tends to 1/2."""
    rows = table[table.family.str.startswith("locking") & table["d0"].notna()]
    told = {True: list[str](), False: list[str]()}
    last = 0.5
    for name, levels in rows.groupby("displacement", sort=False):
        errors = levels["d0"].abs().to_numpy(float)
        last = float(levels["poisson ratio"].iloc[-1])
        told[bool(errors[-1] > LOCKS * errors[0])].append(
            f"{name} ({errors[0]:.1e} to {errors[-1]:.1e})"
        )
    for locks, names in told.items():
        if names:
            verb = "grows, so that they lock" if locks else "does not grow threefold"
            yield f"From nu = 0.3 to {last:g} the error of d0 {verb}: {', '.join(names)}."


def _names(pairs: pd.DataFrame) -> str:
    """Return pairs as a list: the displacement, and the degree of the pressure with its kind."""
    return "; ".join(
        f"{displacement} with "
        + ", ".join(f"{kind} {degree}" for kind, degree in zip(*parts, strict=True))
        for displacement, parts in (
            (name, (group["pressure"], group["pressure degree"]))
            for name, group in pairs.groupby("displacement", sort=False)
        )
    )


def _span(values: pd.Series, form: str) -> str:
    """Return the least and the greatest of values, or the one if both look alike."""
    low, high = (f"{value:{form}}" for value in (np.nanmin(values), np.nanmax(values)))
    return low if low == high else f"{low} to {high}"
