"""What a command is about: a body of revolution, or a system of one's own, named by an option.

May import `cli/options.py` and the floors below.
To add a named body: its function in `NAMED` of `bodies/round_body/shapes/named.py`; its arguments
become options here.
"""
