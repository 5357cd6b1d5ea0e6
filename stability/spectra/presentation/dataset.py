"""A spectrum as a labelled dataset."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ...base.verdict import Nonlinear
from .labels import axis_attributes, origin, rate_attributes, verdict_attributes

if TYPE_CHECKING:
    import xarray

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
    own = np.shape(value)
    if not own or len(own) > len(shape):
        return ()
    first = len(shape) - len(own)
    longer = [first + i for i, n in enumerate(own) if n > 1]
    return tuple(longer or ([first] if own == (1,) and shape[-1] == 1 else []))


def _free(name: str) -> str:
    return f"parameter_{name}" if name in TAKEN else name


def dataset(spectrum: Any) -> xarray.Dataset:
    """Eigenvalues, error discs, verdicts, labels of modes, and all that was given.

    Parameters
    ----------
    spectrum
        The `Spectrum`.

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
            "flag_meanings": " ".join(one.name.lower() for one in Nonlinear),
            "sentences": " | ".join(one.value for one in Nonlinear)}),
        "label": (every, np.array(spectrum.modes.labels, dtype=object).reshape(
            spectrum.eigenvalues.shape), {"long_name": "mode in words: kind, leading states"}),
    }  # fmt: skip
    coordinates = {}
    for name, value in values.items():
        axes = _axes(value, shape)
        array = np.asarray(value, dtype=float)
        array = array.reshape([shape[i] for i in axes]) if array.ndim else array
        own = tuple(dims[i] for i in axes) if array.ndim else ()
        coordinates[_free(name)] = (own, array, axis_attributes(spectrum, name))
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


def _places(found: Any) -> NDArray[np.int8]:
    """The place of each sentence in its enumeration."""
    known = {one: i for i, one in enumerate(Nonlinear)}
    given = np.asarray(found, dtype=object)
    return np.array([known[one] for one in given.ravel()], dtype=np.int8).reshape(given.shape)
