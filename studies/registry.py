"""Names of the methods, and the text about an interruption.

A method is a file with an object ``METHOD`` (`studies/methods/base.py`), imported at its first use.
"""

METHODS = ("mdr", "mdr-grid", "bem", "direct", "fem")
INTERRUPTED = "INTERRUPTED: tables and figures hold the rows that were finished."
