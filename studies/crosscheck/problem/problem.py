"""Define the non-dimensional problem that all methods solve.

The units are the punch radius a, the plane strain modulus E*, the greatest force F and the time ``a
/ (E* k_max v0)`` with the greatest wear coefficient and sliding speed. Everything is computed in
these units; only input and output are scaled, by the unit sizes that a `Problem` stores.
"""

from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np

from ....mdr.flat_punch import flat_punch_of, presses_everywhere
from ....meshes.errors import SceneError
from ....meshes.ground.ground import HALF_SPACE, Ground
from ....meshes.radial import (
    Array,
    Indices,
    graded_breakpoints,
    ring_areas,
    ring_of,
)
from ....meshes.sizes import EdgeAmplitude
from .face import Face, Rings, SampledFace
from .loading import Loading
from .profile import FLAT, InitialProfile
from .punch import PunchSection
from .quantities import ANSWER, ENERGIES, HISTORIES, STEADY, Units
from .refusal import Feature
from .sections import (
    AccuracySection,
    FemAccuracy,
    HalfSpaceSection,
    LoadSection,
    MdrAccuracy,
    OutputSection,
    WearSection,
)

# greatest sliding distance until full contact, over the last requested distance or the running-in
# distance, whichever is greater; beyond it, the steady state counts as out of reach
MOST_TIME_TO_WEAR_FLAT = 1e3
# greatest numbers of times at which fields are compared, and at which errors are estimated
MOST_COMPARED_TIMES, MOST_ESTIMATE_TIMES = 40, 60
# part of rtol below which a change of the force, over the force, has no effect on the results
LEAST_CHANGE = 0.01
# least number of equal cells of the face on which norms are computed, by whether the punch is in
# full contact; else the pressure is steep at contact edges, which may be anywhere on the face
CELLS_OF_FACE = {True: 0, False: 250}
# greatest number of pairs of a time and a change of the load that are considered at once
MOST_CHANGES_AT_ONCE = 1_000_000


def _least_positive(values: Array) -> float:
    """Return the least positive one of some values; 0 if there is none."""
    positive = values[values > 0]
    return float(positive.min()) if len(positive) else 0.0


@dataclass(frozen=True, eq=False)
class Problem:
    """The non-dimensional problem that methods solve. Vary it with `dataclasses.replace`.

    Parameters
    ----------
    rings : rings of the scene, with harmonic means of graded wear coefficients; the rings that are
        modelled are `merged`
    times : (T,) increasing; empty if no history is wanted
    steady : whether the steady state is wanted
    rtol : requested relative accuracy
    step_rtol : tolerance from which time steps are chosen, if it is not `rtol`
    march, step : march in time, and its step, which is None for the modal march
    gradient_average : "line" or "area", the average in the RMS slope (Eq. 18)
    output_radii : radii of the output; None for a grid that shows every ring
    fem, mdr : sizes and degrees given by the user
    units : sizes of the units, in units of the scene
    profile : unworn face
    indentation : fixed indentation beyond the first touch; None under a force. The unit of force is
        then the force on a flat punch at that indentation
    compared_on : radii at which fields are compared; None for radii chosen for this problem
    graded : rings on which the wear coefficient is linear; None if it is constant on `rings`
    quantities : names of the requested quantities; None for all that the times and the steady state
        allow. Sizes and error estimates take only these into account
    loading : force and speed over time, relative to their greatest values; the last values
        determine the steady state
    shared_amplitude : `edge_amplitude` for several problems that share a discretisation
        (`studies/crosscheck/sizes/shared.py`); None to compute it for this problem
    ground : layers, if there are any
    keeps_contact : whether a flat punch stays in full contact while the force falls, as
        `studies/crosscheck/wear/falling_force.py` predicts
    as_wide_as_scar : whether the scene gives no radius, and the face is wider than the contact gets
    """

    rings: Rings
    times: Array = field(default_factory=lambda: np.empty(0))
    steady: bool = True
    rtol: float = 1e-4
    march: str = "modal"
    step: float | None = None
    gradient_average: str = "line"
    output_radii: Array | None = None
    fem: FemAccuracy = field(default_factory=FemAccuracy)
    mdr: MdrAccuracy = field(default_factory=MdrAccuracy)
    units: Units = field(default_factory=Units)
    profile: InitialProfile = FLAT
    indentation: float | None = None
    compared_on: Face | None = None
    graded: Rings | None = None
    quantities: frozenset[str] | None = None
    loading: Loading = field(default_factory=Loading)
    shared_amplitude: EdgeAmplitude | None = None
    ground: Ground = HALF_SPACE
    keeps_contact: bool = False
    step_rtol: float | None = None
    as_wide_as_scar: bool = False

    @classmethod
    def from_tables(
        cls,
        punch: PunchSection,
        half_space: HalfSpaceSection,
        load: LoadSection,
        wear: WearSection,
        accuracy: AccuracySection,
        output: OutputSection,
    ) -> "Problem":
        """Return the problem that the tables of a scene define."""
        length, ring_edges = punch.radius, punch.relative_edges
        coefficients, graded = np.array(punch.coefficients), None
        if not punch.table:
            # two coefficients alternate from the centre
            coefficients = np.resize(coefficients, len(ring_edges) - 1)
        fastest = float(coefficients.max())
        coefficients = coefficients / fastest
        if punch.table:
            graded = Rings.graded(np.array(punch.table.radii) / length, coefficients, ring_edges)
            face = Face(graded.ring_edges, ring_edges, graded.at)
            coefficients = ring_areas(ring_edges) / face.ring_sums(face.areas / face.wear)
        modulus, ground = half_space.modulus, half_space.ground(length)
        unit_indentation = flat_punch_of(ring_edges[0], ground).indentation
        force = load.greatest_force(length, punch.inner_radius)
        if load.indentation is not None:
            approach = punch.approach(load.indentation, ring_edges)
            force = length * modulus * approach / unit_indentation
        time = length / modulus / fastest / load.speed_over_time.greatest
        units = Units(length, modulus, force, time, fastest)
        profile = punch.unworn(ring_edges, units.displacement)
        if graded:
            recess = profile.recess[ring_of(ring_edges, graded.ring_edges[:-1])]
            profile = replace(profile, ring_edges=graded.ring_edges, recess=recess)
        problem = cls(
            rings=Rings.constant(ring_edges, coefficients),
            times=np.array(wear.times) / time,
            steady=wear.steady and load.indentation is None,
            rtol=accuracy.rtol,
            march=wear.march,
            step=None if wear.step is None else wear.step / time,
            gradient_average=output.gradient_average,
            output_radii=None if output.radii is None else np.array(output.radii) / length,
            fem=accuracy.fem,
            mdr=accuracy.mdr,
            units=units,
            profile=profile,
            graded=graded,
            indentation=None if load.indentation is None else unit_indentation,
            loading=Loading.over_time(load.load_over_time, load.speed_over_time, time),
            ground=ground,
            as_wide_as_scar=punch.as_wide_as_scar,
        )
        return replace(problem, steady=False) if problem.reason_not_steady else problem

    @cached_property
    def merged(self) -> Rings:
        """The rings that are modelled.

        In full contact, neighbours of equal wear are merged. On shaped faces they are not, because
        recesses end at ring edges.
        """
        rings = self.graded or self.rings
        return rings.merged() if self.full_contact else rings

    @property
    def inner_radius(self) -> float:
        """The radius of the hole; 0 if there is none."""
        return float(self.ring_edges[0])

    @property
    def poisson_ratio(self) -> float:
        """Poisson's ratio of the half-space; the greatest one if there are layers."""
        return self.ground.greatest_poisson_ratio

    @property
    def full_contact(self) -> bool:
        """Whether all of the face stays in contact.

        A flat punch does at a fixed indentation or under a force that never falls, unless stiff
        layers bend away from it, which matters in a history only. Any other may lose contact,
        unless a prediction excludes this.
        """
        may_bend_away = bool(len(self.times)) and self.ground.layered
        keeps = not may_bend_away or presses_everywhere(self.ground, self.inner_radius)
        return self.profile.flat and (self.loading.rising or self.keeps_contact) and keeps

    @property
    def constant_force(self) -> bool:
        """Whether one force and one sliding speed are given."""
        return self.indentation is None and not self.loading.varies

    @property
    def prescribed(self) -> str:
        """The quantity that the load prescribes, in which no method has an error."""
        return "normal_force" if self.indentation is None else "indentation"

    @property
    def response(self) -> str:
        """The quantity that methods compute because the load does not prescribe it."""
        return "indentation" if self.indentation is None else "normal_force"

    @property
    def known(self) -> frozenset[str]:
        """The quantities over time that the scene itself determines."""
        constant = frozenset({"normal_force"}) if self.constant_force else frozenset()
        return constant | {"contact_radius"} if self.full_contact else constant

    @property
    def remaining_parts(self) -> dict[str, float]:
        """The part of the running-in that remains at each time of it in the answer.

        These times are defined for a constant load.
        """
        if self.loading.varies or self.as_wide_as_scar:
            return {}
        fixed = self.indentation is not None
        names = ("time_to_half_force",) if fixed else ("time_to_90", "time_to_99")
        return {name: part for name in names if (part := ANSWER[name].remaining)}

    @property
    def features(self) -> tuple[Feature, ...]:
        """The features that methods may refuse, in the order in which they do."""
        present: dict[Feature, bool] = {
            "layers": self.ground.layered,
            "wear along the radius": self.merged.linear,
            "moving contact": not self.full_contact,
            "fixed indentation": self.indentation is not None,
            "varying load": self.loading.varies,
        }
        return tuple(feature for feature, has in present.items() if has)

    @cached_property
    def time_to_wear_flat(self) -> float:
        """Sliding distance in which the greatest force wears the face flat.

        It is ``int (max f - f) / k dA / F``; for a sphere, ``a^4 = 4 R k F t / pi``. Contact
        becomes full at about this distance.
        """
        radii, heights = self.profile.sampled()
        between, areas = (radii[1:] + radii[:-1]) / 2, np.pi * np.diff(radii**2)
        means = (heights[1:] + heights[:-1]) / 2
        return float((heights.max() - means) / self.merged.at(between) @ areas)

    @property
    def least_steps(self) -> int:
        """The number of contact problems that a march of a contact that moves solves at least.

        One belongs to each requested time and each knot of the load. Once all of the face is in
        contact, relaxation modes take the place of steps if the load is constant.
        """
        if not len(self.times):
            return 0
        ends = self.loading.contact_times(self.times)
        if self.loading.varies or self.indentation is not None:
            return len(ends)
        return int(np.count_nonzero(ends < self.time_to_wear_flat))

    @cached_property
    def reason_not_steady(self) -> str:
        """The reason why no steady state under a force is reported; empty if there is one."""
        if self.as_wide_as_scar:
            return "the scar goes on growing"
        if self.indentation is not None:
            return ""
        last_force, last_speed = self.loading.forces[-1], self.loading.speeds[-1]
        if not last_force or not last_speed:
            reason = "the force is 0" if not last_force else "the punch stands still"
            return f"in the end {reason}, and the face no longer wears"
        if self.full_contact or not self.earliest:
            return ""
        # running-in takes about the slowest relaxation time, 1 / least wear coefficient
        running_in = 1 / float(self.merged.wear_coefficients[1].min())
        if self.time_to_wear_flat <= MOST_TIME_TO_WEAR_FLAT * max(
            float(self.distances[-1]), running_in
        ):
            return ""
        time = self.time_to_wear_flat / last_force / last_speed * self.units.time
        return (
            f"out of reach: all of the face would be in contact only after about t = {time:.2g}; "
            "the steady state of the part in contact until then is not computed; the history is "
            "valid"
        )

    @property
    def ring_edges(self) -> Array:
        """(N+1,) edges of the rings of the scene, from the axis or the hole to the rim at 1."""
        return self.rings.ring_edges

    @property
    def wear_coefficients(self) -> Array:
        """(N,) wear coefficients of these rings over the greatest; harmonic means if graded."""
        return self.rings.wear_coefficients[0]

    @cached_property
    def distances(self) -> Array:
        """(T,) sliding distance until each time; at constant speed it equals the time."""
        if not len(self.times):
            return self.times
        return self.loading.at(self.times).distance

    @cached_property
    def _worn_since_changes(self) -> tuple[Array, Array]:
        """(T,) `worn_distances`, and the distances (T,) since the last change that matters."""
        if not self.loading.varies:
            return self.distances, self.distances
        layers, decays = [], []
        # in blocks, because a load may have many knots, and a history many times
        blocks = 1 + len(self.times) * len(self.loading.times) // MOST_CHANGES_AT_ONCE
        for times in np.array_split(self.times, blocks):
            slid, parts = self.loading.changes_before(times)
            matters = (slid > 0) & (parts >= LEAST_CHANGE * self.rtol)
            decayed = np.where(matters, slid, np.inf)
            layers.append((decayed / np.where(matters, parts, 1.0) ** 2).min(axis=1))
            decays.append(decayed.min(axis=1))
        # at times without sliding there is no finite distance
        worn, since_change = (
            np.where(self.distances > 0, np.concatenate(rows), 0.0) for rows in (layers, decays)
        )
        return worn, since_change

    @property
    def worn_distances(self) -> Array:
        """(T,) sliding distance over which wear has smoothed the pressure, until each time.

        Each change of the force presses the punch on anew. If it changes a part of the force, the
        thin layers that wear has made since then contribute the square of that part to mean squares
        of pressures and slopes. Therefore the distance since the change counts over that square.
        """
        return self._worn_since_changes[0]

    @property
    def earliest(self) -> float:
        """The least positive one of `worn_distances`; 0 if there is none."""
        return _least_positive(self.worn_distances)

    @property
    def shortest_decay(self) -> float:
        """The least positive distance since a change of the force that matters; 0 if there is none.

        Modes that decay within a much shorter distance do not contribute to the history.
        """
        return _least_positive(self._worn_since_changes[1])

    @cached_property
    def edge_amplitude(self) -> EdgeAmplitude:
        """Amplitude of high polynomial degrees near ring edges, from which sizes are chosen.

        It depends on the lengths over which wear has smoothed the pressure at the earliest time.
        """
        if self.shared_amplitude is not None:
            return self.shared_amplitude
        earliest, (slower, faster) = self.earliest or np.inf, self.merged.wear_at_edges
        span = float(self.distances[-1] / earliest) if self.earliest else 1.0
        worn_length_slow = np.where(self.merged.smooth, np.inf, slower * earliest)
        kinks, widths = self.merged.kinks, self.merged.widths_at_edges
        gradients = self.merged.wear_gradients if self.merged.linear else None
        return EdgeAmplitude(
            self.rtol, worn_length_slow, faster / slower, span, kinks, widths, gradients
        )

    def with_quantities(self, quantities: frozenset[str]) -> "Problem":
        """Return the problem of these quantities, with times and steady state only if needed.

        Raises
        ------
        SceneError
            if the scene has none of these quantities
        """
        requested = quantities
        if self.as_wide_as_scar:
            # an average over the face would depend on its radius
            requested -= {"rms_slope"}
        if not self.full_contact:
            # relaxation modes exist only while the contact does not change
            requested -= {"relaxation_time"}
        if not len(self.times):
            requested -= HISTORIES
        if not self.steady:
            requested -= STEADY
        if not requested:
            raise SceneError(
                f"output.quantities = {', '.join(sorted(quantities))}: the scene has none of them; "
                "give wear.times for a history, steady = true for a steady state"
                + (f" (not available: {self.reason_not_steady})" if self.reason_not_steady else "")
            )
        history = bool(requested & HISTORIES)
        times, march = (self.times, self.march) if history else (self.times[:0], "modal")
        steady = bool(requested & STEADY)
        return replace(self, quantities=requested, times=times, march=march, steady=steady)

    def wants(self, quantity: str) -> bool:
        """Return whether a quantity is requested."""
        return self.quantities is None or quantity in self.quantities

    @property
    def energies_only(self) -> bool:
        """Whether only energies are requested, which converge twice as fast as fields."""
        return self.quantities is not None and self.quantities <= ENERGIES

    @cached_property
    def radii(self) -> Array:
        """Radii of the output: the user's, or a grid that is dense near ring edges."""
        if self.output_radii is not None:
            return self.output_radii
        count = max(8, 320 // len(self.wear_coefficients))
        fractions = (1 - np.cos(np.pi * (np.arange(count) + 0.5) / count)) / 2
        inner, outer = self.ring_edges[:-1, None], self.ring_edges[1:, None]
        radii = (inner + (outer - inner) * fractions).ravel()
        return radii if self.inner_radius else np.concatenate([[0.0], radii])

    @cached_property
    def face(self) -> Face:
        """Radii at which fields are compared, dense near ring edges as needed at the first time."""
        if self.compared_on is not None:
            return self.compared_on
        rings = self.merged
        rim = float(np.clip(0.1 * self.edge_amplitude.worn_length_slow[-1], 1e-12, 1e-6))
        # early slopes are greatest within the length over which wear has smoothed the pressure
        farthest = (1e-8 if self.full_contact else 1e-4) * rings.narrower
        nearest = np.clip(0.1 * self.edge_amplitude.worn_length_slow[:-1], 1e-12, farthest)
        if self.inner_radius:
            # pressures at the hole are infinite, and the first radius must not be rounded to it
            nearest[0] = max(nearest[0], 1e-12)
        sizes = np.append(nearest, rim)
        breakpoints, _ = graded_breakpoints(rings.ring_edges, sizes, factor=0.4)
        # integrals over each ring of the scene need its edges, even between rings of equal wear
        breakpoints = np.union1d(breakpoints, self.ring_edges)
        # on layers, fields vary over the thickness of the first one
        cells = max(CELLS_OF_FACE[self.full_contact], int(np.ceil(1 / self.ground.first_thickness)))
        if cells:
            even_breakpoints = np.linspace(0, 1, cells + 1)
            # omit breakpoints that would make very narrow elements, in which slopes are roundoff
            distinct = np.abs(even_breakpoints[:, None] - breakpoints).min(axis=1) > 1e-9
            breakpoints = np.union1d(breakpoints, even_breakpoints[distinct])
        breakpoints = breakpoints[breakpoints >= self.inner_radius]
        return Face(breakpoints, self.ring_edges, rings.at, self.profile.standoff)

    def sampled_face(self, radii: Array) -> SampledFace:
        """Return the face at given, increasing radii (R,)."""
        rings, standoff = self.merged, self.profile.standoff
        return SampledFace(radii, rings.ring_edges, rings.at, standoff, self.inner_radius)

    @cached_property
    def compared_rows(self) -> Indices:
        """(C,) indices of the times at which fields are compared: all, or evenly spaced ones."""
        count = len(self.times)
        return np.unique(
            np.linspace(0, count - 1, min(count, MOST_COMPARED_TIMES)).round().astype(np.int64)
        )

    @cached_property
    def estimate_times(self) -> Array:
        """Times at which errors are estimated.

        They are the start, and a geometric sequence with a ratio of about 2 from the first time of
        sliding to twice the last time. If the load varies, the compared times are added.
        """
        later = self.times[self.distances > 0]
        if not len(later):
            return self.times
        count = min(int(np.log2(later[-1] / later[0])) + 3, MOST_ESTIMATE_TIMES)
        times = [self.times[:1][self.times[:1] == 0], np.geomspace(later[0], 2 * later[-1], count)]
        if self.loading.varies:
            # changes of the load do not follow the geometric sequence
            times.append(self.times[self.compared_rows])
        return np.unique(np.concatenate(times))
