"""The half-space in finite elements: axisymmetric elasticity, Lagrange multipliers, far field.

Its public names are in `__init__.pyi`.
"""

import lazy_loader as _lazy

# the names in the stub `__init__.pyi`; the file of a name is loaded at its first use
__getattr__, __dir__, __all__ = _lazy.attach_stub(__name__, __file__)
