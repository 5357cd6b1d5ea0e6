"""The package's routes to a spectrum, as subclasses of `Route`."""

from __future__ import annotations

from typing import Any, ClassVar

import numpy as np

from ....base.verdict import CODES
from ....maps.growth_rates import GrowthKernel
from ....maps.verdicts import FilteredVerdicts
from ....spectra.certificate import verdict
from ....spectra.result import Spectrum
from ....spectra.spectrum import spectrum
from ..points import Points
from .route import Answer, Route


def _somewhere(points: Points, *, certify: bool) -> Spectrum:
    """Spectrum of a family that claims the given state; the package checks that it is steady."""
    from ....bodies.thin_disk import disk_system
    from ....systems.family import Family

    assert points.given is not None
    system, law = disk_system(points.law), points.contact()
    held = dict(zip(system.states, points.given[0].tolist(), strict=True))
    at = held.pop("omega3")
    family = Family(
        system,
        "claimed",
        ("omega3",),
        held=held,
        unknown={},
        equations=(),
        typical={"omega3": at, "k": 0.3, "mu": 0.7},
        conservative=law.conservative,
    )
    p = dict(zip(system.parameters, points.parameters[0].tolist(), strict=True))
    return spectrum(family, at=at, certify=certify, **p)


def _told(found: Spectrum) -> Answer:
    return Answer(
        np.atleast_1d(found.codes),
        np.atleast_2d(found.eigenvalues),
        np.atleast_1d(found.abscissa),
        np.atleast_1d(found.abscissa_error),
    )


def _arguments(points: Points) -> dict[str, Any]:
    from ....bodies.disk import Disk

    place = {"at": points.at} if points.lean is None else {"lean": points.lean}
    return {**place, "disk": Disk(k=points.k), "contact": points.contact()}


class Deflated(Route):
    """`spectrum`: each eigenvalue in a disc; points that the discs leave open are certified."""

    name, title = "spectrum", "spectrum(): discs about eigenvalues; what they leave open is proved"
    own, default = True, True
    certify: ClassVar[bool] = False

    def answer(self, points: Points) -> Answer:
        """Call `spectrum` with all points at once."""
        given: dict[str, Any] = _arguments(points)
        return _told(spectrum(points.family, certify=self.certify, **given))

    def at_state(self, points: Points) -> Answer:
        """Call `spectrum` with a user's family that claims the state."""
        return _told(_somewhere(points, certify=self.certify))


class Certified(Deflated):
    """`spectrum(certify=True)`: rational arithmetic and balls."""

    name, title = "certified", "spectrum(certify=True): rational arithmetic and balls"
    default, arrays, certify = False, False, True


class MapKernel(Route):
    """Work of `stability_map` at each cell: exact polynomials, a filter, factors with bounds."""

    name, title = "map", "stability_map(): exact polynomials in doubles with bounds"
    own, default = True, True

    def answer(self, points: Points) -> Answer:
        """Call the kernels of maps on scattered points."""
        problem = points.problem()
        codes, _ = FilteredVerdicts(problem).codes(problem.values)
        growth = GrowthKernel(problem, modes=True)(problem.values, scattered=True)
        return Answer(codes, growth.values, growth.abscissa, growth.error)


class MapVerdict(Route):
    """The verdicts of `stability_map` alone."""

    name, title = "map-verdict", "stability_map(), verdicts alone: exact conditions, filtered"
    own, default = True, True

    def answer(self, points: Points) -> Answer:
        """Call the filter of maps."""
        problem = points.problem()
        codes, _ = FilteredVerdicts(problem).codes(problem.values)
        return Answer(codes)


class ExactVerdict(Route):
    """A proved verdict alone, point by point."""

    name, title = "exact-verdict", "exact conditions over Q; a verdict alone"
    own, arrays = True, False

    def answer(self, points: Points) -> Answer:
        """Call `stability.spectra.certificate.verdict` at each point."""
        problem = points.problem()
        rows = zip(
            *(np.broadcast_to(v, (len(points),)).tolist() for v in problem.values.values()),
            strict=True,
        )
        ones = (dict(zip(problem.values, row, strict=True)) for row in rows)
        codes = [CODES[verdict(problem, one)] for one in ones]
        return Answer(np.array(codes, dtype=np.int8))


OWN: tuple[type[Route], ...] = (Deflated, Certified, MapKernel, MapVerdict, ExactVerdict)
"""The package's routes."""
