"""Roots of a family's equations: found at one point, followed to another, and where they meet.

Every module here reads a family's graph, and none knows `Family`, which calls them.
May import `algebra`, `base` and the graph of a family.
To add a way to follow members: write one function of a graph; `members` chooses among them.
"""
