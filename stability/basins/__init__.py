"""Which launch ends where: outcomes over starts and parameters, their borders and statistics.

Imports motion and jobs, and is read by figures, the atlas and the command line.
"""
