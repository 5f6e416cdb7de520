"""The methods: each one computes a `Solution` from a `Problem`.

- `base.py`: what a method has to provide, and the `Solution` that it returns
- `mdr.py`, `bem.py`, `fem.py`: methods that compute a compliance; `pipeline.py` does the rest for
  all three
- `direct.py`, `mdr_grid.py`: the steady state in closed form, and the algorithm of the paper
- `spaces.py`: the pressure spaces; element sizes come from `studies/crosscheck/sizes/`

Where an error estimate is made: `estimates.estimate_errors` takes the difference between the
results of a fine and a coarser discretisation. `Evaluation.estimate` (in `evaluation.py` and
`moving_evaluation.py`) multiplies it by a factor and raises it to a floor. All factors and floors
are in `error_factors.py`.
"""
