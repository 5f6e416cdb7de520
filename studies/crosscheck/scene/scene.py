"""Define the scene: a frozen, validated value that is read from TOML or built from tables.

It provides the non-dimensional problem that the methods solve.
"""

from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from functools import cached_property
from itertools import pairwise
from math import isnan
from pathlib import Path
from typing import Annotated, Self, overload

import tomli_w
from pydantic import AfterValidator, Field, ValidationError, model_validator

from ....meshes.errors import SceneError
from ..problem.fields import Height, Section, TomlTable
from ..problem.problem import Problem
from ..problem.punch import PunchSection
from ..problem.quantities import GROUPS, expand
from ..problem.sections import (
    AccuracySection,
    HalfSpaceSection,
    LoadSection,
    OutputSection,
    WearSection,
)
from ..problem.suggestions import AnswersGuesses, did_you_mean
from ..problem.unit_names import UnitNames, without_quantities
from ..problem.written import check_one_line, shown
from ..registry import METHODS
from .explain import explain, key_meant, keys_of, place_of
from .keys import dotted, listed, with_key, without_alternatives
from .sources import tables_of, text_of, with_profile_of_file


def check_method(method: str) -> str:
    """Refuse the name of a method that is not registered."""
    if method not in METHODS:
        raise ValueError(f"no method '{method}'{did_you_mean(method, METHODS)}")
    return method


class LoadAttribute(classmethod):
    """The decorator of `Scene.load`: a class method, but the table `load` for an instance."""

    # mypy: the base class is generic and has the same result for classes and instances
    @overload  # type: ignore[override]
    def __get__(self, scene: None, kind: type) -> "Callable[[str | Path], Scene]": ...

    @overload
    def __get__(self, scene: "Scene", kind: type) -> LoadSection: ...

    def __get__(self, scene: "Scene | None", kind: type) -> object:
        """Return the class method `load`, or the table `load` of an instance."""
        return super().__get__(None, kind) if scene is None else scene.load_


class Scene(AnswersGuesses, Section):
    """A complete, validated scene.

    It is a frozen value. `load`, `from_toml` and `from_table` read it, its constructor takes
    tables, and `changed` returns a variant.

    The tables `punch`, `half_space` and `load` are required; `studies/reference.md` describes all
    keys. Numbers are in any consistent units, and any number may have its own unit, ``"20 mm"``.

    Raises
    ------
    SceneError
        if a key or value is wrong; the message has the key, the value and the remedy

    Examples
    --------
    >>> scene = Scene(
    ...     punch={"radius": "5 mm", "rings": 2, "wear_coefficients": [1e-14, "1e-4 mm^3/(N m)"]},
    ...     half_space={"youngs_modulus": "2 GPa"},
    ...     load={"normal_force": "100 N", "sliding_speed": 0.1},
    ... )
    >>> scene.units, scene.punch.radius, scene.half_space.youngs_modulus
    ('SI', 0.005, 2000000000.0)
    """

    title: Annotated[str, AfterValidator(check_one_line)] = ""
    units: Annotated[str, AfterValidator(check_one_line)] = Field(
        default="",
        description="'SI', or consistent units of length, force, pressure and time, such as "
        "'mm, N, MPa, s'",
    )
    methods: list[Annotated[str, AfterValidator(check_method)]] = Field(
        default=["mdr", "direct", "fem"],
        min_length=1,
        description=f"a list of {', '.join(METHODS)}",
    )
    punch: PunchSection
    half_space: HalfSpaceSection
    load_: LoadSection = Field(alias="load", description="a table")
    wear: WearSection = WearSection()
    accuracy: AccuracySection = AccuracySection()
    output: OutputSection = OutputSection()

    def __init__(self, /, *misplaced: object, **table: object) -> None:
        if misplaced:
            reader = "from_table" if isinstance(misplaced[0], Mapping) else "load"
            raise SceneError(
                f"Scene takes tables by their names, Scene(punch={{...}}, ...): write "
                f"Scene.{reader}({shown(misplaced[0])}) to read a complete scene"
            )
        stated = with_profile_of_file(without_quantities(table, type(self)))
        table, punch = stated, stated.get("punch")
        if isinstance(punch, Mapping) and "radius" not in punch:
            # imported only for a punch without a radius
            from .scar import with_scar_radius

            table = with_scar_radius(stated)
        try:
            super().__init__(**table)
        except ValidationError as error:
            raise SceneError(explain(error, Scene)) from None
        if self.wear.tau is not None:
            # convert multiples of the slowest relaxation time, which the scene determines, to times
            super().__init__(**table | {"wear": self._at_counts(self.wear.tau)})
        if self.wear.each_cycle:
            if not self.load_.period:
                raise SceneError(
                    "wear.times = 'each cycle' needs a cycle: give load.repeat, and a force or a "
                    "speed over time"
                )
            ends = {"times": self.load_.cycle_ends}
            super().__init__(**table | {"wear": self.wear.model_copy(update=ends)})
        if table != stated:
            # the radius of a scar is not a key of the scene: its table does not have it
            self.punch.model_fields_set.discard("radius")

    @model_validator(mode="after")
    def _fits_together(self) -> Self:
        if len(set(self.methods)) < len(self.methods):
            raise ValueError(f"methods = {self.methods} names a method twice")
        radii, punch = self.output.radii, self.punch
        if radii is not None and radii[-1] > punch.radius:
            raise ValueError(
                f"output.radii ends at {radii[-1]}, outside the punch of radius {punch.radius}"
            )
        if radii is not None and radii[0] < punch.inner_radius:
            raise ValueError(
                f"output.radii begins at {radii[0]}, within the hole of radius {punch.inner_radius}"
            )
        return self

    @LoadAttribute  # type: ignore[arg-type]
    def load(cls, source: str | Path) -> "Scene":
        """Read a scene from a file, or a bundled scene by its name."""
        if not isinstance(source, str | Path):
            raise SceneError(
                f"{shown(source)} is not a scene: give a Scene, the name of a bundled one such as "
                "'five_rings', a file, or nested dictionaries (Scene.from_table)"
            )
        return cls.from_toml(text_of(source), str(source), Path(source).parent)

    @classmethod
    def of(
        cls,
        source: "Source",
        methods: Sequence[str] | str | None = None,
        rtol: float | None = None,
        quantities: Sequence[str] | str | None = None,
    ) -> "Scene":
        """Return a scene from a Scene, a file, the name of a bundled scene, or dictionaries.

        Methods, accuracy and quantities replace those of the scene if they are given.
        """
        scene = source
        if not isinstance(scene, Scene):
            scene = cls.from_table(dict(scene)) if isinstance(scene, Mapping) else cls.load(scene)
        names = {"methods": methods, "output__quantities": quantities}
        changes: dict[str, object] = {
            key: listed(value) for key, value in names.items() if value is not None
        }
        if rtol is not None:
            changes["accuracy__rtol"] = rtol
            with suppress(TypeError, ValueError):  # the scene refuses values that are not numbers
                changes["accuracy__rtol"] = float(rtol)
        return scene.changed(**changes) if changes else scene

    @classmethod
    def from_toml(cls, text: str, name: str = "scene", folder: Path | None = None) -> "Scene":
        """Read a scene from TOML text.

        `name` appears in messages. The scene's paths of files are relative to `folder`.
        """
        if not isinstance(text, str) or (text.endswith(".toml") and "\n" not in text):
            raise SceneError(
                f"{shown(text)} is not the text of a scene: write Scene.load(file) to read a file"
            )
        table = tables_of(text, name)
        # no file is read without a folder, or if the profile has none
        with suppress(KeyError, TypeError):
            profile = table["punch"]["profile"]
            profile["file"] = str(folder / profile["file"])
        return cls.from_table(table, name)

    @classmethod
    def from_table(cls, table: TomlTable, name: str = "scene") -> "Scene":
        """Read a scene from nested dictionaries."""
        if not isinstance(table, Mapping):
            raise SceneError(
                f"{shown(table)} is not a table: give nested dictionaries, or write "
                "Scene.load(file) to read a file or a bundled scene"
            )
        try:
            return cls(**table)
        except SceneError as error:
            raise SceneError(f"{name}: {error}") from None

    def _at_counts(self, counts: list[float]) -> WearSection:
        """Return times at multiples of the slowest relaxation time, rounded to three digits.

        Raises
        ------
        SceneError
            if the relaxation time is not known
        """
        from ..wear.time_scale import running_in

        exact = (running_in(self.problem, counts) * self.problem.units.time).tolist()
        if self.problem.loading.varies or isnan(exact[-1]):
            raise SceneError(
                "wear.times can be chosen by running-in only for a constant load, a constant "
                "sliding speed and up to 64 rings: give times as numbers"
            )
        times = [float(f"{time:.3g}") for time in exact]
        if any(after <= before for before, after in pairwise(times)):
            times = exact
        return self.wear.model_copy(update={"times": times})

    def table(self) -> TomlTable:
        """Return the scene as nested dictionaries, as `from_table` takes them."""
        table = self.model_dump(by_alias=True, exclude_none=True, exclude_unset=True)
        if self.wear.tau is not None:
            table["wear"]["times"] = {"tau": self.wear.tau}
        elif self.wear.each_cycle:
            table["wear"]["times"] = "each cycle"
        return table

    def to_toml(self) -> str:
        """Return the scene as TOML."""
        return tomli_w.dumps(self.table())

    def changed(
        self, keys: Mapping[str, object] | None = None, /, *misplaced: object, **changes: object
    ) -> "Scene":
        """Return the scene with some keys changed.

        Alternatives to the changed keys are removed: a scene with a new `load.mean_pressure` has no
        `load.normal_force`.

        Parameters
        ----------
        keys : mapping, optional
            Values by names with dots: ``{"accuracy.rtol": 1e-6}``.
        **changes
            Values by names with double underscores: ``accuracy__rtol=1e-6``.

        Raises
        ------
        SceneError
            if a key or value is wrong; the message has the key and the remedy
        """
        if misplaced or not isinstance(keys or {}, Mapping):
            raise SceneError(f"changed({shown(keys)}): write changed({{'punch.rings': 3}})")
        values = {dotted(name): value for name, value in [*(keys or {}).items(), *changes.items()]}
        for key, value in values.items():
            if key.partition(".")[0] not in keys_of(Scene) and (
                suggestion := key_meant(key, Scene)
            ):
                raise SceneError(
                    f"a scene has no key {key!r}: write changed({{{suggestion!r}: {shown(value)}}})"
                )
        table = without_alternatives(self.table(), set(values))
        for key, value in values.items():
            table = with_key(table, key, value)
        return Scene.from_table(table).with_heights(*self.punch.heights, kinks=self.punch.kinks)

    def with_heights(self, *heights: Height, kinks: Sequence[float] | None = None) -> "Scene":
        """Return the scene with functions added to the unworn face.

        A file cannot contain functions, so `to_toml` omits them.

        Parameters
        ----------
        *heights : callables
            Functions from arrays of radii to heights, both in the scene's units.
        kinks : sequence of float, optional
            Radii at which the slope or the curvature of a function jumps, in the scene's units.
            Cells end there. By default kinks are searched for; an empty list means that there are
            none.

        Raises
        ------
        SceneError
            if a kink lies outside the punch
        """
        if not heights:
            return self
        table = self.table()
        table["punch"]["heights"] = list(heights)
        if kinks is not None:
            table["punch"]["kinks"] = [float(kink) for kink in kinks]
        return Scene(**table)

    @property
    def names_methods(self) -> bool:
        """Whether the scene names methods; else those of the default ones solve it that can."""
        return "methods" in self.model_fields_set

    @property
    def unit_names(self) -> UnitNames:
        """The units of the scene's numbers; those of times are lengths if it has no speed."""
        return UnitNames.of(self.units, self.load_.times_are_distances)

    def _nearest(self, name: str) -> str:
        """Return the key that an unknown attribute probably means; empty if none is similar."""
        return place_of(name, Scene, Scene)

    @cached_property
    def problem(self) -> Problem:
        """The non-dimensional problem that the methods solve."""
        problem = Problem.from_tables(
            self.punch, self.half_space, self.load_, self.wear, self.accuracy, self.output
        )
        if not problem.loading.rising:
            # imported only for a force that falls
            from ..wear.falling_force import with_prediction

            problem = with_prediction(problem)
        requested = expand(self.output.quantities)
        every = requested == GROUPS["all"] and not problem.as_wide_as_scar
        return problem if every else problem.with_quantities(requested)


Source = Scene | str | Path | Mapping[str, object]
