"""The methods by name, and what tells of an interruption. Nothing is imported until it is used.

A method is a file with an object ``METHOD`` (`studies/methods/base.py`).
"""

METHODS = ("mdr", "mdr-grid", "bem", "direct", "fem")
INTERRUPTED = "INTERRUPTED: tables and figures hold the rows that were finished."
