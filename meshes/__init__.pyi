from . import bisection as bisection, files as files, structured as structured
from .compliance import (
    Compliance as Compliance,
)
from .contact_cells import (
    ContactCells as ContactCells,
)
from .decks import (
    deck_blocks as deck_blocks,
)
from .errors import (
    MeshError as MeshError,
    RingwearError as RingwearError,
    SceneError as SceneError,
    SolverError as SolverError,
)
from .files import (
    read_with_meshio as read_with_meshio,
)
from .ground.ground import (
    HALF_SPACE as HALF_SPACE,
    Ground as Ground,
)
from .ground.line_energy import (
    relative_stiffness as relative_stiffness,
)
from .half_space import (
    as_half_space as as_half_space,
    contact_facets as contact_facets,
    contact_radii as contact_radii,
    facet_ends as facet_ends,
    halved as halved,
    quality as quality,
    truncation as truncation,
    without_low_parts as without_low_parts,
)
from .pressure_space import (
    BandedCholesky as BandedCholesky,
    PressureSpace as PressureSpace,
)
from .radial import (
    Array as Array,
    Indices as Indices,
    alternating_edges as alternating_edges,
    from_axis as from_axis,
    gauss as gauss,
    graded_breakpoints as graded_breakpoints,
    ring_areas as ring_areas,
    ring_of as ring_of,
)
from .sizes import (
    FAR_TRUNCATION as FAR_TRUNCATION,
    SizeField as SizeField,
)
