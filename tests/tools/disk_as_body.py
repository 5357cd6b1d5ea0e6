"""The thin disk as a user writes it: a `Body` of height sinθ."""

import casadi as ca

import stability as st


def disk_as_body(disk: st.Disk) -> st.Body:
    """A body with the height and the moments of a disk."""
    return st.Body(
        lambda theta, k: ca.sin(theta) + 0 * k,
        axial=lambda k: 2 * k,
        transverse=lambda k: k,
        mass=disk.mass,
        gravity=disk.gravity,
        length=disk.radius,
        shape={"k": disk.k},
        name="disk",
    )
