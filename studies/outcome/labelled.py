"""Datasets of xarray that refuse a selection by `method`, which would select nothing.

``dataset.sel(method="mdr")`` is what one types first. There `method` is xarray's word for how to
take labels that are not there, and without labels it is ignored. The dimension is `solver`.
"""

from collections.abc import Hashable, Mapping
from typing import Any, Self

import xarray

from ...meshes.errors import SceneError


def refuse_method(solvers: list[str], method: object, labels: Mapping[Any, Any]) -> None:
    """Refuse a solver that is given as `method` or `methods`, and one that is not there.

    Raises
    ------
    SceneError
        saying what to write
    """
    if isinstance(method, str) and method in solvers:
        raise SceneError(
            f"sel(method={method!r}) selects nothing, as method is xarray's word for inexact "
            f"labels: write sel(solver={method!r})"
        )
    solver = labels.get("solver")
    if solvers and "methods" in labels:
        raise SceneError(f"no dimension 'methods': write sel(solver={labels['methods']!r})")
    if isinstance(solver, str) and solvers and solver not in solvers:
        raise SceneError(f"no solver {solver!r} in these results: give one of {', '.join(solvers)}")


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
    """A Dataset whose `sel` refuses a solver that is given as `method`, as that of its arrays."""

    __slots__ = ()

    def __getitem__(self, key: Hashable | Any) -> Any:
        """Return an array, or a dataset of several."""
        found = super().__getitem__(key)
        return DataArray(found) if isinstance(found, xarray.DataArray) else found

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
