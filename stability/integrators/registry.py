"""Where each integrator is, by name: a list that a command can read without any library."""

PLACES = {
    "heyoka": "taylor",
    "dop853": "scipy_methods",
    "lsoda": "scipy_methods",
    "radau": "scipy_methods",
    "bdf": "scipy_methods",
    "cvodes": "sundials",
    "idas": "sundials",
}
"""Module of each integrator, whose `INTEGRATORS` holds its record."""
