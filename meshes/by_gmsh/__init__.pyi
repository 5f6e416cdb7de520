from . import quads as quads, triangles as triangles
from .outline import (
    truncation_with_interfaces as truncation_with_interfaces,
)
from .quads import (
    GradedQuads as GradedQuads,
    graded as graded,
)
from .session import (
    first_that_succeeds as first_that_succeeds,
    unavailable as unavailable,
)
