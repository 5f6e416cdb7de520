"""The likelihood of measurements, confidence intervals, and tests of the residuals of a fit."""
