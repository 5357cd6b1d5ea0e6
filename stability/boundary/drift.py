"""Duration of straight rolling: the slow drift of tilt and spin to the linear threshold.

Under viscous friction straight rolling with omega3² > g/(2kR) is spectrally stable.  Yet a
leaning disk circles slowly with lateral slip, which costs energy.  On the centre manifold tilt and
spin obey dα/dt = a α³, dω₃/dt = b α².  The spin falls and the tilt grows until the threshold is
crossed.  The coefficients, the first integral and the time below are derived from the graph by
notebooks/proofs/centre_manifold.py; notebooks/rolling_drift.py and tests/boundary/test_drift.py
show this.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ..base.checks import checked, flag
from ..base.citation import MODEL
from ..base.errors import ParameterError, if_degrees, shown
from ..base.printing import html_table, in_short
from ..base.quantities import Kind, behind
from ..base.types import Floats, Record
from ..bodies.contact_laws import Contact, LinearViscous, Viscous, law_missing, law_only
from ..bodies.disk import Disk
from ..bodies.disk_polynomials import stored
from ..spectra.problem import disk_problem

FORMULAS = {
    "threshold": "omega3_c^2 = 1/(2 k)",
    "rate of tilt": "a = 1/(mu w^2 (2k+1)^3 (2 (2k+1) w^2 - 1)), d(tilt)/dt = a tilt^3",
    "rate of spin": "b = -1/(mu w (2k+1)^3), dw/dt = b tilt^2",
    "first integral": "tilt^2 (2 (2k+1) w^2 - 1)/w^2 = constant",
    "launch": "tilt on the slow manifold = tilt0 * 2 (2k+1) w0^2/(2 (2k+1) w0^2 - 1)",
    "time": "T = mu (2k+1)^3 w0^2/((2 (2k+1) w0^2 - 1) tilt^2) * "
    "((2k+1)(w0^2 - 1/(2k)) - log(w0 sqrt(2k)))",
}
"""Dimensionless, to leading order in the tilt (radians from upright); w is omega3."""


@dataclass(frozen=True, eq=False, repr=False)
class Drift(Record):
    """The slow passage of straight rolling to its linear threshold, to leading order in the tilt.

    The relative error of `time` is of the order of the tilt squared.

    Source: expansion on the centre manifold; simulations: tests/boundary/test_drift.py.

    Examples
    --------
    >>> import stability as st
    >>> d = st.drift(at=1.8, tilt=0.01, contact=st.Viscous(0.3))
    >>> round(d.threshold, 6), d.time > 1000
    (1.414214, True)
    """

    threshold: Any
    """omega3 at which spectral stability ends, shape (…) [rad/s]."""
    time: Any
    """Time until omega3 crosses the threshold, shape (…) [s]."""
    tilt_start: Any
    """Tilt on the slow manifold after the fast transient, shape (…) [rad]."""
    tilt_end: Any
    """Tilt on arrival at the threshold, shape (…) [rad]."""
    tilt_rate: Any
    """a in dα/dt = a α³ at the start, shape (…) [1/s]."""
    spin_rate: Any
    """b in dω₃/dt = b α² at the start, shape (…) [rad/s²]."""
    dimensionless: bool = field(default=True, kw_only=True, compare=False, repr=False)
    """Whether the disk has m = R = g = 1, so that numbers are in the units of these."""

    def __repr__(self) -> str:
        numbers = [f"{name} = {text}" for name, text in self._texts().items()]
        return f"<Drift of rolling: {', '.join(numbers)}>"

    def _repr_html_(self) -> str:
        return html_table("Drift of rolling", ["number", "value"], self._texts().items())

    def _texts(self) -> dict[str, str]:
        """Each number with its unit; of arrays the ends."""
        unit = partial(Kind.label, dimensionless=self.dimensionless)
        square = "g/R" if self.dimensionless else "rad/s²"
        units = {
            "threshold": unit(Kind.ANGULAR_VELOCITY),
            "time": unit(Kind.TIME),
            "tilt_start": "rad",
            "tilt_end": "rad",
            "tilt_rate": unit(Kind.GROWTH_RATE),
            "spin_rate": square,
        }
        return {n: f"{in_short(getattr(self, n))}{behind(u)}" for n, u in units.items()}

    @property
    def citation(self) -> str:
        """Keys of the works to cite: closed forms of the model, by which nothing is integrated."""
        return MODEL


def drift(
    *,
    at: ArrayLike,
    tilt: ArrayLike,
    disk: Disk | None = None,
    contact: Contact | type[Contact] | str | None = None,
    launch: bool = True,
    **parameters: ArrayLike,
) -> Drift:
    """Duration of spectrally stable rolling with a small tilt under viscous friction.

    Parameters
    ----------
    at
        Rolling velocity omega3 at the start, shape (…), beyond the threshold [rad/s].
    tilt
        Tilt theta - π/2 at the start, shape (…), small and not zero [rad]; the largest tilt, on the
        slow manifold or at the threshold, must stay below π/2.
    disk
        The body; the uniform disk with m = R = g = 1 when left out.
    contact
        `Viscous` or `LinearViscous`, or the name or class of one of them with its parameter by
        name, such as `contact="viscous", mu=0.3`.
    launch
        Whether the start is a launch with this tilt, phi_dot = 0 and no slip, after which a fast
        transient changes the tilt at first order.  Otherwise it lies on the slow manifold.
    **parameters
        Parameters of a law that is named.

    Returns
    -------
    Drift
        Times and tilts, in the shapes of the arguments.

    Raises
    ------
    ParameterError
        If the law has no friction, the start is not spectrally stable, or the tilt is zero or
        would reach π/2 on the way, where the disk lies flat.

    Source: tests/boundary/test_drift.py derives every formula and compares it with simulations.

    Examples
    --------
    >>> import stability as st
    >>> d = st.drift(at=[1.8, 3.0], tilt=0.02, contact=st.Viscous(1.0), launch=False)
    >>> d.time.round().tolist()
    [5075.0, 28471.0]
    """
    contact = law_only(contact, dict(parameters))
    if contact is None:
        raise law_missing({law.name: law for law in (Viscous, LinearViscous)})
    if not (isinstance(contact, (Viscous, LinearViscous)) and stored(type(contact))):
        raise ParameterError(
            f"contact is {shown(contact)}; drift needs a law with friction: Viscous(mu) or "
            "LinearViscous(c)."
        )
    launch = flag("launch", launch)
    if at is None:
        raise ParameterError("at is missing; it is omega3 at the start.")
    problem = disk_problem("rolling", Disk() if disk is None else disk, contact, at)
    values = dict(problem.values) | {"tilt": checked("tilt", tilt)}
    a, q, rate, shape = problem.arrays(values)
    w, k, mu = np.abs(a[:, 0]), q[:, 0], q[:, 1]
    lean = np.abs(np.broadcast_to(np.asarray(values["tilt"], dtype=float), shape).reshape(-1))
    if (lean == 0).any():
        raise ParameterError("tilt is 0; exactly upright rolling stays as it is, give a tilt.")
    if (lean >= np.pi / 2).any():
        most = float(lean.max())
        raise ParameterError(f"tilt is {most:g}; a small angle is needed{if_degrees(most)}.")
    with np.errstate(all="ignore"):  # an overflow is refused below
        result = _drift(w, k, mu, lean, rate, shape, launch)
    return replace(result, dimensionless=problem.dimensionless)


def _drift(
    w: Floats,
    k: Floats,
    mu: Floats,
    lean: Floats,
    rate: Floats,
    shape: tuple[int, ...],
    launch: bool,
) -> Drift:
    bad = 2 * k * w**2 <= 1
    if bad.any():
        limit = float((rate / np.sqrt(2 * k))[bad][0])
        raise ParameterError(
            f"at is {float((w * rate)[bad][0]):g}, not beyond the threshold omega3 = {limit:g} of "
            "spectral stability; there is nothing that could last."
        )
    some = 2 * (2 * k + 1) * w**2 - 1
    start = lean * (some + 1) / some if launch else lean
    spread = (2 * k + 1) * (w**2 - 1 / (2 * k)) - np.log(w * np.sqrt(2 * k))
    time = mu * (2 * k + 1) ** 3 * w**2 / (some * start**2) * spread
    end = start * np.sqrt(some / w**2 / (2 * k + 2))
    most = np.maximum(start, end)
    if (most >= np.pi / 2).any():
        worst = int(np.argmax(most))
        raise ParameterError(
            f"tilt is {lean[worst]:g}, and the slow drift would take it to {most[worst]:.3g}, past "
            "π/2, where the disk lies flat; the drift holds for small tilts: give a smaller one."
        )
    common = 1 / (mu * w * (2 * k + 1) ** 3)
    rates = common / (w * some) * rate, common * rate**2
    if not all(np.isfinite(v).all() and (v > 0).all() for v in (time / rate, end, *rates)):
        raise ParameterError(
            "the time or a rate of the drift leaves double precision; give values nearer to 1."
        )

    def shaped(value: Floats) -> Any:
        return float(value[0]) if not shape else value.reshape(shape)

    return Drift(
        shaped(rate / np.sqrt(2 * k)),
        shaped(time / rate),
        shaped(start),
        shaped(end),
        shaped(rates[0]),
        shaped(-rates[1]),
    )
