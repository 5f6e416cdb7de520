"""Scenes, contact and wear on any compliance, runs, studies, figures and the command line."""

import time

# time of the first import in ns since the epoch: a file edited later may have been loaded before
STARTED = time.time_ns()
