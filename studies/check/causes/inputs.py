"""Mistakes in single numbers of the input, which are predicted by solving the changed scene.

Wear coefficients and edges of rings, and materials of layers, change the history in ways that no
scaling describes. On punches that are not flat, this is also so for the load, the modulus and the
shape. The changed scene is solved for some sizes of a mistake, and interpolated between them.
"""

from abc import abstractmethod
from collections.abc import Callable
from itertools import combinations
from typing import Any, ClassVar

import numpy as np

from ...scene.scene import Scene
from .cause import Cause, Sizes
from .model import Model
from .setting import SceneChange, Setting

# greatest number of wear coefficients, and of layers, of which each is considered
MAX_MATERIALS, MAX_LAYERS = 5, 3


class WrongInput(Cause):
    """A number of the input is wrong by a factor, or something in it is exchanged.

    Attributes
    ----------
    nodes : factors for which the changed scene is solved, between them it is interpolated; empty if
        the candidates are the only sizes
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
        return bool((model.times > 0).any())

    def changed(self, scene: Scene, size: float) -> Scene:
        """Return the scene with the mistake."""
        value = wear_values(scene)[self.material]
        factors = [size if each == value else 1.0 for each in ring_wear(scene)]
        wear = np.multiply(ring_wear(scene), factors)
        return scene.changed(punch__wear_coefficients=wear.tolist())

    def sentence(self, model: Model, setting: Setting, sizes: Sizes) -> str:
        """Return what the error looks like, with its number, as a noun phrase."""
        value = wear_values(model.comparison.scene)[self.material]
        return (
            f"a wrong ratio of wear coefficients: that of the material with k = {value:.4g} is "
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
        return bool((model.times > 0).any()) and len(edges) > 2 and space

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
        return bool((model.times > 0).any())

    def changed(self, scene: Scene, size: float) -> Scene:
        """Return the scene with the mistake."""
        first, second = (wear_values(scene)[material] for material in self.materials)
        exchanged = {first: second, second: first}
        wear = [exchanged.get(value, value) for value in ring_wear(scene)]
        return scene.changed(punch__wear_coefficients=wear)

    def sentence(self, model: Model, setting: Setting, sizes: Sizes) -> str:
        """Return what the error looks like, with its number, as a noun phrase."""
        values = wear_values(model.comparison.scene)
        first, second = (values[material] for material in self.materials)
        return f"swapped wear coefficients of two materials, {first:.4g} and {second:.4g}"


class LayerInput(WrongInput):
    """A number of one layer, or of the base below the layers, is wrong.

    Parameters
    ----------
    place : index of the layer from the surface down; one more than the last is the base
    """

    group = "ground"

    def __init__(self, place: int) -> None:
        self.place = place

    def applies(self, model: Model) -> bool:
        """Return whether the mistake could be recognised in these results."""
        return model.flat

    def described(self, model: Model) -> str:
        """Return words for the layer or the base."""
        layers = model.comparison.scene.half_space.layers
        return (
            f"layer {self.place + 1}" if self.place < len(layers) else "the base below the layers"
        )

    def changed(self, scene: Scene, size: float) -> Scene:
        """Return the scene with the mistake."""
        materials = layer_tables(scene)
        self.alter(materials[self.place], size)
        return with_layers(scene, materials)

    def alter(self, material: dict[str, float], size: float) -> None:
        """Put the mistake into the table of a layer."""
        raise NotImplementedError


class LayerModulus(LayerInput):
    """The modulus of a layer or of the base is wrong."""

    name = "modulus of a layer"
    searched, fitted_numbers = True, 1
    prior = 0.04
    nodes = (0.2, 0.45, 1.0, 2.2, 5.0)
    remedy = "compare Young's modulus of each layer"

    def alter(self, material: dict[str, float], size: float) -> None:
        """Put the mistake into the table of a layer."""
        material["youngs_modulus"] *= size

    def sentence(self, model: Model, setting: Setting, sizes: Sizes) -> str:
        """Return what the error looks like, with its number, as a noun phrase."""
        return f"a modulus of {self.described(model)} of {sizes[0]:.4g} times ours"


class LayerThickness(LayerInput):
    """The thickness of a layer is wrong."""

    name = "thickness of a layer"
    searched, fitted_numbers = True, 1
    prior = 0.04
    nodes = (0.35, 0.6, 1.0, 1.7, 2.9)
    remedy = "compare the thickness of each layer"

    def alter(self, material: dict[str, float], size: float) -> None:
        """Put the mistake into the table of a layer."""
        material["thickness"] *= size

    def sentence(self, model: Model, setting: Setting, sizes: Sizes) -> str:
        """Return what the error looks like, with its number, as a noun phrase."""
        return f"a thickness of {self.described(model)} of {sizes[0]:.4g} times ours"


class LayerPoissonsRatio(LayerInput):
    """Poisson's ratio of a layer or of the base is wrong."""

    name = "Poisson's ratio of a layer"
    fitted_numbers = 1
    prior = 0.05
    remedy = "compare Poisson's ratio of each layer"
    ratios = (0.0, 0.1, 0.2, 0.3, 0.4, 0.45, 0.49)

    def candidates(self, model: Model) -> list[Sizes]:
        """Return the sizes to try or to begin a search at."""
        ratio = layer_tables(model.comparison.scene)[self.place]["poisson_ratio"]
        return [(each,) for each in self.ratios if abs(each - ratio) > 0.005]

    def alter(self, material: dict[str, float], size: float) -> None:
        """Put the mistake into the table of a layer."""
        material["poisson_ratio"] = size

    def sentence(self, model: Model, setting: Setting, sizes: Sizes) -> str:
        """Return what the error looks like, with its number, as a noun phrase."""
        return f"a Poisson's ratio of {self.described(model)} of about {sizes[0]:.2g}"


class SwappedLayers(LayerInput):
    """Materials, or only the moduli, of a layer and of what is below it are exchanged.

    Parameters
    ----------
    keys : of the numbers that are exchanged
    """

    name = "swapped layers"
    prior = 0.04
    remedy = "compare the material of the model at each depth with the layers of the scene"

    def __init__(self, place: int, keys: tuple[str, ...]) -> None:
        super().__init__(place)
        self.keys = keys

    def changed(self, scene: Scene, size: float) -> Scene:
        """Return the scene with the mistake."""
        materials = layer_tables(scene)
        upper, lower = materials[self.place : self.place + 2]
        for key in self.keys:
            upper[key], lower[key] = lower[key], upper[key]
        return with_layers(scene, materials)

    def sentence(self, model: Model, setting: Setting, sizes: Sizes) -> str:
        """Return what the error looks like, with its number, as a noun phrase."""
        below = (
            "the base" if self.place + 1 == len(model.comparison.scene.half_space.layers) else ""
        )
        what = "moduli" if len(self.keys) == 1 else "materials"
        return f"swapped {what} of layer {self.place + 1} and {below or f'layer {self.place + 2}'}"


class ShapedPunchInput(WrongInput):
    """A number of a scene with a punch that is not flat is wrong.

    Parameters
    ----------
    name : of the mistake
    described : what is multiplied, in words
    change_scene : returns the scene with this number multiplied by a factor
    """

    name = "input"
    group, searched = "ground", True
    prior = 0.05
    fitted_numbers = 1
    nodes, points = (0.5, 0.7, 0.85, 1.0, 1.18, 1.43, 2.0), 3
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
    materials = 0 if scene.punch.table else len(wear_values(scene))
    if 1 < materials <= MAX_MATERIALS:
        causes += [WearRatio(material) for material in range(materials)]
        causes.append(RingEdges())
    if 2 < materials <= MAX_MATERIALS:
        causes += map(ExchangedMaterials, combinations(range(materials), 2))
    layers = len(scene.half_space.layers)
    if 0 < layers <= MAX_LAYERS and model.flat:
        base = not scene.half_space.rigid
        for place in range(layers + base):
            causes += [LayerModulus(place), LayerPoissonsRatio(place)]
        causes += [LayerThickness(place) for place in range(layers)]
        for place in range(layers + base - 1):
            keys = ("youngs_modulus", "poisson_ratio")
            causes += [SwappedLayers(place, keys), SwappedLayers(place, keys[:1])]
    if not model.flat and not layers:
        causes += _shaped_punch_inputs(scene)
    return causes


def _shaped_punch_inputs(scene: Scene) -> list[Cause]:
    """Return mistakes in the load, the modulus and the shape of a punch that is not flat."""
    causes = list[Cause]()
    force, ground, profile = scene.load_.normal_force, scene.half_space, scene.punch.profile
    if isinstance(force, float):
        causes.append(
            ShapedPunchInput(
                "normal force",
                "a load",
                lambda scene, size: scene.changed(load__normal_force=force * size),
            )
        )
    if ground.punch_youngs_modulus is None:
        modulus = ground.own_modulus
        causes.append(
            ShapedPunchInput(
                "modulus",
                "a modulus of the half-space",
                lambda scene, size: scene.changed(half_space__plane_strain_modulus=modulus * size),
            )
        )
    for key in ("curvature_radius", "ball_radius"):
        if (radius := getattr(profile, key, None)) is not None:
            causes.append(
                ShapedPunchInput(
                    "radius of curvature",
                    "a radius of curvature of the punch",
                    lambda scene, size, key=key, radius=radius: scene.changed(
                        {f"punch.profile.{key}": radius * size}
                    ),
                )
            )
    return causes


def ring_wear(scene: Scene) -> list[float]:
    """Return the wear coefficient of each ring of a scene."""
    rings = len(scene.problem.ring_edges) - 1
    return [float(each) for each in np.resize(scene.punch.coefficients, rings)]


def wear_values(scene: Scene) -> list[float]:
    """Return the distinct wear coefficients of a scene, in increasing order."""
    return sorted(set(ring_wear(scene)))


def layer_tables(scene: Scene) -> list[dict[str, Any]]:
    """Return the tables of the layers of a scene and, last, of the base."""
    ground = scene.half_space
    below = {"thickness": 1.0, "poisson_ratio": ground.poisson_ratio}
    if not ground.rigid:
        below["youngs_modulus"] = ground.youngs_modulus or (
            (ground.plane_strain_modulus or 0.0) * (1 - ground.poisson_ratio**2)
        )
    return [*(layer.model_dump() for layer in ground.layers), below]


def with_layers(scene: Scene, materials: list[dict[str, Any]]) -> Scene:
    """Return a scene with other layers and another base: `layer_tables`."""
    *layers, base = materials
    changes: dict[str, Any] = {"half_space.layers": layers}
    if not scene.half_space.rigid:
        changes["half_space.youngs_modulus"] = base["youngs_modulus"]
        changes["half_space.poisson_ratio"] = base["poisson_ratio"]
    return scene.changed(changes)
