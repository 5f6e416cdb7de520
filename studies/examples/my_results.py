"""My finite-element model: how large its errors are, and which mistakes explain them.

The table is from a model of five rings in which the modulus was entered wrongly: E = 1 in place of
the plane strain modulus E* = 1, with Poisson's ratio 0.3.
"""

from pandas import DataFrame

from ringwear import check

mine = DataFrame({"time": [0.0, 0.1, 0.5, 2.0], "indentation": [0.910, 1.043, 1.456, 2.953]})
checked = check("five_rings", {"my model": mine}, methods=["mdr"])
print(checked.errors[["time", "quantity", "error"]].round(3).to_string(index=False))
print(checked.mistakes()[0].words)
