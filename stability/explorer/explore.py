"""`explore`: a stability diagram alive, as a page of its own or in a notebook."""

from __future__ import annotations

import os
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from ..base.checks import flag, instance, overwriting
from ..base.citation import cited
from ..base.errors import ParameterError
from ..base.types import Overwrite
from ..bodies.contact_laws import Contact
from ..bodies.disk import Disk
from ..bodies.round_body.body import Body
from ..storage.files import write_file
from ..storage.origin import origin_of
from ..storage.targets import check_suffix, check_target
from ..systems.family import Family
from .page import axis_of, page, widget
from .round_page import round_page
from .system_page import system_page

ENDINGS = (".html",)
"""Endings of the file."""


def explore(
    family: str | Family = "spinning",
    *,
    at: float | None = None,
    contact: Contact | type[Contact] | str | None = None,
    disk: Disk | None = None,
    body: Body | Disk | None = None,
    x: Any = None,
    y: Any = None,
    positive: Sequence[str] = (),
    pole: Any = None,
    theta: float | None = None,
    out: str | os.PathLike[str] | None = None,
    certify: bool = True,
    overwrite: Overwrite = False,
    **parameters: Any,
) -> Any:
    """A stability diagram to explore: a page in one file, or a widget in a notebook.

    The page shows every disk family under every stored law, or one family of a user's system.  A
    reader moves the point and the parameters, and sees eigenvalues, verdict and proof, modes and
    launches, all computed in the page.

    Parameters
    ----------
    family
        Family shown at first, rolling, spinning or tumbling; or a `Family` of your own whose
        stability conditions are polynomials in its parameters.  Its launches have a curve of the
        energy where the system has an observable named `energy`, as `mechanics` gives it.
    at
        Member that is shown at first; for the disk omega3, phi_dot [√(g/R)] or theta [rad].  As
        in every other call, numbers are in SI units where the body has a mass, length or gravity.
    contact
        Contact law that is shown at first: a law, its class or its name; viscous when left out.
    disk
        The body that is shown at first.  With m = R = g = 1 only its k is used; otherwise the
        page shows SI units (rad/s, 1/s, s/m, s, J, N), and a switch to dimensionless ones.
    body
        A `Body` in place of the disk, whose numbers become sliders: rolling, spinning, tumbling
        and, where it is smooth at a pole, vertical spin.  Its units are those of a disk.  A `Disk`
        here is the same as there.
    x, y
        Axes at first as (name, low, high), or (name, low, high, "log").
    positive
        Quantities of a family of your own that are positive, which makes its conditions shorter.
    pole
        0 or "pi": the inclination of vertical spin that is shown at first.
    theta
        Inclination near that of rolling, of a body that rolls at several [rad].
    out
        File to write, ending in `.html`; a widget is returned when left out.
    certify
        Whether the page carries rectangles on which verdicts are proved.
    overwrite
        Whether an existing file may be replaced; "same": if the same call wrote it.
    **parameters
        Parameters of a law that is named, such as `mu` [1/√(gR)]; of a family of your own, values
        by name.

    Returns
    -------
    Path or widget
        The file, or an object that a notebook shows.

    Raises
    ------
    StabilityError
        In one sentence, if a name, a number or the file is not accepted, or a package is missing
        that the widget needs.

    Source: verdicts, eigenvalues and motions of the page are compared with those of the package in
    tests/explorer.

    Examples
    --------
    >>> from pathlib import Path
    >>> import tempfile, stability as st
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     path = st.explore("spinning", mu=0.3, out=Path(folder) / "page.html")
    ...     path.stat().st_size < 1_500_000
    True
    """
    certify, overwrite = flag("certify", certify), overwriting(overwrite)
    if out is not None:
        check_suffix(out, ENDINGS)
        check_target(out, overwrite=overwrite)
    axes = axis_of(x, "x"), axis_of(y, "y")
    if isinstance(family, Family):
        others = {"contact": contact, "disk": disk, "body": body, "pole": pole, "theta": theta}
        for name, value in others.items():
            if value is not None:
                raise ParameterError(
                    f"{name} belongs to a disk or body; leave it out for your own family."
                )
        system_name = family.system.name
        contents = system_page(family, at, axes, positive, parameters, certify=certify)
    else:
        system_name = ""
        moving = _body(disk, body)
        where = {"pole": pole, "theta": theta}
        contents = round_page(
            moving, family, at, contact, axes, parameters, certify=certify, **where
        )
    data = contents.data(axes)
    if out is None:
        return widget(data)
    text = page(data, contents.title)
    keys = cited(model=not system_name, system=system_name, proofs=certify)
    origin = origin_of("explore", parameters | {"at": at, "contents": text}, keys)
    write_file(out, text, overwrite=overwrite, origin=origin)
    return Path(out)


def _body(disk: Any, body: Any) -> Disk | Body:
    """The body of a call; the uniform disk where none is given."""
    if disk is not None and body is not None:
        raise ParameterError("body and disk are both given; give one of them.")
    if body is None:
        return instance("disk", Disk() if disk is None else disk, Disk, "give a stability.Disk")
    remedy = "give a stability.Body or a stability.Disk"
    moving: Disk | Body = instance("body", body, (Disk, Body), remedy)  # type: ignore[arg-type]
    return moving
