"""What a launch of a body of revolution settles on: its families, and its states along fixed axes.

May import what `settling` may, and `settling`.
To add a family: a record in `bodies/round_body/families.py`, and its line in `families.py` here.
"""
