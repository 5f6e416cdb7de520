"""Run a sweep: `ringwear sweep` and, in Python, `ringwear.sweep`."""

import argparse
import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import xarray

from ringwear.studies.crosscheck.scope import machine_memory
from ringwear.studies.problem.scene import Scene
from ringwear.studies.progress import LOG
from ringwear.studies.sweep.axes import Sweep
from ringwear.studies.sweep.blocks import block_shape
from ringwear.studies.sweep.conduct import Tally, conduct
from ringwear.studies.sweep.layout import layout
from ringwear.studies.sweep.plan import planned
from ringwear.studies.sweep.store import NAME, Store, alone, write_whole
from ringwear.studies.sweep.summary import summary


def sweep(
    base: Scene | str | Mapping[str, Any],
    axes: Mapping[str, Any] | None = None,
    keep: Sequence[str] | None = None,
    *,
    zip: Mapping[str, Any] | None = None,
    random: Mapping[str, Any] | None = None,
    out: str | Path | None = None,
    workers: int = 1,
    scheduler: str | None = None,
    resume: bool = False,
) -> xarray.Dataset:
    """Compute scenes over axes of scene keys.

    Parameters
    ----------
    base : the scene that all others are changed from: a Scene, a bundled name, a file or nested dictionaries
    axes : values of scene keys such as ``"punch.rings"``, each crossed with every other: a list, ``{"linspace": [...]}`` or
        ``{"geomspace": [first, last, count]}``
    keep : names of quantities; by default all that need neither radius nor ring
    zip : keys whose values go together
    random : ``count``, ``seed``, and what to draw each key from
    out : directory to keep the store in, readable while it grows; by default results stay in memory
    workers, scheduler : processes on this machine (in a script, call from under ``if __name__ == "__main__"`` if more than
        one), or the address of a Dask scheduler
    resume : go on with what is in `out`

    Returns
    -------
    Dataset whose dimensions are the axes, then solver, time and so on, in the scenes' own units: the quantities kept, the
    relative error that each method states of them (``<quantity>_error``), and `status` (1 done, 2 failed) and `reason` of
    each scene.

    Raises
    ------
    SceneError
        if the axes or the base are not understood; single scenes that fail raise nothing
    """
    table: dict[str, Any] = {"base": base.table() if isinstance(base, Scene) else base}
    given = {"axes": axes, "zip": zip, "random": random, "keep": None if keep is None else list(keep)}
    made = Sweep.of(table | {name: value for name, value in given.items() if value is not None})
    if out is None:
        store = _store(made, None, resume)
        conduct(store, workers, scheduler)
        return store.dataset().load()
    with alone(Path(out)):
        store = _store(made, Path(out), resume)
        conduct(store, workers, scheduler)
        return store.dataset()


def _store(made: Sweep, directory: Path | None, resume: bool) -> Store:
    kept = layout(made)
    return Store(made, kept, block_shape(made, kept), directory, resume)


def swept(source: str, out: Path, options: argparse.Namespace) -> tuple[list[str], bool]:
    """The command: what it found, a line each, and whether all scenes are finished."""
    from ringwear.studies.sweep.figure import drawn

    made = Sweep.load(source)
    plan = planned(made, options.memory or machine_memory(), options.workers).said(options.workers)
    if options.dry_run:
        return plan, True
    for line in plan:
        LOG.info("   sweep  %s", line)
    with alone(out):
        store = _store(made, out, options.resume)
        tally = conduct(store, options.workers, options.scheduler)
        dataset = store.dataset()
        found = summary(dataset, made)
        write_whole(out / "summary.json", (json.dumps(found, indent=1) + "\n").encode())
        write_whole(out / "sweep.png", drawn(dataset, made))
    return [*_said(tally, found), f"{NAME}, sweep.png and summary.json in {out}"], not tally.left


def _said(tally: Tally, found: dict[str, Any]) -> list[str]:
    lines = [f"{tally.finished} scenes finished, {tally.failed} failed, {tally.left} left"]
    lines += [f"failed: {reason} ({count} scenes)" for reason, count in found["reasons"].items()]
    return [*lines, *found["conclusions"]]
