"""Similarity of motions: bodies of one shape move alike where m, R and g set the units.

The dimensions of SI units, as powers of kg, m and s; nothing here is the package's.
"""

import math
import re

POWERS = {
    "1": (0, 0, 0),
    "rad": (0, 0, 0),
    "kg": (1, 0, 0),
    "m": (0, 1, 0),
    "s": (0, 0, 1),
    "N": (1, 1, -2),
    "J": (1, 2, -2),
    "W": (1, 2, -3),
}
"""Powers of kg, m and s in each unit."""


def powers(unit: str) -> tuple[int, ...]:
    """Powers of kg, m and s in a product or quotient of units, such as `m/s2`."""
    total = [0, 0, 0]
    above, _, below = unit.partition("/")
    for sign, part in ((1, above), (-1, below)):
        for word, digits in re.findall(r"([A-Za-z]+|1)(\d*)", part):
            for i, power in enumerate(POWERS[word]):
                total[i] += sign * power * int(digits or 1)
    return tuple(total)


def size(unit: str, mass: float, length: float, gravity: float) -> float:
    """How large a dimensionless 1 is in an SI unit."""
    in_mass, in_length, in_time = powers(unit)
    time = math.sqrt(length / gravity)
    return mass**in_mass * length**in_length * time**in_time
