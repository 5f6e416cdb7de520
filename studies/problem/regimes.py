"""The regimes of a problem: how contact, load and wear are, and what differs between them.

Each regime is one frozen value that owns its data: words, quantities, limits. A problem has one
regime of each kind (`Problem.contact`, `Problem.load_regime`, `Problem.wear_regime`). Code reads
the data, or looks up a regime in a table, so that it need not test for the kind of problem. What a
method cannot solve is a table of its own, from regimes to reasons (`Method.refused`).
"""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

from .quantities import ENERGIES, OF_PROFILES

# what `Problem.march` can be
MARCHES = ("modal", "implicit", "explicit")
# the comparison of methods as operators, as the summary calls it where it is left out
OPERATORS = "methods as operators"


@dataclass(frozen=True, eq=False)
class ContactRegime:
    """Whether all of the face carries at all times, or contact opens, closes and spreads.

    Parameters
    ----------
    start : words for the state that a history begins with
    way : words for how the modal march goes through time
    modelled : sentences about what is modelled besides
    steady_state : words for the steady state, after "without any march"
    left_out : what is not computed, with the reason
    quantities_missing : names of the quantities that it does not have under one force
    numbers_due : names of the numbers of the answer that two methods have to be compared in
    marches : marches that are possible
    most_steps : greatest number of equal steps in time
    allowed_over_rtol : error that each method may state, over the accuracy asked for
    shared_keys : beginnings of keys in which scenes may differ and yet share a discretisation
    rings_of_probe : greatest number of rings of the probe that predicts seconds; None for all
    finest_rtol : smallest accuracy at which numbers of the challenge are certified
    cells_of_face : equal cells of the face that norms of fields see at least
    """

    start: str
    way: str
    modelled: tuple[str, ...]
    steady_state: str
    left_out: Mapping[str, str]
    quantities_missing: frozenset[str]
    numbers_due: frozenset[str]
    marches: tuple[str, ...]
    most_steps: int
    allowed_over_rtol: float
    shared_keys: tuple[str, ...]
    rings_of_probe: int | None
    finest_rtol: float
    cells_of_face: int


@dataclass(frozen=True, eq=False)
class LoadRegime:
    """Whether a force or an indentation is given, and whether the load varies.

    Parameters
    ----------
    given : quantity that the load gives, and of which no method makes an error
    response : quantity that the load does not give, and methods compute
    shows_running_in : quantity whose history shows the running-in
    spreads_until : words for when contact ends to spread, with `{end}` for that time; None if that
        is not known beforehand
    quantities_told : quantities that it adds in full contact: forces, if they are not one number
    parts_left : what part of the running-in is left at each of the times that the answer tells
    forces_told : forces that the answer tells, each with its place among the times
    decaying : quantities that decay as wear goes on
    second_order : quantities that converge in second order or faster in the cells of a face
    modelled : sentences about what is modelled besides
    left_out : what is not computed, with the reason
    marches : marches that are possible
    no_steady_state : why it has no steady state; empty if it may have one
    refused_without_times : why there is nothing to compute without times; empty if there is
    logarithmic_times : whether figures show times on a logarithmic scale. Where loads vary, late
        times have as much to show as early ones
    """

    given: str
    response: str
    shows_running_in: str
    spreads_until: str | None = " to {end}"
    quantities_told: frozenset[str] = frozenset()
    parts_left: Mapping[str, float] = field(default_factory=dict)
    forces_told: Mapping[str, int] = field(default_factory=dict)
    decaying: frozenset[str] = frozenset()
    second_order: frozenset[str] = frozenset({*ENERGIES, "ring_worn_volume"})
    modelled: tuple[str, ...] = ()
    left_out: Mapping[str, str] = field(default_factory=dict)
    marches: tuple[str, ...] = MARCHES
    no_steady_state: str = ""
    refused_without_times: str = ""
    logarithmic_times: bool = True

    @property
    def numbers_missing(self) -> frozenset[str]:
        """Times of running-in that the answer does not tell."""
        return TIMES_OF_RUNNING_IN - self.parts_left.keys()


@dataclass(frozen=True, eq=False)
class WearRegime:
    """Whether the wear coefficient is constant on rings or varies along the radius.

    Parameters
    ----------
    error_factors : names of the factors that error estimates of flat punches are multiplied by
        besides the usual one (`studies/methods/error_factors.py`)
    """

    error_factors: tuple[str, ...] = ()


Regime = ContactRegime | LoadRegime | WearRegime

TIMES_OF_RUNNING_IN = frozenset({"time_to_90", "time_to_99", "time_to_half_force"})

FULL_CONTACT = ContactRegime(
    start="the flat start",
    way="exactly in time, by its relaxation modes",
    modelled=(),
    steady_state="",
    left_out={
        "inequality p >= 0": "a punch that starts flat never loses contact: pressure can only rise "
        "where it is near zero",
    },
    # the edges of contact that never changes are those of the face
    quantities_missing=frozenset(OF_PROFILES),
    numbers_due=TIMES_OF_RUNNING_IN
    | {"running_in_time", "indentation_start", "force_share", "worn_volume"},
    marches=MARCHES,
    most_steps=2_000_000,  # each is a product of matrices
    allowed_over_rtol=1.0,
    shared_keys=(
        *("punch.wear", "punch.radius", "half_space.plane", "half_space.youngs"),
        *("load.", "wear.", "output.", "title"),
    ),
    rings_of_probe=16,
    finest_rtol=1e-8,
    cells_of_face=0,
)

MOVING_CONTACT = ContactRegime(
    start="the unworn face",
    way="in implicit steps of second order that suit rtol",
    modelled=(
        "inequality: pressure >= 0, gap >= 0, one of them zero; contact opens, closes and spreads",
    ),
    steady_state=", that of the flat punch: wear ends with all of the face in contact",
    left_out={
        "springs' rule of the MDR": "q = d - g holds only while contact is one disc; the energy of "
        "the MDR needs no disc",
        "relaxation modes": "they are those of a contact that does not change; running-in times "
        "are told once all of the face carries",
        "ring pressures at the start": "they may be infinite at edges of the contact, or on its "
        "axis",
        OPERATORS: "compared for flat punches only",
    },
    quantities_missing=frozenset({"relaxation_time"}),
    numbers_due=frozenset(),
    marches=("modal", "implicit"),
    most_steps=200_000,  # each is a contact problem
    # half of the uncertainty that two methods may have
    allowed_over_rtol=2.0,
    shared_keys=(),
    rings_of_probe=None,
    finest_rtol=1e-5,
    # pressures nearly jump at edges of the contact, which may be anywhere
    cells_of_face=250,
)

ONE_FORCE = LoadRegime(
    given="normal_force",
    response="indentation",
    shows_running_in="displacement_max",
    parts_left={"time_to_90": 0.1, "time_to_99": 0.01},
)

FIXED_INDENTATION = LoadRegime(
    given="indentation",
    response="normal_force",
    shows_running_in="normal_force",
    spreads_until=" on",
    quantities_told=frozenset({"normal_force", "ring_worn_volume"}),
    parts_left={"time_to_half_force": 0.5},
    forces_told={"force_start": 0, "force_end": -1},
    decaying=frozenset({"normal_force", "ring_force"}),
    no_steady_state="at a fixed indentation wear goes on until nothing presses any more",
    refused_without_times="load.indentation has no steady state but that nothing presses any more: "
    "give wear.times",
)


def _while_the_load_varies(regime: LoadRegime) -> LoadRegime:
    """Return a regime of the load whose force or sliding speed varies."""
    return replace(
        regime,
        spreads_until=None,
        quantities_told=regime.quantities_told | {"normal_force"},
        parts_left={},
        second_order=frozenset(),
        modelled=(
            "load over time: linear between the times given, and wear goes by the sliding "
            "distance; the steady state is that of the force and speed held last, relaxation times "
            "are those of the greatest speed",
        ),
        left_out={
            "times to 90 % and 99 % of running-in": "the load varies, and they are of one",
        },
        marches=("modal",),
        logarithmic_times=False,
    )


VARYING_FORCE = _while_the_load_varies(ONE_FORCE)
INDENTATION_AT_VARYING_SPEED = _while_the_load_varies(FIXED_INDENTATION)

VARYING_LOADS = VARYING_FORCE, INDENTATION_AT_VARYING_SPEED
FIXED_INDENTATIONS = FIXED_INDENTATION, INDENTATION_AT_VARYING_SPEED
# by whether the indentation is given, and whether the force or the sliding speed varies
LOADS = {
    (False, False): ONE_FORCE,
    (False, True): VARYING_FORCE,
    (True, False): FIXED_INDENTATION,
    (True, True): INDENTATION_AT_VARYING_SPEED,
}

WEAR_ON_RINGS = WearRegime()
WEAR_ALONG_RADIUS = WearRegime(error_factors=("wear along the radius",))
