"""What a disk settles on: its families of steady motions that one number names.

Stable rolling of a slipping disk drifts (`stability.drift`), so no motion settles on it.
tests/settling/test_settling.py continues launches from the state that counts as settled.
"""

from __future__ import annotations

from functools import lru_cache

import casadi as ca

from ..bodies.contact import Contact
from ..bodies.families import SteadyFamily, lines_under
from ..bodies.newton_euler import STATES
from ..bodies.thin_disk import disk_system
from .line import Line, idle_under, signed
from .settling import Settling

DRIFTS = "{} with slip drifts on its centre manifold (stability.drift): not settled"


def disk_settling(law: type[Contact]) -> Settling:
    """The families that the disk may settle on under a contact law, each built once.

    Parameters
    ----------
    law
        Class of the law.

    Returns
    -------
    Settling
        Its second argument `p` has the inertia factor first.
    """
    records = sorted(lines_under(law.name), key=lambda record: record.name)  # for equal distances
    return Settling(tuple(_line(law, record) for record in records))  # type: ignore[arg-type]  # a class is hashable


@lru_cache(maxsize=64)
def _line(law: type[Contact], family: SteadyFamily) -> Line:
    system = disk_system(law)
    seen, y, sign = system.observables, ca.SX.sym("y"), ca.SX.sym("sign")
    return Line(
        family.name,
        system,
        STATES,
        family.at,
        family.member(ca, y, system.p[0], sign),
        y,
        ca.vertcat(sign, system.p),
        signed,
        (seen["normal_force"], seen["determinant"], ca.sin(system.x[0])),
        idle=idle_under(law),
        reason=DRIFTS.format(family.name) if family.drifts else "",
        call={"family": family.name},
    )
