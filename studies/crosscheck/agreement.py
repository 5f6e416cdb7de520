"""How far two methods agree: every quantity that both give, against the sum of what each says of its own error."""

from dataclasses import dataclass

import numpy as np
import xarray

from ringwear.studies.methods.quantities import QUANTITIES, array, common, error_name, relative_difference

COMPARED_MODES = 3


@dataclass(frozen=True)
class Agreement:
    """One quantity of two methods: their difference and combined uncertainty, where the one is greatest over the other."""

    quantity: str
    methods: tuple[str, str]
    difference: float
    uncertainty: float

    @property
    def agrees(self) -> bool:
        return self.difference <= self.uncertainty


def agreements(methods: tuple[str, str], one: xarray.Dataset, other: xarray.Dataset, rtol: float) -> list[Agreement]:
    """Compare the results of two methods in every quantity that both give.

    Of the indentation no method may claim an uncertainty above the accuracy asked for: a difference is not excused by
    a method that says of itself that it is wrong.
    """
    rows = []
    for name, quantity in QUANTITIES.items():
        if not (quantity.compared and name in one and name in other):
            continue
        shared = slice(COMPARED_MODES) if "mode" in quantity.dims else ...
        first, second = array(one, name)[shared], array(other, name)[shared]
        known = common(first.shape, second.shape)
        difference = relative_difference(name, first, second)
        own, others = (array(results, error_name(name))[shared][known] for results in (one, other))
        uncertainty = own + others
        if name == "indentation":
            uncertainty = np.minimum(uncertainty, 2 * rtol)
        worst = np.unravel_index(np.argmax(difference / uncertainty), difference.shape)
        rows.append(Agreement(name, methods, float(difference[worst]), float(uncertainty[worst])))
    return rows
