"""The likelihood of measurements, intervals by it, and tests of what a fit leaves."""
