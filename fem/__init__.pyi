from .contact_meshes import (
    TRIANGLE_GROWTH as TRIANGLE_GROWTH,
    even_half_space as even_half_space,
)
from .elasticity import (
    AxisymmetricElasticity as AxisymmetricElasticity,
)
from .elements import (
    degree_along_side as degree_along_side,
    is_on_quadrilaterals as is_on_quadrilaterals,
)
from .error_indicator import (
    fewest_with_share as fewest_with_share,
    squared_indicators as squared_indicators,
)
from .far_field import (
    enough_poles as enough_poles,
)
from .half_space import (
    HalfSpace as HalfSpace,
    contact_breakpoints as contact_breakpoints,
    pressure_space as pressure_space,
)
from .stresses import (
    stresses_in as stresses_in,
)
from .weak_form import (
    element_of_degree as element_of_degree,
)
