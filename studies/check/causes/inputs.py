"""Mistakes in single numbers of the input, which are predicted by solving the changed scene.

No scaling describes how wear coefficients, edges of rings and layers change the history; nor, on
punches that are not flat, load, modulus and shape. Between some sizes it is interpolated.
"""

from abc import abstractmethod
from collections.abc import Callable
from itertools import combinations
from typing import ClassVar

import numpy as np

from ...crosscheck import Scene
from .cause import Cause, Sizes
from .histories import MAX_RINGS
from .model import Model
from .setting import SceneChange, Setting

# greatest number of wear coefficients, and of layers, of which each is considered
MAX_MATERIALS, MAX_LAYERS = 5, 2


class WrongInput(Cause):
    """A number of the input is wrong by a factor, or something in it is exchanged.

    Attributes
    ----------
    nodes : factors for which the changed scene is solved; empty if candidates are the only sizes
    points : number of nodes that are used for one interpolation
    """

    nodes: ClassVar[tuple[float, ...]] = ()
    points: ClassVar[int] = 4

    @abstractmethod
    def changed(self, scene: Scene, size: float) -> Scene:
        """Return the scene with the mistake."""

    def candidates(self, model: Model) -> list[Sizes]:
        """Return the sizes to try or to begin a search at."""
        if not self.nodes:
            return [(1.0,)]
        # from the nodes on both sides of no change
        place = self.nodes.index(1.0)
        return [(self.nodes[place - 1],), (self.nodes[place + 1],)]

    def change(self, setting: Setting, sizes: Sizes) -> Setting:
        """Return the setting with this mistake added."""
        change = SceneChange(self.changed, sizes[0], self.nodes, self.points)
        return setting._replace(scene_change=change)

    def is_possible(self, model: Model, sizes: Sizes) -> bool:
        """Return whether the size lies in the range that is considered."""
        return not self.nodes or self.nodes[0] < sizes[0] < self.nodes[-1]


class WearRatio(WrongInput):
    """The wear coefficient of one material is wrong, and those of the others are right.

    Parameters
    ----------
    material : index of the material among the distinct wear coefficients, in increasing order
    """

    name = "wear ratio"
    group, searched = "ground", True
    prior = 0.06
    fitted_numbers = 1
    nodes = (0.09, 0.2, 0.45, 1.0, 2.2, 5.0, 11.0)
    remedy = "compare the wear coefficient of each material; late pressures are inverse to them"

    def __init__(self, material: int) -> None:
        self.material = material

    def applies(self, model: Model) -> bool:
        """Return whether the mistake could be recognised in these results."""
        return model.has_later_times

    def changed(self, scene: Scene, size: float) -> Scene:
        """Return the scene with the mistake."""
        value = wear_values(scene)[self.material]
        factors = [size if each == value else 1.0 for each in ring_wear(scene)]
        wear = np.multiply(ring_wear(scene), factors)
        return scene.changed(punch__wear_coefficients=wear.tolist())

    def sentence(self, model: Model, setting: Setting, sizes: Sizes) -> str:
        """Return what the error looks like, with its number, as a noun phrase."""
        value = wear_values(model.comparison.scene)[self.material]
        wear = model.names.write(value, "wear_coefficient")
        return (
            f"a wrong ratio of wear coefficients: that of the material with k = {wear} is "
            f"{sizes[0]:.4g} times ours"
        )


class RingEdges(WrongInput):
    """All edges between rings are shifted by the same factor, and the rim is right."""

    name = "ring edges"
    group, searched = "ground", True
    prior = 0.04
    fitted_numbers = 1
    nodes, points = (0.76, 0.82, 0.88, 0.95, 1.0, 1.05, 1.12, 1.18, 1.24), 2
    remedy = "compare the radii at which late pressures jump with the ring edges of the scene"

    def applies(self, model: Model) -> bool:
        """Return whether the mistake could be recognised in these results."""
        edges = model.problem.ring_edges
        space = bool((edges[1:-1] * self.nodes[-1] < 1).all()) and edges[0] == 0
        return model.has_later_times and len(edges) > 2 and space

    def changed(self, scene: Scene, size: float) -> Scene:
        """Return the scene with the mistake."""
        edges = scene.problem.ring_edges[1:] * scene.punch.radius
        edges[:-1] *= size
        wear = ring_wear(scene)
        return scene.changed(punch__ring_edges=edges.tolist(), punch__wear_coefficients=wear)

    def sentence(self, model: Model, setting: Setting, sizes: Sizes) -> str:
        """Return what the error looks like, with its number, as a noun phrase."""
        return f"edges between rings at {sizes[0]:.4g} times our radii"


class ExchangedMaterials(WrongInput):
    """Two of more than two wear coefficients are exchanged.

    Parameters
    ----------
    materials : indices of both among the distinct wear coefficients, in increasing order
    """

    name = "swapped materials"
    group = "ground"
    prior = 0.02
    remedy = "look at the latest pressures: they must be greatest on rings that wear least"

    def __init__(self, materials: tuple[int, int]) -> None:
        self.materials = materials

    def applies(self, model: Model) -> bool:
        """Return whether the mistake could be recognised in these results."""
        return model.has_later_times

    def changed(self, scene: Scene, size: float) -> Scene:
        """Return the scene with the mistake."""
        first, second = (wear_values(scene)[material] for material in self.materials)
        exchanged = {first: second, second: first}
        wear = [exchanged.get(value, value) for value in ring_wear(scene)]
        return scene.changed(punch__wear_coefficients=wear)

    def sentence(self, model: Model, setting: Setting, sizes: Sizes) -> str:
        """Return what the error looks like, with its number, as a noun phrase."""
        values = wear_values(model.comparison.scene)
        first, second = (
            model.names.write(values[material], "wear_coefficient") for material in self.materials
        )
        return f"swapped wear coefficients of two materials, {first} and {second}"


class LayerInput(WrongInput):
    """A number of one layer, or of the base below the layers, is wrong.

    Parameters
    ----------
    place : index of the layer from the surface down; one more than the last is the base
    """

    group = "ground"

    def __init__(self, place: int) -> None:
        self.place = place

    def changed(self, scene: Scene, size: float) -> Scene:
        """Return the scene with the mistake."""
        materials = layer_tables(scene)
        self.alter(materials[self.place], size)
        return with_layers(scene, materials)

    @abstractmethod
    def alter(self, material: dict[str, float], size: float) -> None:
        """Put the mistake into the table of a layer."""


class LayerFactor(LayerInput):
    """The modulus or the thickness of a layer, or the modulus of the base, is wrong.

    Parameters
    ----------
    key : `youngs_modulus` or `thickness`
    """

    name = "layer"
    searched, fitted_numbers = True, 1
    prior = 0.04
    nodes, points = (0.2, 0.45, 1.0, 2.2, 5.0), 3
    remedy = "compare Young's modulus and the thickness of each layer"

    def __init__(self, place: int, key: str) -> None:
        super().__init__(place)
        self.key, self.label = key, key.removeprefix("youngs_")

    def name_of(self, model: Model, setting: Setting, sizes: Sizes) -> str:
        """Return the name of the mistake at these sizes."""
        return f"{self.label} of a layer"

    def alter(self, material: dict[str, float], size: float) -> None:
        """Put the mistake into the table of a layer."""
        material[self.key] *= size

    def sentence(self, model: Model, setting: Setting, sizes: Sizes) -> str:
        """Return what the error looks like, with its number, as a noun phrase."""
        return f"a {self.label} of {described(model, self.place)} of {sizes[0]:.4g} times ours"


class LayerPoissonsRatio(LayerInput):
    """Poisson's ratio of a layer or of the base is wrong."""

    name = "Poisson's ratio of a layer"
    fitted_numbers = 1
    prior = 0.05
    remedy = "compare Poisson's ratio of each layer"
    ratios = (0.0, 0.2, 0.3, 0.4, 0.45, 0.49)

    def candidates(self, model: Model) -> list[Sizes]:
        """Return the sizes to try or to begin a search at."""
        ratio = layer_tables(model.comparison.scene)[self.place]["poisson_ratio"]
        return [(each,) for each in self.ratios if abs(each - ratio) > 0.005]

    def alter(self, material: dict[str, float], size: float) -> None:
        """Put the mistake into the table of a layer."""
        material["poisson_ratio"] = size

    def sentence(self, model: Model, setting: Setting, sizes: Sizes) -> str:
        """Return what the error looks like, with its number, as a noun phrase."""
        return f"a Poisson's ratio of {described(model, self.place)} of about {sizes[0]:.2g}"


class SwappedLayers(WrongInput):
    """Materials, or only the moduli, of two layers, or of a layer and the base, are exchanged.

    Parameters
    ----------
    places : indices of both from the surface down; one more than the last layer is the base
    keys : of the numbers that are exchanged
    """

    name = "swapped layers"
    group = "ground"
    prior = 0.04
    remedy = "compare the material of the model at each depth with the layers of the scene"

    def __init__(self, places: tuple[int, int], keys: tuple[str, ...]) -> None:
        self.places, self.keys = places, keys

    def changed(self, scene: Scene, size: float) -> Scene:
        """Return the scene with the mistake."""
        materials = layer_tables(scene)
        upper, lower = (materials[place] for place in self.places)
        for key in self.keys:
            upper[key], lower[key] = lower[key], upper[key]
        return with_layers(scene, materials)

    def sentence(self, model: Model, setting: Setting, sizes: Sizes) -> str:
        """Return what the error looks like, with its number, as a noun phrase."""
        what = "moduli" if len(self.keys) == 1 else "materials"
        upper, lower = (described(model, place) for place in self.places)
        return f"swapped {what} of {upper} and {lower}"


class ShapedPunchInput(WrongInput):
    """A number of a scene with a punch that is not flat is wrong.

    Parameters
    ----------
    label : name of the mistake
    described : what is multiplied, in words
    change_scene : returns the scene with this number multiplied by a factor
    """

    name = "input"
    group, searched = "ground", True
    prior = 0.05
    fitted_numbers = 1
    nodes, points = (0.5, 0.75, 1.0, 1.33, 2.0), 3
    remedy = "compare this number of the input; compute with another one, and compare the change"

    def __init__(
        self, label: str, described: str, change_scene: Callable[[Scene, float], Scene]
    ) -> None:
        self.label, self.described, self.change_scene = label, described, change_scene

    def changed(self, scene: Scene, size: float) -> Scene:
        """Return the scene with the mistake."""
        return self.change_scene(scene, size)

    def name_of(self, model: Model, setting: Setting, sizes: Sizes) -> str:
        """Return the name of the mistake at these sizes."""
        return self.label

    def sentence(self, model: Model, setting: Setting, sizes: Sizes) -> str:
        """Return what the error looks like, with its number, as a noun phrase."""
        return f"{self.described} of {sizes[0]:.4g} times ours"


def input_causes(model: Model) -> list[Cause]:
    """Return the mistakes in single numbers of the input that a scene may have."""
    scene, causes = model.comparison.scene, list[Cause]()
    is_large = scene.punch.table or len(scene.problem.ring_edges) > MAX_RINGS + 1
    materials = 0 if is_large else len(wear_values(scene))
    if 1 < materials <= MAX_MATERIALS:
        causes += [WearRatio(material) for material in range(materials)]
        causes.append(RingEdges())
    if 2 < materials <= MAX_MATERIALS:
        causes += map(ExchangedMaterials, combinations(range(materials), 2))
    layers = len(scene.half_space.layers)
    if 0 < layers <= MAX_LAYERS and model.flat:
        base = not scene.half_space.rigid
        for place in range(layers + base):
            causes += [LayerFactor(place, "youngs_modulus"), LayerPoissonsRatio(place)]
        causes += [LayerFactor(place, "thickness") for place in range(layers)]
        for places in combinations(range(layers + base), 2):
            keys = ("youngs_modulus", "poisson_ratio")
            causes += [SwappedLayers(places, keys), SwappedLayers(places, keys[:1])]
    if not model.flat and not layers:
        causes += _shaped_punch_inputs(scene)
    return causes


def _shaped_punch_inputs(scene: Scene) -> list[Cause]:
    """Return mistakes in the load, the modulus and the shape of a punch that is not flat."""
    causes = list[Cause]()
    if isinstance(scene.load_.normal_force, float):
        causes.append(ShapedPunchInput("normal force", "a load", _with_load))
    if scene.half_space.punch_youngs_modulus is None:
        words = "a modulus of the half-space"
        causes.append(ShapedPunchInput("modulus", words, _with_modulus))
    if _curvature_keys(scene):
        words = "a radius of curvature of the punch"
        causes.append(ShapedPunchInput("radius of curvature", words, _with_curvature))
    return causes


def _with_load(scene: Scene, size: float) -> Scene:
    """Return a scene with its load multiplied."""
    force = scene.load_.normal_force
    assert isinstance(force, float)  # because `_shaped_punch_inputs` has checked it
    return scene.changed(load__normal_force=force * size)


def _with_modulus(scene: Scene, size: float) -> Scene:
    """Return a scene with the modulus of the half-space multiplied."""
    return scene.changed(half_space__plane_strain_modulus=scene.half_space.own_modulus * size)


def _with_curvature(scene: Scene, size: float) -> Scene:
    """Return a scene with the radius of curvature of the punch multiplied."""
    (key,) = _curvature_keys(scene)
    radius: float = getattr(scene.punch.profile, key)
    return scene.changed({f"punch.profile.{key}": radius * size})


def _curvature_keys(scene: Scene) -> list[str]:
    """Return the key of the radius of curvature of the punch, if it has one."""
    return [key for key in ("curvature_radius", "ball_radius") if hasattr(scene.punch.profile, key)]


def described(model: Model, place: int) -> str:
    """Return words for a layer, or for the base below the layers."""
    layers = len(model.comparison.scene.half_space.layers)
    return f"layer {place + 1}" if place < layers else "the base below the layers"


def ring_wear(scene: Scene) -> list[float]:
    """Return the wear coefficient of each ring of a scene."""
    rings = len(scene.problem.ring_edges) - 1
    return [float(each) for each in np.resize(scene.punch.coefficients, rings)]


def wear_values(scene: Scene) -> list[float]:
    """Return the distinct wear coefficients of a scene, in increasing order."""
    return sorted(set(ring_wear(scene)))


def layer_tables(scene: Scene) -> list[dict[str, float]]:
    """Return the tables of the layers of a scene and, last, of the base."""
    ground = scene.half_space
    below = {"thickness": 1.0, "poisson_ratio": ground.poisson_ratio}
    if not ground.rigid:
        below["youngs_modulus"] = ground.youngs_modulus or (
            (ground.plane_strain_modulus or 0.0) * (1 - ground.poisson_ratio**2)
        )
    return [*(layer.model_dump() for layer in ground.layers), below]


def with_layers(scene: Scene, materials: list[dict[str, float]]) -> Scene:
    """Return a scene with other layers and another base: `layer_tables`."""
    *layers, base = materials
    changes: dict[str, object] = {"half_space.layers": layers}
    if not scene.half_space.rigid:
        changes["half_space.youngs_modulus"] = base["youngs_modulus"]
        changes["half_space.poisson_ratio"] = base["poisson_ratio"]
    return scene.changed(changes)
