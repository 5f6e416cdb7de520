"""What people do with it.

Scenes, contact and wear on any compliance, runs, studies, figures, the command line.
"""
