"""What people do with it.

Scenes, contact and wear on any compliance, runs, studies, figures, the command line.
"""

import time

# nanoseconds since the epoch: files that are edited later may be loaded as they were before
STARTED = time.time_ns()
