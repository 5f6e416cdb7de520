"""xarray datasets that refuse the frequent mistake ``dataset.sel(method="mdr")``.

The dimension is `solver`. In xarray, `method` means how to select inexact labels; without labels
xarray ignores it, so that the mistake would silently select everything.
"""

from collections.abc import Hashable, Mapping
from typing import Any, Self

import xarray

from ....meshes.errors import SceneError
from ..problem.written import shown


def refuse_method(solvers: list[str], method: object, labels: Mapping[Any, Any]) -> None:
    """Refuse a solver that is given as `method` or `methods`, and an unknown solver.

    Raises
    ------
    SceneError
        with the correct call
    """
    if isinstance(method, str) and method in solvers:
        raise SceneError(
            f"sel(method={shown(method)}) selects nothing, as method is xarray's word for inexact "
            f"labels: write sel(solver={shown(method)})"
        )
    solver = labels.get("solver")
    if solvers and "methods" in labels:
        raise SceneError(f"no dimension 'methods': write sel(solver={shown(labels['methods'])})")
    if isinstance(solver, str) and solvers and solver not in solvers:
        raise SceneError(
            f"no solver {shown(solver)} in these results: give one of {', '.join(solvers)}"
        )


def _solvers(data: xarray.Dataset | xarray.DataArray) -> list[str]:
    return data.coords["solver"].values.ravel().tolist() if "solver" in data.coords else []


class DataArray(xarray.DataArray):  # type: ignore[no-untyped-call]
    """A DataArray whose `sel` refuses a solver that is given as `method`."""

    __slots__ = ()

    def sel(
        self,
        indexers: Mapping[Any, Any] | None = None,
        method: str | None = None,
        tolerance: Any = None,
        drop: bool = False,
        **labels: Any,
    ) -> Self:
        """Select by labels, as xarray does."""
        refuse_method(_solvers(self), method, {**(indexers or {}), **labels})
        return super().sel(indexers, method, tolerance, drop, **labels)


class Dataset(xarray.Dataset):  # type: ignore[no-untyped-call]
    """A Dataset whose `sel`, like that of its arrays, refuses a solver given as `method`."""

    __slots__ = ()

    def __getitem__(self, key: Hashable | Any) -> Any:
        """Return one array, or a dataset of several arrays."""
        item = super().__getitem__(key)
        return DataArray(item) if isinstance(item, xarray.DataArray) else item

    def sel(
        self,
        indexers: Mapping[Any, Any] | None = None,
        method: str | None = None,
        tolerance: Any = None,
        drop: bool = False,
        **labels: Any,
    ) -> Self:
        """Select by labels, as xarray does."""
        refuse_method(_solvers(self), method, {**(indexers or {}), **labels})
        return super().sel(indexers, method, tolerance, drop, **labels)
