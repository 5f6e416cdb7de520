"""The core: a scene is solved by several methods, and judged.

Rooms, from below: `problem/` and `scene/` (what a user writes, and its problem without
units), `sizes/` of elements, `wear/` (contact and wear), `methods/`, `anchors/` (closed
forms and balances), `verdict/` (agreement, and what is not promised), and `result/` (runs,
and what they give).

The names in `__init__.pyi` are public: the applications in `studies/` import these, as a user's own
script imports them from `ringwear`. Each is loaded at its first use. Those of `meshes`, `mdr` and
`fem`, such as pressure spaces, compliances and the half-space by finite elements, are public there.

A scene, and its result
-----------------------
`Scene`, `Source`
    a scene, and what is accepted as one: a Scene, a name, a file, a table
`run`, `plan_run`
    compute a scene by its methods; predict sizes and cost of that
`Result`, `load`
    the result of a run, and reading it from the folder that it was saved to
`begun`, `judged`
    solve a scene by methods that can; the result of solutions

Quantities, and differences of results
--------------------------------------
`QUANTITIES`, `ANSWER`, `FIELDS`
    definitions of histories and states; of the numbers of the answer; names of fields
`error_name`, `UnitNames`
    the name of an estimate; names of the units of a scene
`Results`, `differences`
    values by quantity; relative differences of two of these

The problem without units
-------------------------
`Problem`, `Rings`, `InitialProfile`, `Loading`
    a problem, and its parts: rings, unworn face, load over time

Methods
-------
`METHODS`, `method`
    names of the bundled methods, and the method of a name
`Method`, `ComplianceMethod`, `Discretised`, `Solution`
    a method, one that only computes a compliance, what it discretises, and its solution
`pressure_spaces`, `Stages`, `LOG`
    the space that resolves a problem, and a coarser one; seconds of a method by stage; the logger

Contact and wear
----------------
`press_flat`, `moments`, `Load`
    a pressed flat punch; integrals of a face; force or depth
`WearingPunch`, `evolve`, `evolve_in_equal_steps`, `RunningIn`
    a punch that wears; its wear while contact opens and spreads; wear in full contact

Files and messages
------------------
`output_folder`, `write_numbers`
    a folder that has all files of a command, or none; the numbers of a result as files
`naming_arguments`, `did_you_mean`, `shown`
    refuse unknown arguments of a call; suggest a name; a value in a message
"""

import lazy_loader as _lazy

# the names in the stub `__init__.pyi`; the file of a name is loaded at its first use
__getattr__, __dir__, __all__ = _lazy.attach_stub(__name__, __file__)
