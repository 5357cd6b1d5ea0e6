"""`Spectrum`: eigenvalues with error discs, a verdict, and its reason.

A reader gets it as one line, as a table of HTML, and as a dataset with units and provenance.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ..algebra.eigensolver import EigenSolver, eigenpairs, lapack
from ..base.above import function_of
from ..base.citation import cited
from ..base.errors import ParameterError, StabilityError
from ..base.printing import html_table, in_brackets
from ..base.quantities import Kind, Quantity, behind, rate_unit
from ..base.types import Complexes, Floats, Record, fields_of
from ..base.verdict import BY_CODE, CODES, Nonlinear, Verdict
from ..polynomials.zero_blocks import most_power
from ..storage.text import csv_text
from ..systems.family import Family
from ..systems.structure.linearity import linear
from .deflation import MemberNumbers
from .eigenvalues import REASONS, Eigenpairs, Modes, lift, mode_labels, track
from .labels import axis_attributes, of_package, origin, rate_attributes, verdict_attributes

if TYPE_CHECKING:
    import xarray

    from ..bodies.contact_laws import Contact


TAKEN = ("eigenvalues", "error_radius", "abscissa", "abscissa_error", "verdict", "certified",
         "nonlinear", "label", "mode", "complex_part")  # fmt: skip
"""Names of variables and dimensions; a parameter with such a name is called `parameter_NAME`."""


def dimensions(values: Mapping[str, Any], shape: tuple[int, ...]) -> tuple[str, ...]:
    """Name of each axis: that of the one quantity given along it, or `point`.

    Parameters
    ----------
    values
        Value or array of each quantity by name.
    shape
        Shape to which they broadcast.

    Examples
    --------
    >>> dimensions({"at": np.ones((3, 1)), "mu": np.ones(4), "k": 0.25}, (3, 4))
    ('at', 'mu')
    >>> dimensions({"at": np.ones(3), "mu": np.ones(3)}, (3,))
    ('point',)
    """
    names = []
    for axis in range(len(shape)):
        along = [n for n, v in values.items() if _axes(v, shape) == (axis,)]
        further = f"_{axis}" if len(shape) > 1 else ""
        # an array over several axes is a coordinate of these, and names none
        names.append(_free(along[0]) if len(along) == 1 else f"point{further}")
    return tuple(names)


def _axes(value: Any, shape: tuple[int, ...]) -> tuple[int, ...]:
    """Axes of the common shape that a value has."""
    lengths = np.shape(value)
    if not lengths or len(lengths) > len(shape):
        return ()
    first = len(shape) - len(lengths)
    longer = [first + i for i, n in enumerate(lengths) if n > 1]
    return tuple(longer or ([first] if lengths == (1,) and shape[-1] == 1 else []))


def _free(name: str) -> str:
    return f"parameter_{name}" if name in TAKEN else name


def dataset(spectrum: Any) -> xarray.Dataset:
    """Eigenvalues, error discs, verdicts, labels of modes, and all that was given.

    Returns
    -------
    xarray.Dataset
    """
    import xarray

    shape, rates = spectrum.codes.shape, rate_attributes(spectrum)
    values = dict(spectrum.values)
    dims = dimensions(values, shape)
    every = (*dims, "mode")
    variables: dict[str, Any] = {
        "eigenvalues": (every, spectrum.eigenvalues, rates | {
            "long_name": "eigenvalues, structural zeros removed, sorted by real part"}),
        "error_radius": (every, spectrum.radius, rates | {
            "long_name": "radius of the error disc; all eigenvalues lie in the discs"}),
        "abscissa": (dims, np.asarray(spectrum.abscissa), rates | {
            "long_name": "largest growth rate"}),
        "abscissa_error": (dims, np.asarray(spectrum.abscissa_error), rates | {
            "long_name": "error bound of abscissa"}),
        "verdict": (dims, spectrum.codes, verdict_attributes()),
        "certified": (dims, np.asarray(spectrum.certified, dtype=np.int8), {
            "long_name": "whether the verdict is proved in rational arithmetic or balls",
            "flag_values": np.array([0, 1], dtype=np.int8), "flag_meanings": "no yes"}),
        "nonlinear": (dims, _places(spectrum.nonlinear), {
            "long_name": "behaviour of the nonlinear motion",
            "flag_values": np.arange(len(Nonlinear), dtype=np.int8),
            "flag_meanings": " ".join(behaviour.name.lower() for behaviour in Nonlinear),
            "sentences": " | ".join(behaviour.value for behaviour in Nonlinear)}),
        "label": (every, np.array(spectrum.modes.labels, dtype=object).reshape(
            spectrum.eigenvalues.shape), {"long_name": "mode in words: kind, leading states"}),
    }  # fmt: skip
    coordinates = {}
    for name, value in values.items():
        axes = _axes(value, shape)
        array = np.asarray(value, dtype=float)
        array = array.reshape([shape[i] for i in axes]) if array.ndim else array
        along = tuple(dims[i] for i in axes) if array.ndim else ()
        coordinates[_free(name)] = (along, array, axis_attributes(spectrum, name))
    fixed = {n: v for n, v in values.items() if np.ndim(v) == 0}
    return xarray.Dataset(variables, coordinates, origin(
        spectrum, fixed, citation=spectrum.citation,
        structural_zeros=int(spectrum.structural_zeros),
        method="eigenvalues of the linearisation with structural zeros removed through null "
        "vectors, error discs by running error analysis and Gershgorin's theorem; where certified, "
        "rational arithmetic or balls",
        tolerances="verdicts only where the error discs or a proof decide",
        note=str(spectrum.note),
    ))  # fmt: skip


def _places(sentences: Any) -> NDArray[np.int8]:
    """The place of each sentence in its enumeration."""
    codes = {behaviour: i for i, behaviour in enumerate(Nonlinear)}
    array = np.asarray(sentences, dtype=object)
    return np.array([codes[behaviour] for behaviour in array.ravel()], dtype=np.int8).reshape(
        array.shape
    )


MOST = 8
"""Most eigenvalues in one line; those that decay fastest are left out."""
LENGTHS = ("radius", "length")
"""Names of the unit of length of a disk and of a body."""
LONGEST = 60
"""Most rows of a table."""


def numbers(values: Complexes) -> list[str]:
    """Sorted eigenvalues as texts, a pair as one with ±.

    Examples
    --------
    >>> numbers(np.array([-2, -0.5 - 3j, -0.5 + 3j]))
    ['-2', '-0.5 ± 3i']
    """
    said, left = [], list(values)
    while left:
        value = left.pop(0)
        real, imag = f"{value.real + 0.0:.6g}", f"{abs(value.imag):.6g}i"
        if value.imag and left and left[0] == value.conjugate():
            left.pop(0)
            said.append(f"{real} ± {imag}")
        else:
            said.append(real + (f" {'+' if value.imag > 0 else '-'} {imag}" if value.imag else ""))
    return said


def counted(spectrum: Any) -> str:
    """How many points have which verdict."""
    words = Counter(verdict.word for verdict in spectrum.verdict.flat)
    return ", ".join(f"{count} {word}" for word, count in words.most_common())


def member(spectrum: Any) -> str:
    """Family parameters of a single spectrum by name, with their units."""
    pairs = zip(spectrum.family.at, np.asarray(spectrum.at), strict=True)
    return ", ".join(f"{n} = {v:.6g}{behind(_unit(spectrum, n))}" for n, v in pairs)


def _unit(spectrum: Any, name: str) -> str:
    """The unit of a number, in words where it is dimensionless."""
    system = spectrum.family.system
    quantity = system.quantities.get(name)
    if quantity is None:
        return str(system.units.get(name, "1"))
    return quantity.kind.label(dimensionless=spectrum.dimensionless)  # type: ignore[no-any-return]


def _law(spectrum: Any) -> str:
    """The contact law with its formula and numbers; empty for a user's system."""
    quantities = spectrum.family.system.quantities
    if not quantities:
        return ""
    law = spectrum.family.system.name.rpartition(", ")[2]
    values = {spectrum.family.meaning(n): v for n, v in spectrum.values.items()}
    formula, numbers = "", []
    for name, value in values.items():
        if name in quantities and quantities[name].formula:
            formula = f" ({spectrum.law.formula if spectrum.law else quantities[name].formula})"
            if np.ndim(value) == 0:
                numbers.append(f"{name} = {float(value):.6g}{behind(_unit(spectrum, name))}")
    return ", ".join([f"{law} contact{formula}", *numbers])


def of_body(spectrum: Any) -> str:
    """Every number of a spectrum of a body that is no array, with symbol and unit."""
    system = spectrum.family.system
    values = {spectrum.family.meaning(n): v for n, v in spectrum.values.items()}
    single = {n: float(v) for n, v in values.items() if np.ndim(v) == 0}
    single = {n: single[n] for n in (*spectrum.family.at, *single) if n in single}
    if spectrum.dimensionless:
        single = {n: v for n, v in single.items() if n not in ("mass", *LENGTHS, "gravity")}
    quantities = {n: Quantity(n, "", n, Kind.NUMBER) for n in single} | dict(system.quantities)
    return ", ".join(
        replace(quantities[n], formula="").value(v, dimensionless=spectrum.dimensionless)
        for n, v in single.items()
    )


def line(spectrum: Any) -> str:
    """The verdict and the eigenvalues of a spectrum, or the verdicts of its points, in one line."""
    shape, count = spectrum.eigenvalues.shape[:-1], spectrum.eigenvalues.shape[-1]
    unit = f" [{spectrum.rate_unit}]" if spectrum.rate_unit != "1" else ""
    number = f"{count} eigenvalue{'s' * (count != 1)}"
    law = f", {contact}" if (contact := _law(spectrum)) else ""
    if not shape:
        said = numbers(spectrum.eigenvalues)
        verdict = ": ".join(filter(None, [spectrum.verdict.word, spectrum.growth()]))
        more = "…, " * (len(said) > MOST)
        tail = f"{number}{unit}: {more}{', '.join(said[-MOST:])}" if said else number
        there = f" at {where}" if (where := member(spectrum)) else ""
        return f"<Spectrum of {spectrum.family.name}{there}{law}: {verdict}; {tail}>"
    what = f"{' x '.join(map(str, shape))} points{law}"
    rates = ""
    if spectrum.codes.size and count:
        low, high = np.min(spectrum.abscissa), np.max(spectrum.abscissa)
        rates = f"; {number} each, the largest real part from {low:.4g} to {high:.4g}{unit}"
    return f"<Spectrum of {spectrum.family.name}, {what}: {counted(spectrum)}{rates}>"


def page(spectrum: Any) -> str:
    """A table for a notebook: eigenvalues with error and mode, or a row for each point."""
    family, unit = spectrum.family, spectrum.rate_unit
    units = f" [{unit}]" if unit != "1" else ""
    title = f" of {family.system.name}"
    names = list(family.at)
    where = "" if spectrum.codes.ndim else member(spectrum)
    if family.system.quantities:
        names, where = [family.system.quantities[n].symbol for n in names], of_body(spectrum)
        formulas = {q.formula for q in family.system.quantities.values() if q.formula}
        if spectrum.law and formulas:
            formulas = {spectrum.law.formula}
        title += f" contact{''.join(f' ({formula})' for formula in formulas)}"
    if not spectrum.codes.ndim:
        head = ": ".join([f"{title}, {where}" if where else title, spectrum.verdict.value])
        head += f"; {spectrum.growth()}" * bool(spectrum.growth())
        rows = zip(spectrum.eigenvalues, spectrum.radius, _labels(spectrum), strict=True)
        cells = [
            (f"{v.real + 0.0:+.6g}", f"{v.imag + 0.0:+.6g}", f"{r:.1g}", m) for v, r, m in rows
        ]
        columns = [f"Re λ{units}", f"Im λ{units}", "error", "mode"]
        return html_table(head, columns, cells, spectrum.reason, name=family.name)
    fixed = f", {where}" * bool(where)
    head = f"{title}{fixed}: {counted(spectrum)}"
    shape = spectrum.codes.shape
    picked = list(np.ndindex(shape))[:LONGEST]
    cells = [
        (
            *(f"{v:.6g}" for v in spectrum.at[i]),
            spectrum.verdict[i].word,
            f"{spectrum.abscissa[i]:+.6g}",
            f"{spectrum.abscissa_error[i]:.1g}",
        )
        for i in picked
    ]
    columns = [*names, "verdict", f"largest Re λ{units}", "error"]
    left = spectrum.codes.size - len(picked)
    more = f"and {left} more points" if left else ""
    return html_table(head, columns, cells, more, name=family.name)


def _labels(spectrum: Any) -> list[str]:
    try:
        return [str(label) for label in np.ravel(spectrum.modes.labels)]
    except StabilityError:  # a reader still gets the eigenvalues
        return [""] * spectrum.eigenvalues.size


def flat(spectrum: Any) -> tuple[list[str], list[list[Any]]]:
    """Header with units, and a row for each eigenvalue of each point, with all that was given.

    Parameters
    ----------
    spectrum
        A `Spectrum`; mass, length and gravity are left out where all are 1.
    """
    family, shape = spectrum.family, spectrum.codes.shape
    numbers = {name: spectrum.at[..., i] for i, name in enumerate(family.at)}
    for name, value in spectrum.values.items():
        meaning = family.meaning(name)
        if not (spectrum.dimensionless and meaning in ("mass", *LENGTHS, "gravity")):
            numbers.setdefault(meaning, np.broadcast_to(np.asarray(value, dtype=float), shape))
    rate = in_brackets(spectrum.rate_unit)
    header = [f"{name}{in_brackets(_unit(spectrum, name))}" for name in numbers]
    header += ["verdict", "certified", f"real{rate}", f"imaginary{rate}", f"error{rate}", "mode"]
    labels = np.asarray(_labels(spectrum), dtype=object).reshape(spectrum.eigenvalues.shape)
    rows: list[list[Any]] = []
    for index in np.ndindex(shape):
        point = [float(value[index]) for value in numbers.values()]
        said = [spectrum.verdict[index].word if shape else spectrum.verdict.word]
        said.append(bool(np.asarray(spectrum.certified)[index]))
        for value, radius, label in zip(
            spectrum.eigenvalues[index], spectrum.radius[index], labels[index], strict=True
        ):
            parts = [value.real + 0.0, value.imag + 0.0, radius]
            rows.append([*point, *said, *map(float, parts), label])
    return header, rows


GROWS = -2
"""Flag value instead of a verdict's, where structural zeros are not semisimple."""

RAISED = str.maketrans("0123456789", "⁰¹²³⁴⁵⁶⁷⁸⁹")

NOT_ASKED = -1
"""Value instead of bits, where the verdict comes from double precision."""


@dataclass(frozen=True, eq=False)
class SpectrumProof(Record):
    """Proofs of the certified points of a spectrum."""

    abscissa_error: Floats
    """Proved bound on the error of the abscissa, shape (…)."""
    bits: NDArray[np.int64]
    """Precision of the balls that decided each verdict, 0 for rational arithmetic, shape (…);
    `NOT_ASKED` for double precision, a key of `REASONS` where the proof fails for that reason."""
    escalated: bool = False
    """Whether only points were certified that double precision left undecided."""
    from_exact: bool = False
    """Whether the proofs start from the family's exact polynomial."""

    def sentence(self, index: tuple[int, ...], *, certified: bool) -> str:
        """Result of the proof of one point, in words."""
        from .verdict_routes import in_words

        bits = int(self.bits[index])
        if bits in REASONS:
            return REASONS[bits]
        far = "proved" if certified else "undecided within the budget of precision"
        source = " from the family's polynomial" if self.from_exact else ""
        return f"{far} in {in_words(bits)}{source}"


@dataclass(frozen=True, eq=False)
class Spectrum(Record):
    """Eigenvalues of the linearisation at members of a family, structural zeros removed.

    Leading axes are parameters; the last axis is the mode.  A single spectrum has no leading axes.

    Attributes
    ----------
    eigenvalues, radius
        Eigenvalues sorted by real, then imaginary part, and the radii of their error discs; shape
        (…, n), in `rate_unit`.
    frequencies, modes
        |Im λ|, and eigenvectors with readable labels, in the order of the eigenvalues.
    structural_zeros
        Number of eigenvalues left out, which are zero by structure.
    abscissa, abscissa_error
        Largest real part, and a bound on its error; shape (…).
    verdict, nonlinear, reason
        What the eigenvalues say, what the nonlinear motion does, and how the verdict is known.
    certified, proof
        Whether each verdict is proved, and the record of the proofs.
    rate_unit
        Unit of the eigenvalues.
    at, values
        Family parameters, shape (…, len(family.at)), and all that was given, by name.
    family, law
        The family, and the contact law of the disk (None for a user's system).
    states
        The steady motions, shape (…, states); of the disk dimensionless.

    Source: this package; each number has an independent oracle in tests/spectra/test_spectra.py.

    Examples
    --------
    >>> import stability as st
    >>> s = st.spectrum("rolling", at=1.8, contact=st.Viscous(0.3))
    >>> s.verdict.word, round(float(s.abscissa), 6), s.structural_zeros
    ('stable', -0.142586, 2)
    """

    family: Family
    """The family."""
    at: Floats
    """Family parameters, shape (…, len(family.at))."""
    eigenvalues: Complexes
    """Sorted by real, then imaginary part, shape (…, n), in `rate_unit`."""
    radius: Floats
    """Radius of each error disc, shape (…, n): all eigenvalues lie in the union of the discs."""
    structural_zeros: int
    """Number of eigenvalues left out, which are zero by structure; the least number where points
    differ."""
    codes: NDArray[np.int8]
    """Verdict as flag values (`Verdict.code`), shape (…)."""
    states: Floats
    """The steady motions, shape (…, states); of the disk dimensionless."""
    place: MemberNumbers
    """Dimensionless numbers of the members, one row for each point."""
    rate: Floats
    """Unit of rate: eigenvalues over their values in computations, shape (…); 1 for a user's
    system."""
    scale: Floats
    """Unit of each state, shape (…, states)."""
    proof: SpectrumProof | None = None
    """Proof of verdicts and eigenvalues, or None without certified points."""
    power: NDArray[np.int8] | None = None
    """Power of time with which structural zeros are proved to let a disturbance grow, a lower
    bound, shape (…); None where they are semisimple at every member."""
    note: str = ""
    """A sentence if there are fewer structural zeros than at typical members, or empty."""
    symmetric: bool = False
    """Whether the spectrum is proved symmetric under λ → -λ at every member of the family: λ²
    decides, and beyond *unstable* there is *neutral*."""
    pairs: Eigenpairs | None = field(default=None, compare=False)
    """Eigenpairs from the eigensolver, dimensionless; None if not needed, or for many points."""
    solver: EigenSolver = lapack
    """The eigensolver."""
    values: Mapping[str, Any] = field(default_factory=dict)
    """Value or array of everything that was given, by name, in the user's units."""
    law: Contact | None = None
    """The contact law of the disk; None for a user's system."""
    dimensionless: bool = False
    """Whether the numbers have no unit by choice of the units."""

    __getstate__ = fields_of

    def __repr__(self) -> str:
        return line(self)

    def _repr_html_(self) -> str:
        return page(self)

    @property
    def citation(self) -> str:
        """Keys of the works to cite, for `stability.citation`."""
        proved = self.proof is not None and bool((self.proof.bits != NOT_ASKED).any())
        return cited(
            self.law.name if self.law else None,
            model=of_package(self),
            eigenvalues=self.solver is lapack,
            proofs=proved,
        )

    def to_xarray(self) -> xarray.Dataset:
        """The spectrum as a labelled dataset, with units, all that was given, and provenance.

        Returns
        -------
        xarray.Dataset
            `eigenvalues` (complex), `error_radius` and `label` over the parameters and `mode`;
            `abscissa`, `abscissa_error`, `certified`, and as CF flags `verdict` and `nonlinear`,
            over the parameters.
            An axis has the name of the one quantity given along it, otherwise `point`.
            `write_map` and `read_map` keep it in a file.

        Examples
        --------
        >>> import stability as st
        >>> s = st.spectrum("rolling", at=[1.2, 1.8], contact=st.Viscous(0.3))
        >>> s.to_xarray().eigenvalues.dims, s.to_xarray().at.attrs["long_name"]
        (('at', 'mode'), 'axial angular velocity')
        """
        return dataset(self)

    def to_csv(self) -> str:
        """The spectrum as CSV: a line for each eigenvalue of each point, with all that was given.

        The one header line has the units; numbers have all their digits.

        Examples
        --------
        >>> import stability as st
        >>> s = st.spectrum("rolling", at=1.8, contact=st.Viscous(0.3))
        >>> s.to_csv().splitlines()[0][:40]
        'omega3 [√(g/R)],k,mu [1/√(gR)],verdict,c'
        """
        return csv_text(*flat(self))

    def to_pandas(self) -> Any:
        """The spectrum as a pandas DataFrame, with the rows and the header of the CSV.

        Examples
        --------
        >>> import stability as st
        >>> s = st.spectrum("rolling", at=[1.2, 1.8], contact=st.Viscous(0.3))
        >>> s.to_pandas().groupby("omega3 [√(g/R)]").verdict.first().tolist()
        ['unstable', 'stable']
        """
        import pandas as pd

        header, rows = flat(self)
        return pd.DataFrame(rows, columns=header)

    def plot(self, **options: Any) -> Any:
        """Draw the eigenvalues: loci along the one quantity given as an array, or one in the plane.

        Parameters
        ----------
        **options
            As for `stability.plot_locus`: thresholds, title, unit, ax, width, fontsize.

        Returns
        -------
        matplotlib.figure.Figure
        """
        return function_of("figure of a spectrum")(self, **options)

    @property
    def rate_unit(self) -> str:
        """Unit of the eigenvalues: 1/s or √(g/R) of a body, from the units of a user's system.

        Examples
        --------
        >>> import stability as st
        >>> st.spectrum("rolling", at=1.8, contact=st.Viscous(0.3)).rate_unit
        '√(g/R)'
        """
        system = self.family.system
        if not system.quantities:
            return rate_unit(system.units)
        return Kind.GROWTH_RATE.label(dimensionless=self.dimensionless)

    @property
    def abscissa(self) -> Any:
        """Largest real part of the eigenvalues, shape (…); a float for a single spectrum."""
        value = self.eigenvalues.real.max(axis=-1)
        return float(value) if value.ndim == 0 else value

    @property
    def frequencies(self) -> Floats:
        """|Im λ| of each eigenvalue, in their order, shape (…, n), in `rate_unit`.

        Examples
        --------
        >>> import stability as st
        >>> st.spectrum("rolling", at=1.8, contact=st.Viscous(0.3)).frequencies.round(4)
        array([0.    , 0.    , 2.9314, 2.9314])
        """
        return np.abs(self.eigenvalues.imag)

    @property
    def certified(self) -> Any:
        """Whether the verdict is proved, in rational arithmetic or balls, shape (…)."""
        if self.proof is None:
            value = np.zeros(self.codes.shape, dtype=bool)
        else:
            value = (self.codes != CODES[Verdict.UNDECIDED]) & (self.proof.bits != NOT_ASKED)
        return bool(value) if value.ndim == 0 else value

    @property
    def abscissa_error(self) -> Any:
        """Bound on the error of the abscissa, shape (…)."""
        real = self.eigenvalues.real
        # the difference comes first, since it is exact where it matters
        value = (self.radius + (real - real.max(axis=-1, keepdims=True))).max(axis=-1)
        if self.proof is not None:
            value = self.proof.abscissa_error
        return float(value) if value.ndim == 0 else value

    @property
    def verdict(self) -> Any:
        """`Verdict`, or an object array of them, shape (…)."""
        return _members(self.codes, BY_CODE)

    @property
    def nonlinear(self) -> Any:
        """`Nonlinear`, or an object array of them, shape (…): behaviour of the nonlinear motion."""
        # states left out name no member: the motion of the others is a system of its own
        explained = self.family.tangents + len(self.family.idle)
        harmless = self.structural_zeros == explained
        stable = Nonlinear.ASYMPTOTIC if harmless else Nonlinear.OPEN
        if self.family.drifts:
            # the sentence on drift tells what a disk does
            stable = Nonlinear.DRIFTS if of_package(self) else Nonlinear.CARRIED
        # neutral with every λ² strictly negative: the integrals confine the motion
        kept = Nonlinear.BY_INTEGRALS if self.family.integrals else Nonlinear.OPEN
        table = {
            CODES[Verdict.STABLE]: stable,
            CODES[Verdict.UNSTABLE]: Nonlinear.UNSTABLE,
            CODES[Verdict.NEUTRAL]: kept,
            CODES[Verdict.UNDECIDED]: Nonlinear.OPEN,
            CODES[Verdict.DRIFTING]: Nonlinear.GROWS,
        }
        on_zero = (self.codes == CODES[Verdict.NEUTRAL]) & (
            np.abs(self.eigenvalues) <= self.radius
        ).any(axis=-1)
        codes = np.where(on_zero, CODES[Verdict.UNDECIDED], self.codes)
        if self.power is not None:
            table[GROWS] = Nonlinear.GROWS
            open_ = np.isin(
                codes, [c for c, behaviour in table.items() if behaviour is Nonlinear.OPEN]
            )
            asked = open_ & (self.codes != CODES[Verdict.UNDECIDED])
            codes = np.where((self.power > 0) & asked, GROWS, codes)
        if Nonlinear.OPEN in (table[c] for c in np.unique(codes)) and self._linear:
            table |= {
                c: Nonlinear.LINEAR for c, behaviour in table.items() if behaviour is Nonlinear.OPEN
            }
        return _members(np.asarray(codes), table)

    @property
    def _linear(self) -> bool:
        """Whether the rates are proved to be linear."""
        return linear(self.family.system)

    @property
    def reason(self) -> Any:
        """One sentence with the reason for each verdict; an object array of them, shape (…)."""
        each = [np.asarray(v) for v in (self.abscissa, self.abscissa_error, self.certified)]
        if not self.codes.ndim:
            return self._reason((), *each)
        out = np.empty(self.codes.shape, dtype=object)
        for index in np.ndindex(self.codes.shape):
            out[index] = self._reason(index, *(v[index] for v in each))
        return out

    def growth(self, index: tuple[int, ...] = ()) -> str:
        """The growth of a disturbance of a drifting member in words; empty for any other.

        Parameters
        ----------
        index
            Place of the member on the leading axes.

        Examples
        --------
        >>> import casadi as ca, stability as st
        >>> x, p = ca.SX.sym("x", 3), ca.SX.sym("p")
        >>> chain = st.System("chain", x, p, ca.vertcat(x[1], 0, p * x[0] - x[2]),
        ...                   states=("x", "v", "z"), parameters=("p",))
        >>> rest = st.Family(chain, "rest", at=("p",), held={"x": 0, "v": 0, "z": 0})
        >>> st.spectrum(rest, at=1.0).growth()
        'grows like t'
        """
        if self.power is None or self.codes[index] != CODES[Verdict.DRIFTING]:
            return ""
        power = int(self.power[index])
        least = "at least " * (power < most_power(self.family, self.structural_zeros))
        return f"grows {least}like t{str(power).translate(RAISED) if power > 1 else ''}"

    def _reason(self, index: tuple[int, ...], abscissa: Any, error: Any, certified: Any) -> str:
        bound = f"largest real part {abscissa:.3g}, error bound {error:.1g}"
        if (self.symmetric or self.family.conservative) and not certified:
            bound = "decided by the sign of λ², whose polynomial is even by structure; " + bound
        parts = [bound]
        if self.proof is not None and self.proof.bits[index] != NOT_ASKED:
            parts = [self.proof.sentence(index, certified=bool(certified)), bound]
            if self.proof.escalated:
                parts.insert(0, "double precision left it open")
        elif self.structural_zeros:
            count = int(self.structural_zeros)  # NumPy's truth value multiplies no text
            parts.append(
                f"{count} structural zero{'s' * int(count != 1)} removed through null vectors"
            )
        left = ", ".join(n for n in self.family.system.states if n in self.family.left_out)
        grown = self.growth(index)
        block = f"zeros form a Jordan block, a disturbance {grown}" if grown else ""
        ignored = f"{left} {'are' if ',' in left else 'is'} ignorable" if left else ""
        solved = ", ".join(self.family.system.algebraic)
        solved = f"one zero each for the algebraic variables {solved}" if solved else ""
        certain = self.symmetric and certified and not self.family.conservative
        fit = self.family.system.approximation
        symmetric = "symmetric under λ → -λ by structure" if certain else ""
        return "; ".join(
            [*parts, *filter(None, [block, symmetric, ignored, solved, self.note, fit])]
        )

    @cached_property
    def modes(self) -> Modes:
        """Eigenvectors and readable labels, in the order of the eigenvalues."""
        values = self.eigenvalues / np.asarray(self.rate)[..., None]
        reduced = self.place.reduced(self.family, self.structural_zeros)
        pairs = self.pairs or Eigenpairs(*eigenpairs(reduced.matrix, self.solver))
        vectors, participation = lift(values, reduced, pairs, self.scale)
        labels = mode_labels(
            self.eigenvalues, self.radius, participation, self.family.system.states
        )
        return Modes(vectors, participation, labels, tuple(self.family.system.states))

    def tracked(self) -> NDArray[np.intp]:
        """Order that follows each mode along the last parameter axis, by eigenvector overlap.

        Returns
        -------
        ndarray
            Indices of shape (…, points, n): `np.take_along_axis(s.eigenvalues, s.tracked(), -1)`
            has one mode per column.  Where eigenvalues meet, the order is a convention.

        Examples
        --------
        >>> import numpy as np, stability as st
        >>> s = st.spectrum("spinning", at=np.linspace(2, 3, 9), contact=st.Viscous(0.3))
        >>> s.tracked().shape
        (9, 5)
        """
        if not self.codes.ndim:
            raise ParameterError("tracked is for a branch; give `at` as an array.")
        return track(self.eigenvalues, self.modes.vectors)


def _members(codes: NDArray[np.int8], table: dict[int, Any]) -> Any:
    if codes.ndim == 0:
        return table[int(codes)]
    out = np.empty(codes.shape, dtype=object)
    for code, member in table.items():
        out[codes == code] = member
    return out
