from . import direct as direct, energy as energy, ring_kernel as ring_kernel
from .flat_punch import (
    D0 as D0,
    P0 as P0,
    flat_punch_of as flat_punch_of,
)
from .transforms import (
    line_density as line_density,
)
from .uniform_grid import (
    UniformGrid as UniformGrid,
)
