"""Names of the methods.

A method is a file with an object ``METHOD`` (`studies/crosscheck/methods/base.py`), imported at its
first use.
"""

METHODS = ("mdr", "mdr-grid", "bem", "direct", "fem")
