"""Speed against accuracy: seconds, true error and stated error of every method at every tolerance.

Each group of quantities is a case: it is computed by itself, because energies alone need fewer
unknowns than fields. The error of a level is that of its worst quantity, over all times, also those
at which the accuracy is not promised.

The price of a digit is the factor by which one more correct digit multiplies the seconds. It is
fitted by least squares: ``log10 seconds = a + b digits``, with digits = -log10 of the true error,
gives the price ``10^b``, and the interval of b gives the interval of the price.
"""

import os
import platform
from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np
import pandas as pd

from ..meshes import Array, SceneError
from .crosscheck import GROUPS, METHODS as KNOWN, Method, Scene, Source, method
from .study.accept import accept
from .study.draw import draw, titled, worst
from .study.extrapolation import CONFIDENCE, slope
from .study.functions import Named
from .study.measure import measure
from .study.own import Methods, Quantities, read_methods, read_quantities
from .study.record import Record
from .study.reference import Reference, reference
from .study.study import Study, remarks
from .study.way import Case, Way
from .study.ways import runs

CASES = {
    "d(t), F, relaxation times": frozenset({"indentation", "normal_force", "relaxation_time"}),
    "whole history": GROUPS["history"],
    "p, f, u along the radius": GROUPS["fields"],
    "steady state": GROUPS["steady"],
}
"""Groups of quantities; each group is computed by itself."""
TOLERANCES = {
    (True, False): tuple(10.0**-digits for digits in range(1, 9)),
    (True, True): tuple(10.0**-digits for digits in range(1, 4)),
    # a run at 1e-1 is refined to a tenth of that at most
    (False, False): (1e-1, 1e-2, 3e-3, 1e-3),
    (False, True): (1e-1, 1e-2),
}
"""Tolerances of the levels, by whether the punch is in full contact, and whether it is quick."""
REFERENCE, REFERENCE_QUICK = 1e-9, 1e-6
"""Tolerance of the reference in full contact."""
METHODS = ("mdr", "bem", "fem", "direct", "mdr implicit", "mdr explicit", "mdr-grid", "naive")
"""Methods and marches, by their names in the option `methods`."""
BY_TOLERANCE = ("mdr", "bem", "fem")
"""Methods whose sizes follow the tolerance."""
DEFAULT_TIMES = (0.0, 0.01, 0.1, 1.0)
"""Times of scenes without any, in a / (E* k_max v0)."""
RUNS = 3
"""Least number of times that each level is solved; its seconds are the median."""
LEAST_LEVELS, LEAST_DIGITS = 3, 0.5
"""Least number of levels with different errors for the price of a digit, and their least range."""
GREATEST_REPORTED_END = 1000
"""Greatest end of an interval that is printed as a number: seconds are not related to errors."""


def tradeoff(
    scene: Source = "five_rings",
    *,
    methods: Methods = None,
    quantities: Quantities = None,
    quick: bool = False,
    record: Record | None = None,
) -> Study:
    """Measure every method at every tolerance: seconds, true error and its own error estimate.

    Parameters
    ----------
    scene : a scene, a file, the name of a bundled scene, or nested dictionaries
    methods : names of methods to measure, and methods of your own
    quantities : names as in results.nc, and functions of a result; they replace the groups
    quick : whether to use fewer levels, and a reference that is less accurate
    record : rows so far, and the file that they are written to

    Raises
    ------
    SceneError
        if the scene or an option does not fit the study
    RingwearError
        if the reference cannot be computed
    """
    scene = accept("tradeoff", scene, any_punch=True, radial_wear=True, layered=True)
    all_names = tuple(sorted(frozenset.union(*CASES.values())))
    names, functions = read_quantities(quantities, all_names)
    known = BY_TOLERANCE if functions else METHODS
    named, own = read_methods(methods, known, "tradeoff")
    record = record or Record()
    if not scene.problem.earliest:
        times = [time * scene.problem.units.time for time in DEFAULT_TIMES]
        scene = scene.changed({"wear.times": times})
    for name in named if methods else ():
        if name in KNOWN and (reason := method(name).refusal(scene.problem)):
            raise SceneError(reason)
    chosen = frozenset(names) if names and not functions else None
    cases = [Case.of(scene, "your quantities", chosen)] if quantities else list(groups_of(scene))
    wanted = names if quantities else all_names

    def ways(case: Case) -> list[Way]:
        return list(ways_of(case, named, own, functions, quick))

    def exact(case: Case) -> Reference:
        rtol = REFERENCE_QUICK if quick else REFERENCE
        return reference(case, wanted, functions, rtol, quick)

    table = measure(cases, ways, wanted, record, functions, exact, RUNS)
    levels = worst(table)
    prices, effectivities = list_prices(levels), list_effectivities(levels)
    promised = levels[levels["tolerance"].notna()]
    heading = titled(scene.title, "worst quantity of each group")
    note = "Seconds are medians of processor time of one thread; whiskers: least and greatest."
    figures = {}
    if len(levels):
        figures["tradeoff"] = draw(
            levels, "seconds", ("case",), title=heading, note=note, same_axes=True
        )
    if len(promised):
        figures["tolerance"] = draw(
            promised, "size", ("case",), estimates=True, title=heading, same_axes=True
        )
    tables = {"digit_price": prices, "effectivity": effectivities}
    sentences = (
        *conclude_effectivities(effectivities),
        *conclude_prices(prices),
        *list_omissions(named, scene, functions),
        f"Measured on {platform.platform()}, one thread of {os.cpu_count()}; seconds are medians "
        f"of at least {RUNS} runs.",
        *remarks(record, quick),
    )
    return Study(
        "tradeoff",
        scene,
        table,
        conclusions=sentences,
        figures=figures,
        tables={name: rows for name, rows in tables.items() if len(rows)},
    )


def groups_of(scene: Scene) -> Iterator[Case]:
    """Yield a case for each group of quantities that the scene has."""
    for name, quantities in CASES.items():
        try:
            case = Case.of(scene, name, quantities)
        except SceneError:  # the scene has none of these quantities
            continue
        # there is no steady state at a fixed indentation
        if not method("mdr").refusal(case.problem):
            yield replace(case, only=quantities)


def ways_of(
    case: Case, named: tuple[str, ...], own: tuple[Method, ...], functions: Named, quick: bool
) -> Iterator[Way]:
    """Yield the ways of some methods that can compute a case."""
    problem = case.problem
    rtols = TOLERANCES[problem.full_contact, quick]
    for name in BY_TOLERANCE:
        if name in named and not method(name).refusal(problem):
            yield runs.tolerances(method(name), rtols)
    for each in own:
        yield runs.tolerances(each, rtols)
    wanted = problem.quantities or frozenset()
    if functions or not wanted:
        return
    history_only = problem.full_contact and wanted <= GROUPS["history"] and len(problem.times) > 0
    if "direct" in named and wanted <= GROUPS["steady"] and not method("direct").refusal(problem):
        yield runs.closed_form()
    constant = history_only and not problem.loading.varies
    if "mdr implicit" in named and constant:
        yield runs.steps("implicit", (0.1, 0.01, 0.001), problem)
    if "mdr explicit" in named and constant:
        yield runs.explicit_steps((0.9, 0.3, 0.1))
    if "mdr-grid" in named and history_only and not method("mdr-grid").refusal(problem):
        yield runs.paper_grid((50, 100, 200) if quick else (50, 100, 200, 400))
    # they compute the pressure and the indentation; a given indentation has no error
    computed = {"pressure", problem.response} - {"normal_force"}
    flat = problem.full_contact and not problem.ground.layered and len(problem.times) > 0
    if "naive" in named and flat and wanted & computed:
        cells = (5, 10, 20) if quick else (5, 10, 20, 40)
        yield runs.naive_elements([runs.NaiveSizes(count) for count in cells])


@dataclass(frozen=True)
class DigitPrice:
    """The factor by which one more correct digit multiplies the seconds.

    Parameters
    ----------
    levels : number of levels with different errors
    digits : range of the errors: log10 of the greatest over the least
    price : by least squares; NaN for fewer than `LEAST_LEVELS` levels
    lower, upper : ends of its `CONFIDENCE` interval; NaN for fewer than `LEAST_LEVELS` levels
    """

    levels: int
    digits: float = 0.0
    price: float = np.nan
    lower: float = np.nan
    upper: float = np.nan

    @property
    def why_not(self) -> str:
        """Reason why the price cannot be determined; empty if it can."""
        if self.levels < LEAST_LEVELS:
            return f"fewer than {LEAST_LEVELS} levels with different errors"
        if self.lower <= 1 <= self.upper:
            ends = f"from {self.lower:.2g} to {self.upper:.2g}"
            if self.upper > GREATEST_REPORTED_END:
                ends = f"to values above {GREATEST_REPORTED_END:g}"
            return f"its interval {ends} contains 1"
        if self.upper < 1:
            return "errors do not fall as seconds grow"
        if self.digits < LEAST_DIGITS:
            return f"all errors lie within {self.digits:.2g} digits"
        return ""


def fit_digit_price(seconds: Array, errors: Array) -> DigitPrice:
    """Return the price of a digit, fitted to the seconds and the true errors of several levels.

    Parameters
    ----------
    seconds, errors : (n,) of the levels; errors that are zero or not finite are left out
    """
    usable = (errors > 0) & np.isfinite(errors)
    # two tolerances with the same discretisation have the same error: they count as one level
    _, first = np.unique(errors[usable], return_index=True)
    if len(first) < LEAST_LEVELS:
        return DigitPrice(len(first))
    digits = -np.log10(errors[usable][first])
    # if the digits hardly differ, the slope may be so large that its power overflows
    with np.errstate(over="ignore"):
        ends = np.power(10.0, slope(digits, np.log10(seconds[usable][first])))
    return DigitPrice(len(first), float(np.ptp(digits)), *map(float, ends))


def list_prices(levels: pd.DataFrame) -> pd.DataFrame:
    """Return the price of a digit for each group of quantities and each way, or why it has none."""
    rows = []
    for (case, way), group in levels.groupby(["case", "way"], sort=False):
        price = fit_digit_price(*group[["seconds", "error"]].to_numpy(float).T)
        rows.append(
            {
                "case": case,
                "way": way,
                "levels": price.levels,
                "digits": price.digits,
                "price of a digit": price.price,
                "lower end": price.lower,
                "upper end": price.upper,
                "confidence": CONFIDENCE,
                "why not": price.why_not,
            }
        )
    return pd.DataFrame(rows)


def list_effectivities(levels: pd.DataFrame) -> pd.DataFrame:
    """Return how far estimates are from true errors, and how often a tolerance is missed.

    The effectivity is the greatest error estimate of a level over its greatest true error. Levels
    whose error is below that of the reference are left out.
    """
    promised = levels.dropna(subset=["tolerance", "estimate"])
    promised = promised[promised["error"] > promised["reference"]]
    rows = []
    for (case, way), group in promised.groupby(["case", "way"], sort=False):
        effectivity = group["estimate"] / group["error"]
        missed = group["error"] > group["tolerance"]
        rows.append(
            {
                "case": case,
                "way": way,
                "levels": len(group),
                "median effectivity": effectivity.median(),
                "least effectivity": effectivity.min(),
                "greatest effectivity": effectivity.max(),
                "levels beyond the tolerance": int(missed.sum()),
                "of these, stated": int((missed & (group["estimate"] > group["tolerance"])).sum()),
            }
        )
    return pd.DataFrame(rows)


def conclude_prices(prices: pd.DataFrame) -> Iterator[str]:
    """Yield a line for each way: the price of a digit in each group of quantities."""
    for way, rows in prices.groupby("way", sort=False) if len(prices) else ():
        parts = [
            f"{row['case']}: cannot be told, {row['why not']}"
            if row["why not"]
            else f"{row['case']}: {row['price of a digit']:.3g} (interval {row['lower end']:.3g} "
            f"to {row['upper end']:.3g})"
            for row in rows.to_dict("records")
        ]
        yield f"{way}: one more digit multiplies the seconds by: {'; '.join(parts)}."


def conclude_effectivities(effectivities: pd.DataFrame) -> Iterator[str]:
    """Yield the median effectivities, and how often the true error is above the tolerance."""
    if not len(effectivities):
        return
    missed, stated, levels = (
        int(effectivities[name].sum())
        for name in ("levels beyond the tolerance", "of these, stated", "levels")
    )
    yield (
        f"The true error is above the tolerance in {missed} of {levels} levels; in {stated} of "
        "these levels the error estimate is above it, too."
    )
    for case, rows in effectivities.groupby("case", sort=False):
        medians = ", ".join(
            f"{row['median effectivity']:.3g} ({row['way']})" for row in rows.to_dict("records")
        )
        yield f"{case}: the median ratio of error estimate to true error is {medians}."


def list_omissions(named: tuple[str, ...], scene: Scene, functions: Named) -> Iterator[str]:
    """Yield the methods that are left out for a scene, with the reason."""
    if "naive" in named and not functions and not scene.problem.full_contact:
        yield (
            "Left out for a shaped punch: the naive finite elements, because their nodes stick to "
            "the whole face, and Euler's marches and the paper's grid, because they assume full "
            "contact."
        )
