"""Define the regimes of contact and load of a problem, and the data that differ with them.

Each regime is a frozen value with its texts, quantities and limits. A problem has one regime of
each kind (`Problem.contact`, `Problem.load_regime`). Other code reads these data, or looks up a
regime in a table, instead of testing for the kind of problem. What a method cannot solve is a table
from regimes to reasons (`Method.refused`).
"""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import NamedTuple

from .quantities import ENERGIES, MOVING_CONTACT_QUANTITIES

# possible values of `Problem.march`
MARCHES = ("modal", "implicit", "explicit")
# name of the comparison of methods as operators in the list of what is left out
OPERATORS = "methods as operators"


@dataclass(frozen=True, eq=False)
class ContactRegime:
    """The regime of contact: all of the face is in contact at all times, or contact may change.

    Parameters
    ----------
    start : str
        Description of the first state of a history.
    march_description : str
        Description of how the modal march proceeds in time.
    modelled : tuple of str
        Sentences about additional features of the model.
    steady_state : str
        Text about the steady state that follows "without any march".
    left_out : mapping of str to str
        What is not computed, with the reasons.
    quantities_missing : frozenset of str
        Quantities that do not exist in this regime under a constant force.
    compared_numbers : frozenset of str
        Numbers of the answer that a comparison of two methods must contain.
    marches : tuple of str
        Possible marches.
    most_steps : int
        Greatest number of steps in time.
    allowed_over_rtol : float
        Error that each method may state, relative to rtol.
    shared_keys : tuple of str
        Beginnings of keys in which scenes may differ and still share a discretisation.
    most_probe_rings : int or None
        Greatest number of rings in the small problem that predicts the computing time; None for no
        limit.
    finest_rtol : float
        Smallest rtol at which numbers of the challenge are certified.
    cells_of_face : int
        Least number of equal cells of the face on which norms of fields are computed.
    """

    start: str
    march_description: str
    modelled: tuple[str, ...]
    steady_state: str
    left_out: Mapping[str, str]
    quantities_missing: frozenset[str]
    compared_numbers: frozenset[str]
    marches: tuple[str, ...]
    most_steps: int
    allowed_over_rtol: float
    shared_keys: tuple[str, ...]
    most_probe_rings: int | None
    finest_rtol: float
    cells_of_face: int


@dataclass(frozen=True, eq=False)
class LoadRegime:
    """The regime of the load: a force or an indentation is given, and the load varies or not.

    Parameters
    ----------
    given : str
        Quantity that the load prescribes, so that no method has an error in it.
    response : str
        Quantity that methods compute instead.
    running_in_quantity : str
        Quantity whose history shows the running-in.
    spreading_end_text : str or None
        Text that follows "contact spreads from about ..." and states the end, with `{end}` for its
        time; None if the times cannot be predicted.
    added_quantities : frozenset of str
        Quantities that results contain even in full contact: forces and volumes that vary.
    remaining_fractions : mapping of str to float
        Fraction of the running-in that remains at each of the times in the answer.
    reported_forces : mapping of str to int
        Forces in the answer, each with its index among the times.
    decaying : frozenset of str
        Quantities that decay during wear.
    second_order : frozenset of str
        Quantities that converge with second or higher order in the cells of a face.
    modelled : tuple of str
        Sentences about additional features of the model.
    left_out : mapping of str to str
        What is not computed, with the reasons.
    marches : tuple of str
        Possible marches.
    no_steady_state : str
        Reason why there is no steady state; empty if there may be one.
    refused_without_times : str
        Reason why nothing can be computed without times; empty if something can.
    logarithmic_times : bool
        Whether figures have a logarithmic time axis. Under varying loads they do not, because late
        times are as interesting as early ones.
    """

    given: str
    response: str
    running_in_quantity: str
    spreading_end_text: str | None = " to {end}"
    added_quantities: frozenset[str] = frozenset()
    remaining_fractions: Mapping[str, float] = field(default_factory=dict)
    reported_forces: Mapping[str, int] = field(default_factory=dict)
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
        """Names of the times of running-in that the answer does not contain."""
        return TIMES_OF_RUNNING_IN - self.remaining_fractions.keys()


Regime = ContactRegime | LoadRegime


class Refusal(NamedTuple):
    """Why a method cannot solve a kind of problem, and what to write instead.

    Parameters
    ----------
    reason : str
        The reason, a clause.
    remedy : str
        What to write in the scene instead.
    """

    reason: str
    remedy: str = "leave it out of methods"

    def __str__(self) -> str:
        """Return the reason and the remedy in one line."""
        return f"{self.reason}: {self.remedy}"


TIMES_OF_RUNNING_IN = frozenset({"time_to_90", "time_to_99", "time_to_half_force"})

FULL_CONTACT = ContactRegime(
    start="the flat start",
    march_description="exact in time, by its relaxation modes",
    modelled=(),
    steady_state="",
    left_out={
        "inequality p >= 0": "a punch that starts flat never loses contact, because the pressure "
        "can only rise where it is close to zero",
    },
    # these are constant or redundant in full contact, in which the contact edges are those of the
    # face
    quantities_missing=frozenset(MOVING_CONTACT_QUANTITIES),
    compared_numbers=TIMES_OF_RUNNING_IN
    | {"running_in_time", "indentation_start", "force_share", "worn_volume"},
    marches=MARCHES,
    most_steps=2_000_000,  # each step is cheap: a product of matrices
    allowed_over_rtol=1.0,
    shared_keys=(
        *("punch.wear", "punch.radius", "half_space.plane", "half_space.youngs"),
        *("load.", "wear.", "output.", "title"),
    ),
    most_probe_rings=16,
    finest_rtol=1e-8,
    cells_of_face=0,
)

MOVING_CONTACT = ContactRegime(
    start="the unworn face",
    march_description="in implicit steps of second order, chosen from rtol",
    modelled=(
        "inequalities: pressure >= 0, gap >= 0, and one of them is zero at each point; contact "
        "opens, closes and spreads",
    ),
    steady_state="; it is that of the flat punch: wear ends with all of the face in contact",
    left_out={
        "springs' rule of the MDR": "q = d - g holds only if the contact is one disc; the energy "
        "of the MDR is used instead, which is valid for any contact",
        "relaxation modes": "modes exist only while the contact does not change; running-in times "
        "are reported if all of the face comes into contact",
        "ring pressures at the start": "they may be infinite at contact edges or on the axis",
        OPERATORS: "compared only for flat punches",
    },
    quantities_missing=frozenset({"relaxation_time"}),
    compared_numbers=frozenset(),
    marches=("modal", "implicit"),
    most_steps=200_000,  # each step is a contact problem
    # half of the uncertainty that the difference of two methods may have
    allowed_over_rtol=2.0,
    shared_keys=(),
    most_probe_rings=None,
    finest_rtol=1e-5,
    # the pressure is steep at contact edges, which may be anywhere on the face
    cells_of_face=250,
)

ONE_FORCE = LoadRegime(
    given="normal_force",
    response="indentation",
    running_in_quantity="displacement_max",
    remaining_fractions={"time_to_90": 0.1, "time_to_99": 0.01},
)

FIXED_INDENTATION = LoadRegime(
    given="indentation",
    response="normal_force",
    running_in_quantity="normal_force",
    spreading_end_text=" on",
    added_quantities=frozenset({"normal_force", "ring_worn_volume"}),
    remaining_fractions={"time_to_half_force": 0.5},
    reported_forces={"force_start": 0, "force_end": -1},
    decaying=frozenset({"normal_force", "ring_force"}),
    no_steady_state="at a fixed indentation, wear continues until the pressure vanishes",
    refused_without_times="with load.indentation the pressure vanishes in the steady state, so "
    "there is nothing to compute without a history: give wear.times",
)


def _with_varying_load(regime: LoadRegime) -> LoadRegime:
    """Return the variant of a load regime in which the force or the sliding speed varies."""
    return replace(
        regime,
        spreading_end_text=None,
        added_quantities=regime.added_quantities | {"normal_force"},
        remaining_fractions={},
        second_order=frozenset(),
        modelled=(
            "load over time: linear between the given times, and wear is integrated over the "
            "sliding distance; the steady state is that of the last force and speed, and "
            "relaxation times are those at the greatest speed",
        ),
        left_out={
            "times to 90 % and 99 % of running-in": "they are defined only for a constant load",
        },
        marches=("modal",),
        logarithmic_times=False,
    )


VARYING_FORCE = _with_varying_load(ONE_FORCE)
INDENTATION_AT_VARYING_SPEED = _with_varying_load(FIXED_INDENTATION)
# a flat punch that stays in full contact while the force falls; it has the quantities of a punch
# that may lose contact, because whether it does is only known after a prediction
FALLING_FORCE = replace(
    VARYING_FORCE,
    added_quantities=frozenset(MOVING_CONTACT_QUANTITIES),
    left_out={
        **VARYING_FORCE.left_out,
        "inequality p >= 0": "although the force falls, the punch stays in full contact: in a "
        "small solution, the pressure stays positive everywhere",
    },
)

FIXED_INDENTATIONS = FIXED_INDENTATION, INDENTATION_AT_VARYING_SPEED
# keys: whether the indentation is given, and whether the force or the sliding speed varies
LOADS = {
    (False, False): ONE_FORCE,
    (False, True): VARYING_FORCE,
    (True, False): FIXED_INDENTATION,
    (True, True): INDENTATION_AT_VARYING_SPEED,
}
