from .fem import (
    even_half_space as even_half_space,
)
from .mdr import (
    direct as direct,
    energy as energy,
    ring_kernel as ring_kernel,
)
from .meshes import (
    Compliance as Compliance,
    ContactCells as ContactCells,
    Ground as Ground,
    MeshError as MeshError,
    PressureSpace as PressureSpace,
    RingwearError as RingwearError,
    SceneError as SceneError,
    SizeField as SizeField,
    SolverError as SolverError,
    alternating_edges as alternating_edges,
    bisection as bisection,
    ring_areas as ring_areas,
)
from .studies.check.check import (
    Check as Check,
    check as check,
)
from .studies.cli import (
    main as main,
)
from .studies.comparison import (
    Comparison as Comparison,
    compare as compare,
)
from .studies.crosscheck import (
    ComplianceMethod as ComplianceMethod,
    Discretised as Discretised,
    InitialProfile as InitialProfile,
    Load as Load,
    Loading as Loading,
    Method as Method,
    Problem as Problem,
    Result as Result,
    Rings as Rings,
    RunningIn as RunningIn,
    Scene as Scene,
    Solution as Solution,
    Stages as Stages,
    WearingPunch as WearingPunch,
    differences as differences,
    evolve as evolve,
    evolve_in_equal_steps as evolve_in_equal_steps,
    load as load,
    method as method,
    moments as moments,
    press_flat as press_flat,
    pressure_spaces as pressure_spaces,
    run as run,
)
from .studies.decks.deck import (
    deck as deck,
)
from .studies.fit.fit import (
    fit as fit,
)
from .studies.named_studies import (
    study as study,
)
from .studies.operators import (
    compare_operators as compare_operators,
)
from .studies.study.orders import (
    orders as orders,
)
from .studies.study.study import (
    Study as Study,
)
from .studies.sweep.sweep import (
    sweep as sweep,
)
from .studies.wear_step.plan import (
    plan as plan,
)

__version__: str
