"""The non-dimensional problem.

Punch radius, plane strain modulus, force and ``a / (E* k_max v0)`` are 1.

Everything is computed in these units and scaled at the door only; their sizes in the scene's own
units are kept here.
"""

from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np

from ...mdr.flat_punch import flat_punch, presses_everywhere
from ...meshes.errors import SceneError
from ...meshes.ground.ground import Ground
from ...meshes.radial import (
    Array,
    Indices,
    alternating_edges,
    graded_breakpoints,
    ring_areas,
    ring_of,
)
from ...meshes.sizes import EdgeAmplitude
from .face import Face, Rings, SampledFace
from .loading import Loading
from .profile import FLAT, InitialProfile
from .punch import PunchSection
from .quantities import ENERGIES, GROUPS, HISTORIES, STEADY, Units, expand
from .regimes import (
    FULL_CONTACT,
    LOADS,
    MOVING_CONTACT,
    WEAR_ALONG_RADIUS,
    WEAR_ON_RINGS,
    ContactRegime,
    LoadRegime,
    Regime,
    WearRegime,
)
from .sections import (
    AccuracySection,
    FemAccuracy,
    HalfSpaceSection,
    LoadSection,
    MdrAccuracy,
    OutputSection,
    WearSection,
)

# times that running-in, and the times asked for, may take until all of the face carries: where it
# takes more, its steady state is out of reach
OUT_OF_REACH = 1e3
# times at which whole fields are compared, and by which errors are estimated
MOST_CHECKED, MOST_ESTIMATED = 40, 60


@dataclass(frozen=True, eq=False)
class Problem:
    """What the methods solve. Change it by `dataclasses.replace`.

    Parameters
    ----------
    rings : as the scene gives them, with harmonic means where wear is graded; `merged` is what has
        to be modelled
    times : (T,) increasing; empty if no history is wanted
    steady : whether the steady state is wanted
    poisson_ratio : of the half-space; the greatest of layers
    ground : layers; None for a homogeneous half-space
    rtol : relative accuracy wanted
    march, step : how to go through time; `step` is None for the modal march
    gradient_average : `line` or `area`, of Eq. 18
    output_radii : None for a grid that shows every ring
    fem, mdr : sizes that the user has given
    units : sizes of the units
    profile : of the unworn face
    compared_on : radii over the punch that fields are compared at; None for those that suit the
        problem
    indentation : beyond the first touch, held fixed in place of the force, which then is what a
        flat punch would take; None under a force
    graded : rings between the edges of which wear is linear; None if it is constant on `rings`
    quantities : names of those wanted; None for all that go with times and steady state. Sizes and
        estimates serve these alone
    loading : force and speed over time; their greatest values are those of the units, those held
        last make the steady state
    shared_amplitude : `edge_amplitude` of several problems that share a discretisation
        (`studies/sizes/shared.py`); None for its own
    """

    rings: Rings
    times: Array = field(default_factory=lambda: np.empty(0))
    steady: bool = True
    poisson_ratio: float = 0.3
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
    ground: Ground | None = None

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
        """Return the problem that the tables of a scene pose."""
        length, hole = punch.radius, punch.inner_radius / punch.radius
        if punch.ring_edges is None:
            along = alternating_edges(punch.rings or 1, punch.width_ratio)
            ring_edges = hole + (1 - hole) * along
        else:
            ring_edges = np.array([punch.inner_radius, *punch.ring_edges]) / length
        ring_edges[-1] = 1.0
        coefficients, graded = np.array(punch.coefficients), None
        if not punch.table:
            # two alternate from the centre
            coefficients = np.resize(coefficients, len(ring_edges) - 1)
        fastest = float(coefficients.max())
        coefficients = coefficients / fastest
        if punch.table:
            graded = Rings.graded(np.array(punch.table.radii) / length, coefficients, ring_edges)
            face = Face(graded.ring_edges, ring_edges, graded.at)
            coefficients = ring_areas(ring_edges) / face.ring_sums(face.areas / face.wear)
        modulus, ground = half_space.modulus, half_space.ground(length)
        unit_indentation = flat_punch(hole, ground).indentation
        force = load.greatest_force(length, punch.inner_radius)
        if load.indentation is not None:
            approach = punch.approach(load.indentation, ring_edges)
            force = length * modulus * approach / unit_indentation
        time = length / modulus / fastest / load.sliding.greatest
        units = Units(length, modulus, force, time, fastest)
        profile = punch.unworn(ring_edges, units.displacement)
        if graded:
            recess = profile.recess[ring_of(ring_edges, graded.ring_edges[:-1])]
            profile = replace(profile, ring_edges=graded.ring_edges, recess=recess)
        problem = cls(
            rings=Rings(ring_edges, coefficients),
            times=np.array(wear.times) / time,
            steady=wear.steady and load.indentation is None,
            poisson_ratio=half_space.greatest_poisson_ratio,
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
            loading=Loading.over_time(load.pressing, load.sliding, time),
            ground=ground,
        )
        if problem.why_never_steady:
            problem = replace(problem, steady=False)
        wanted = expand(output.quantities)
        return problem if wanted == GROUPS["all"] else problem.asking_for(wanted)

    @cached_property
    def merged(self) -> Rings:
        """Rings that have to be modelled.

        A recess ends at its ring's edge even if the next wears as fast. A hole is a first ring.
        """
        rings = self.graded or self.rings
        return (rings.merged() if self.full_contact else rings).with_hole()

    @property
    def inner_radius(self) -> float:
        """The radius of the hole; 0 if there is none."""
        return float(self.ring_edges[0])

    @property
    def full_contact(self) -> bool:
        """Whether all of the face carries at all times.

        A flat punch at a fixed indentation, or under a force that never falls, keeps contact,
        unless stiff layers bend away from it; any other may lose it. Without a history there is the
        steady state, in which all of the face carries.
        """
        keeps = self.ground is None or not len(self.times) or presses_everywhere(self.ground)
        return self.profile.flat and self.loading.rising and keeps

    @property
    def contact(self) -> ContactRegime:
        """Full contact or moving contact, with all that differs between them."""
        return FULL_CONTACT if self.full_contact else MOVING_CONTACT

    @property
    def load_regime(self) -> LoadRegime:
        """The kind of load: a force or an indentation, constant or not, with all that differs."""
        return LOADS[self.indentation is not None, self.loading.varies]

    @property
    def wear_regime(self) -> WearRegime:
        """Wear that is constant on rings or varies along the radius, with all that differs."""
        return WEAR_ALONG_RADIUS if self.merged.linear else WEAR_ON_RINGS

    @property
    def regimes(self) -> tuple[Regime, ...]:
        """Its regimes of wear, contact and load, in the order in which they are refused."""
        return self.wear_regime, self.contact, self.load_regime

    @property
    def quantities_missing(self) -> frozenset[str]:
        """Names of the quantities that its contact does not have under its load."""
        return self.contact.quantities_missing - self.load_regime.quantities_told

    @cached_property
    def time_to_wear_flat(self) -> float:
        """Sliding distance by which the greatest force wears off all that stands out of the face.

        It is ``int (max f - f) / k dA / F``; of a sphere, ``a^4 = 4 R k F t / pi``. Then about all
        of the face carries.
        """
        radii, heights = self.profile.sampled()
        between, areas = (radii[1:] + radii[:-1]) / 2, np.pi * np.diff(radii**2)
        means = (heights[1:] + heights[:-1]) / 2
        return float((heights.max() - means) / self.merged.at(between) @ areas)

    @cached_property
    def why_never_steady(self) -> str:
        """Why there is no steady state to tell, although a force presses; empty if there is one."""
        if self.indentation is not None:
            return ""
        last_force, last_speed = self.loading.forces[-1], self.loading.speeds[-1]
        if not last_force or not last_speed:
            what = "nothing presses" if not last_force else "the punch stands still"
            return f"in the end {what}, and the face wears no more"
        if self.full_contact or not self.earliest:
            return ""
        # running-in takes about the slowest relaxation time, that of the slowest material
        running_in = 1 / float(self.merged.ends[1].min())
        if self.time_to_wear_flat <= OUT_OF_REACH * max(float(self.distances[-1]), running_in):
            return ""
        time = self.time_to_wear_flat / last_force / last_speed * self.units.time
        return (
            f"out of reach: all of the face would carry from about t = {time:.2g} on only, and the "
            "steady state of the part that carries until then is not known; the history is right"
        )

    @property
    def ring_edges(self) -> Array:
        """(N+1,) edges of the rings of the scene, from 0, or from the hole, to 1."""
        return self.rings.ring_edges

    @property
    def wear_coefficients(self) -> Array:
        """(N,) wear coefficients of these rings over the greatest, harmonic means where graded."""
        return self.rings.wear_coefficients

    @cached_property
    def distances(self) -> Array:
        """(T,) sliding distance by each time: the time itself at constant speed."""
        if not len(self.times):
            return self.times
        return self.loading.at(self.times).distance

    @property
    def earliest(self) -> float:
        """The first sliding distance after the start; 0 without any."""
        return float(min(self.distances[self.distances > 0], default=0.0))

    @property
    def edge_amplitude(self) -> EdgeAmplitude:
        """Of the pressures that are asked for, by what wear has blunted: sizes go by it."""
        if self.shared_amplitude is not None:
            return self.shared_amplitude
        (inner, wear), earliest = self.merged.ends, self.earliest or np.inf
        outside = np.append(inner[1:], wear[-1])
        slower = np.minimum(wear, outside)
        span = float(self.distances[-1] / earliest) if self.earliest else 1.0
        worn_length_slow = np.where(self.merged.smooth, np.inf, slower * earliest)
        ratio = np.maximum(wear, outside) / slower
        narrower = np.append(self.merged.narrower, self.merged.widths[-1])
        return EdgeAmplitude(self.rtol, worn_length_slow, ratio, span, self.merged.kinks, narrower)

    def asking_for(self, quantities: frozenset[str]) -> "Problem":
        """Return the problem of these quantities alone: no times or steady state but for them.

        Raises
        ------
        SceneError
            if the scene has none of them
        """
        wanted = quantities - self.quantities_missing
        if not len(self.times):
            wanted -= HISTORIES
        if not self.steady:
            wanted -= STEADY
        if not wanted:
            raise SceneError(
                f"output.quantities = {', '.join(sorted(quantities))}: the scene has none of them; "
                "give wear.times for a history, steady = true for a steady state"
                + (f" (which is {self.why_never_steady})" if self.why_never_steady else "")
            )
        history = bool(wanted & HISTORIES)
        times, march = (self.times, self.march) if history else (self.times[:0], "modal")
        steady = bool(wanted & STEADY)
        return replace(self, quantities=wanted, times=times, march=march, steady=steady)

    def wants(self, quantity: str) -> bool:
        """Return whether a quantity is wanted."""
        return self.quantities is None or quantity in self.quantities

    @property
    def energies_only(self) -> bool:
        """Whether nothing but energies is wanted, which converge twice as fast as fields do."""
        return self.quantities is not None and self.quantities <= set(ENERGIES)

    @cached_property
    def radii(self) -> Array:
        """Radii of the output: the user's, or a grid that is dense near ring edges, not on them."""
        if self.output_radii is not None:
            return self.output_radii
        count = max(8, 320 // len(self.wear_coefficients))
        within = (1 - np.cos(np.pi * (np.arange(count) + 0.5) / count)) / 2
        inner, outer = self.ring_edges[:-1, None], self.ring_edges[1:, None]
        radii = (inner + (outer - inner) * within).ravel()
        return radii if self.inner_radius else np.concatenate([[0.0], radii])

    @cached_property
    def face(self) -> Face:
        """Radii that crowd at ring edges and at the rim, as the layers of the earliest time do."""
        if self.compared_on is not None:
            return self.compared_on
        rings = self.merged
        rim = float(np.clip(0.1 * self.edge_amplitude.worn_length_slow[-1], 1e-12, 1e-6))
        nearest = 1e-4 * rings.narrower
        if self.full_contact:
            # slopes of early times are steepest within what wear has blunted beside an edge
            nearest = np.clip(
                0.1 * self.edge_amplitude.worn_length_slow[:-1], 1e-12, 1e-8 * rings.narrower
            )
        breakpoints = graded_breakpoints(rings.ring_edges, nearest, rim, factor=0.4)
        # the integral over each ring that the scene names, also where nothing happens at its edge
        breakpoints = np.union1d(breakpoints, self.ring_edges)
        cells = self.contact.cells_of_face
        if self.ground is not None:
            # fields vary over the thickness of the first layer
            cells = max(cells, int(np.ceil(1 / self.ground.first_thickness)))
        if cells:
            even = np.linspace(0, 1, cells + 1)
            # slopes of an element as wide as roundoff would be roundoff over that
            apart = np.abs(even[:, None] - breakpoints).min(axis=1) > 1e-9
            breakpoints = np.union1d(breakpoints, even[apart])
        breakpoints = breakpoints[breakpoints >= self.inner_radius]
        return Face(breakpoints, self.ring_edges, rings.at, self.profile.standoff)

    def sampled_face(self, radii: Array) -> SampledFace:
        """Return the face at radii (R,) that somebody gives, increasing."""
        rings, standoff = self.merged, self.profile.standoff
        return SampledFace(radii, rings.ring_edges, rings.at, standoff, self.inner_radius)

    @cached_property
    def checked(self) -> Indices:
        """(C,) indices of times at which whole fields are compared: all, or evenly chosen ones."""
        count = len(self.times)
        return np.unique(
            np.linspace(0, count - 1, min(count, MOST_CHECKED)).round().astype(np.int64)
        )

    @cached_property
    def estimate_times(self) -> Array:
        """Times that errors are estimated at.

        From the earliest in steps of about two to beyond the last, and the start.
        """
        later = self.times[self.distances > 0]
        if not len(later):
            return self.times
        count = min(int(np.log2(later[-1] / later[0])) + 3, MOST_ESTIMATED)
        times = [self.times[:1][self.times[:1] == 0], np.geomspace(later[0], 2 * later[-1], count)]
        if self.loading.varies:
            # what knots bring does not come in proportion to the time
            times.append(self.times[self.checked])
        return np.unique(np.concatenate(times))
