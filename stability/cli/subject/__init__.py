"""What a command is about: a body of revolution, or a system of one's own, named by an option.

May import `cli/options.py` and the floors below.
"""
