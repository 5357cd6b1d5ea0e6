"""Stability of steady motions: which can be seen, for which parameters, and how do we know.

`__all__` lists the public names.  Each name loads its module when it is first used, so that the
import of the package is fast.
"""

from __future__ import annotations

import sys
from collections.abc import Callable
from importlib import import_module
from typing import TYPE_CHECKING, Any

from .base import above
from .base.calls import guarded
from .base.version import __version__ as __version__

_HOME = {
    "bodies.disk": ("Disk", "REAL_DISKS"),
    "bodies.round_body.body": ("Body",),
    "bodies.round_body.shapes.profile": ("Egg", "from_profile"),
    "bodies.round_body.shapes.named": ("Torus", "Spheroid", "EccentricSphere", "ThickDisk"),
    "bodies.resistance": ("AirTorque", "PivotingResistance", "RollingResistance", "Resistance"),
    "bodies.contact_laws": (
        "Contact",
        "Parameter",
        "Smooth",
        "Viscous",
        "LinearViscous",
        "Rough",
        "Creep",
        "Coulomb",
        "RegularisedCoulomb",
    ),
    "systems.system": ("System",),
    "systems.mechanics": ("mechanics",),
    "systems.linear": ("linear",),
    "systems.equations": ("Condition",),
    "algebra.upright": ("UPRIGHT",),
    "systems.family": ("Family",),
    "bodies.thin_disk": ("disk_system",),
    "bodies.subject": ("disk_family",),
    "systems.equilibria": ("Equilibria",),
    "systems.continuation": ("branch", "Branch", "BranchPoint", "Fold"),
    "spectra.spectrum": ("spectrum",),
    "spectra.result": ("Spectrum",),
    "base.verdict": ("Verdict", "Nonlinear"),
    "boundary.brackets": ("BoundaryPoint", "Crossing", "Boundaries", "Unresolved"),
    "maps.stability_map": ("stability_map",),
    "boundary.changes": ("boundaries",),
    "maps.files": ("read_map", "write_map"),
    "maps.stream": ("stream_map",),
    "algebra.polynomial": ("Exact", "ExactPolynomial"),
    "bodies.disk_polynomials": ("exact_polynomial",),
    "derivation.conditions": ("conditions", "Conditions"),
    "bodies.painleve": ("painleve_limit", "PainleveLimit"),
    "boundary.drift": ("drift", "Drift"),
    "boundary.hopf": ("hopf", "HopfPoint", "HopfKind", "CycleBirth", "Onset"),
    "boundary.slow_flow": ("slow_flow", "SlowFlow"),
    "boundary.mean_path": ("retrograde_map",),
    "boundary.two_parameters.points": ("codimension_two",),
    "boundary.two_parameters.point_records": (
        "CodimensionTwo",
        "CurveOfZeros",
        "DegeneratePoint",
        "PointKind",
    ),
    "motion.simulate": ("simulate",),
    "bodies.launch": ("launch",),
    "figures.animate": ("animate",),
    "figures.diagram": ("plot_map",),
    "figures.retrograde": ("plot_retrograde",),
    "figures.basins": ("plot_basins",),
    "figures.loci": ("plot_locus",),
    "figures.motion": ("plot_motion",),
    "motion.result": ("Outcome",),
    "motion.files": ("read_motion", "write_motion"),
    "basin.basins": ("basins",),
    "basin.dataset": ("read_basins",),
    "basin.launch_labels": ("launch_labels",),
    "basin.statistics.exponent": ("uncertainty_exponent",),
    "basin.statistics.fractions": ("fractions", "wilson"),
    "basin.statistics.shock": ("fatal_shock",),
    "basin.statistics.samples": ("Ball", "LogUniform", "Normal", "Uniform"),
    "scene.scene": ("Scene",),
    "scene.answer": ("Answer",),
    "scene.ladder": ("Rung",),
    "scene.rungs.reduced": ("ReducedModel",),
    "compare.report": ("report",),
    "export.latex": ("latex",),
    "export.c_code": ("c_code",),
    "export.continuation": ("auto_input", "bifurcationkit_input"),
    "explorer.explore": ("explore",),
    "tables.registry": ("table",),
    "tables.table": ("Table",),
    "base.citation": ("citation", "Citation"),
    "base.errors": ("StabilityError", "StabilityWarning"),
}
_WHERE = {name: module for module, names in _HOME.items() for name in names}

_ABOVE = {
    "figure of a spectrum": ("figures.loci", "plot_locus"),
    "spectrum": ("spectra.spectrum", "spectrum"),
    "citation of a file": ("storage.datasets", "file_citation"),
}
"""Where the functions are that rooms below call: `.plot()`, `.spectra`, `citation` of a path."""

__all__ = sorted(_WHERE)  # noqa: PLE0605

if TYPE_CHECKING:
    from .algebra.polynomial import Exact as Exact
    from .algebra.polynomial import ExactPolynomial as ExactPolynomial
    from .algebra.upright import UPRIGHT as UPRIGHT
    from .base.citation import Citation as Citation
    from .base.citation import citation as citation
    from .base.errors import StabilityError as StabilityError
    from .base.errors import StabilityWarning as StabilityWarning
    from .base.verdict import Nonlinear as Nonlinear
    from .base.verdict import Verdict as Verdict
    from .basin.basins import basins as basins
    from .basin.dataset import read_basins as read_basins
    from .basin.launch_labels import launch_labels as launch_labels
    from .basin.statistics.exponent import uncertainty_exponent as uncertainty_exponent
    from .basin.statistics.fractions import fractions as fractions
    from .basin.statistics.fractions import wilson as wilson
    from .basin.statistics.samples import Ball as Ball
    from .basin.statistics.samples import LogUniform as LogUniform
    from .basin.statistics.samples import Normal as Normal
    from .basin.statistics.samples import Uniform as Uniform
    from .basin.statistics.shock import fatal_shock as fatal_shock
    from .bodies.contact_laws import Contact as Contact
    from .bodies.contact_laws import Coulomb as Coulomb
    from .bodies.contact_laws import Creep as Creep
    from .bodies.contact_laws import LinearViscous as LinearViscous
    from .bodies.contact_laws import Parameter as Parameter
    from .bodies.contact_laws import RegularisedCoulomb as RegularisedCoulomb
    from .bodies.contact_laws import Rough as Rough
    from .bodies.contact_laws import Smooth as Smooth
    from .bodies.contact_laws import Viscous as Viscous
    from .bodies.disk import REAL_DISKS as REAL_DISKS
    from .bodies.disk import Disk as Disk
    from .bodies.disk_polynomials import exact_polynomial as exact_polynomial
    from .bodies.launch import launch as launch
    from .bodies.painleve import PainleveLimit as PainleveLimit
    from .bodies.painleve import painleve_limit as painleve_limit
    from .bodies.resistance import AirTorque as AirTorque
    from .bodies.resistance import PivotingResistance as PivotingResistance
    from .bodies.resistance import Resistance as Resistance
    from .bodies.resistance import RollingResistance as RollingResistance
    from .bodies.round_body.body import Body as Body
    from .bodies.round_body.shapes.named import EccentricSphere as EccentricSphere
    from .bodies.round_body.shapes.named import Spheroid as Spheroid
    from .bodies.round_body.shapes.named import ThickDisk as ThickDisk
    from .bodies.round_body.shapes.named import Torus as Torus
    from .bodies.round_body.shapes.profile import Egg as Egg
    from .bodies.round_body.shapes.profile import from_profile as from_profile
    from .bodies.subject import disk_family as disk_family
    from .bodies.thin_disk import disk_system as disk_system
    from .boundary.brackets import Boundaries as Boundaries
    from .boundary.brackets import BoundaryPoint as BoundaryPoint
    from .boundary.brackets import Crossing as Crossing
    from .boundary.brackets import Unresolved as Unresolved
    from .boundary.changes import boundaries as boundaries
    from .boundary.drift import Drift as Drift
    from .boundary.drift import drift as drift
    from .boundary.hopf import CycleBirth as CycleBirth
    from .boundary.hopf import HopfKind as HopfKind
    from .boundary.hopf import HopfPoint as HopfPoint
    from .boundary.hopf import Onset as Onset
    from .boundary.hopf import hopf as hopf
    from .boundary.mean_path import retrograde_map as retrograde_map
    from .boundary.slow_flow import SlowFlow as SlowFlow
    from .boundary.slow_flow import slow_flow as slow_flow
    from .boundary.two_parameters.point_records import CodimensionTwo as CodimensionTwo
    from .boundary.two_parameters.point_records import CurveOfZeros as CurveOfZeros
    from .boundary.two_parameters.point_records import DegeneratePoint as DegeneratePoint
    from .boundary.two_parameters.point_records import PointKind as PointKind
    from .boundary.two_parameters.points import codimension_two as codimension_two
    from .compare.report import report as report
    from .derivation.conditions import Conditions as Conditions
    from .derivation.conditions import conditions as conditions
    from .explorer.explore import explore as explore
    from .export.c_code import c_code as c_code
    from .export.continuation import auto_input as auto_input
    from .export.continuation import bifurcationkit_input as bifurcationkit_input
    from .export.latex import latex as latex
    from .figures.animate import animate as animate
    from .figures.basins import plot_basins as plot_basins
    from .figures.diagram import plot_map as plot_map
    from .figures.loci import plot_locus as plot_locus
    from .figures.motion import plot_motion as plot_motion
    from .figures.retrograde import plot_retrograde as plot_retrograde
    from .maps.files import read_map as read_map
    from .maps.files import write_map as write_map
    from .maps.stability_map import stability_map as stability_map
    from .maps.stream import stream_map as stream_map
    from .motion.files import read_motion as read_motion
    from .motion.files import write_motion as write_motion
    from .motion.result import Outcome as Outcome
    from .motion.simulate import simulate as simulate
    from .scene.answer import Answer as Answer
    from .scene.ladder import Rung as Rung
    from .scene.rungs.reduced import ReducedModel as ReducedModel
    from .scene.scene import Scene as Scene
    from .spectra.result import Spectrum as Spectrum
    from .spectra.spectrum import spectrum as spectrum
    from .systems.continuation import Branch as Branch
    from .systems.continuation import BranchPoint as BranchPoint
    from .systems.continuation import Fold as Fold
    from .systems.continuation import branch as branch
    from .systems.equations import Condition as Condition
    from .systems.equilibria import Equilibria as Equilibria
    from .systems.family import Family as Family
    from .systems.linear import linear as linear
    from .systems.mechanics import mechanics as mechanics
    from .systems.system import System as System
    from .tables.registry import table as table
    from .tables.table import Table as Table


def __getattr__(name: str) -> Any:
    if name not in _WHERE:
        raise AttributeError(f"module 'stability' has no attribute {name!r}")
    value = guarded(getattr(import_module(f".{_WHERE[name]}", __name__), name), name)
    for public, module in _WHERE.items():  # classes of results, which no one asks for by name
        home = sys.modules.get(f"{__name__}.{module}")
        if isinstance(one := getattr(home, public, None), type):
            guarded(one, public)
    globals()[name] = value
    return value


def _finder(module: str, name: str) -> Callable[[], Any]:
    return lambda: getattr(import_module(f".{module}", __name__), name)


for _call, _place in _ABOVE.items():
    above.register(_call, _finder(*_place))


def __dir__() -> list[str]:
    return list(__all__)
