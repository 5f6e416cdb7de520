"""Rank 500 designs of a punch by the rate at which they wear, by closed forms."""

from ringwear import sweep

designs = {"count": 500, "seed": 1, "punch.width_ratio": {"geomspace": [0.2, 5.0]}}
designs |= {"punch.wear_ratio": {"geomspace": [0.1, 10.0]}}
found = sweep("five_rings", random=designs, keep="steady_wear_rate", methods="direct")
ranked = found.squeeze("solver").sortby("steady_wear_rate").isel(draw=slice(5))
print(ranked.steady_wear_rate.to_dataframe()[["width_ratio", "wear_ratio", "steady_wear_rate"]])
