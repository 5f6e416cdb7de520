"""What people do with it: scenes, contact and wear on any compliance, runs, studies, figures, the command line."""
