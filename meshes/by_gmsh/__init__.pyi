from . import quads as quads, triangles as triangles
from .outline import (
    truncation_with_interfaces as truncation_with_interfaces,
)
from .quads import (
    graded as graded,
)
from .session import (
    unavailable as unavailable,
)
