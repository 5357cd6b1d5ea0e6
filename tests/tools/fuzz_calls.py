"""Random calls of everything in the public names and of the methods of what comes back.

Each call has arguments that fit, three in four with one or two replaced by something odd.  It must
return, without NaN, or raise the package's own error in at most two short lines; TypeError only
where Python itself finds that the words do not fit the signature.
"""

from __future__ import annotations

import dataclasses
import random
import signal
import tempfile
import traceback
import warnings
from collections.abc import Callable, Iterator
from contextlib import chdir, contextmanager
from functools import lru_cache
from pathlib import Path
from typing import Any

import casadi as ca
import fuzz_values
import numpy as np
import xarray as xr
from fuzz import too_much
from fuzz_values import SHORT, odd

import stability as st
from stability.base.errors import StabilityWarning

Maker = Callable[[random.Random], Any]
NAN_SAYS_NOTHING = ("final_error", "end_time_error", "lean")
"""Where a result may say that it knows nothing."""


# --- arguments that fit ---


def _number(low: float, high: float) -> Maker:
    def make(r: random.Random) -> Any:
        value = r.uniform(low, high)
        if r.random() < 0.8:
            return value
        return np.array([value, r.uniform(low, high)])

    return make


def _one(low: float, high: float) -> Maker:
    return lambda r: r.uniform(low, high)


def _of(*values: Any) -> Maker:
    return lambda r: r.choice(values)


def _disk(r: random.Random) -> Any:
    if r.random() < 0.5:
        return st.Disk(k=r.uniform(0.1, 0.5))
    return r.choice(
        [
            st.Disk(),
            st.Disk.hoop(),
            st.Disk.named("quarter"),
            st.Disk(mass=1.0, radius=0.4, gravity=1.0),
        ]
    )


def _law(r: random.Random) -> Any:
    mu = r.uniform(0.05, 3)
    return r.choice([st.Viscous(mu), st.LinearViscous(mu=mu), st.Smooth(), st.Rough()])


def _friction(r: random.Random) -> Any:
    return r.choice([st.Viscous, st.LinearViscous])(r.uniform(0.1, 3))


def _any_law(r: random.Random) -> Any:
    mu = r.uniform(0.05, 1)
    creep = st.Creep(100 * mu, order=r.choice((1, 2)))
    return r.choice([_law(r), st.Coulomb(mu), st.RegularisedCoulomb(mu, 0.01), creep])


@lru_cache(maxsize=1)
def systems() -> list[Any]:
    """A few systems of a user's own."""
    x, p = ca.SX.sym("x", 2), ca.SX.sym("p", 2)
    swing = ca.vertcat(x[1], -p[0] * ca.sin(x[0]) - p[1] * x[1])
    names = {"states": ("angle", "rate"), "parameters": ("g", "d")}
    return [
        st.System("pendulum", x, p, swing, **names),
        st.System(
            "observed",
            x,
            p,
            swing,
            **names,
            observables={"energy": x[1] ** 2},
            conditions=(st.Condition(p[0], "g = {value:.3g} must be positive"),),
        ),
        st.disk_system("viscous"),
        st.disk_system("rough"),
    ]


@lru_cache(maxsize=1)
def families() -> list[Any]:
    """Families of these systems, and one with something to solve for."""
    x, p = ca.SX.sym("x", 2), ca.SX.sym("p", 1)
    leaning = st.System(
        "leaning",
        x,
        p,
        ca.vertcat(x[1], p - ca.sin(x[0]) - x[1]),
        states=("angle", "rate"),
        parameters=("torque",),
    )
    still = {"angle": 0.0, "rate": 0.0}
    return [
        st.Family(systems()[0], "hanging", at=("g",), held=still),
        st.Family(systems()[1], "seen", at=("g", "d"), held=still),
        st.Family(
            leaning,
            "leaning",
            at=("torque",),
            held={"rate": 0.0},
            unknown={"angle": 0.1},
            equations=("rate",),
        ),
        st.disk_family("tumbling", "viscous"),
        st.disk_family("circling", "rough"),
    ]


@lru_cache(maxsize=1)
def datasets() -> list[Any]:
    """A map, a motion, a motion with pose, several motions."""
    start = {"theta": 1.4, "omega3": 0.4}
    return [
        st.stability_map("spinning", x=("at", 1, 4, 3), y=("mu", 0.1, 2, 3)),
        st.simulate(st.Disk(), st.Viscous(0.3), start, 1.0),
        st.simulate(st.Disk(), st.Viscous(0.3), start, [0.5, 1.0, 1.5], pose=True),
        st.simulate(st.Disk(), st.Viscous(0.3), {"theta": [1.4, 1.5]}, 1.0),
    ]


def _axis(*names: str) -> Maker:
    ends = {"at": (0.4, 1.3), "mu": (0.1, 2.0), "k": (0.2, 0.4), "radius": (0.5, 2.0)}

    def make(r: random.Random) -> Any:
        name = r.choice(names)
        return (name, *ends[name], r.randint(2, 6), *(["log"] * (r.random() < 0.3)))

    return make


def _start(r: random.Random) -> Any:
    if r.random() < 0.5:
        return {"theta": r.uniform(1.2, 1.9), "omega3": r.uniform(0, 1)}
    return [r.uniform(1.2, 1.9), 0.1, 0.2, 0.3, 0, 0]


def _times(r: random.Random) -> Any:
    return r.choice([r.uniform(0.1, 2), [0.5, 1.0], np.linspace(0, 2, 5)])


def _member(r: random.Random) -> dict[str, Any]:
    """A family with an `at` and parameters that fit it."""
    family = r.choice(families())
    size = {"theta": 1.1, "torque": 0.4}
    return {
        "family": family,
        "at": [size.get(n, r.uniform(1, 3)) for n in family.at],
        "parameters": [{"k": 0.3}.get(n, r.uniform(0.1, 2)) for n in family.parameters],
    }


def _rows(r: random.Random) -> tuple[Any, dict[str, Any]]:
    found = _member(r)
    family = found["family"]
    a, q = np.array([found["at"]]), np.array([found["parameters"]]).reshape(1, -1)
    return family, {"a": a, "u": family.solve(a, q), "q": q}


# --- the calls ---

Call = tuple[Callable[..., Any], list[Any], dict[str, Any]]
CALLS: dict[str, Callable[[random.Random, Path], Call]] = {}
"""A callable with words that fit, by name."""


def _add(name: str, positional: list[Maker], **named: Maker) -> None:
    """Positional words are given, named ones with a chance of a half unless they end in _."""

    def make(r: random.Random, place: Path) -> Call:  # noqa: ARG001
        target: Any = st
        for part in name.split("."):
            target = getattr(target, part)
        words = {n.rstrip("_"): m(r) for n, m in named.items() if n[-1] == "_" or r.random() < 0.5}
        return target, [m(r) for m in positional], words

    CALLS[name] = make


def _call(made: Callable[[random.Random, Path], Call]) -> None:
    CALLS[made.__name__.strip("_")] = made


_mu = _number(0.05, 3)
_add(
    "Disk",
    [],
    mass_=_number(0.1, 3),
    radius_=_number(0.1, 3),
    k=_number(0.1, 0.5),
    gravity_=_number(1, 10),
)
_add("Disk.uniform", [], mass_=_mu, radius_=_mu, gravity_=_mu)
_add("Disk.hoop", [])
_add("Disk.annulus", [_number(0, 0.1)], mass_=_mu, radius_=_number(0.1, 3), gravity_=_mu)
_add("Disk.named", [_of("quarter", "le-saux")])
for _name in ("Viscous", "LinearViscous", "Coulomb"):
    _add(_name, [_mu])
_add("Creep", [_mu], order=_of(1, 2, 3))
_add("LinearViscous.like", [_mu, _disk])
_add("RegularisedCoulomb", [_mu, _mu])
_add("Smooth", [])
_add("Rough", [])
for _name in ("Verdict", "Nonlinear", "Crossing", "HopfKind", "Outcome"):
    _add(_name, [lambda r, n=_name: r.choice(list(getattr(st, n))).value])  # type: ignore[misc]
_add("StabilityError", [_of("a sentence.")])
_add(
    "disk_system", [_of("viscous", "rough", "coulomb")], slip_states=_of(None), direction=_of(False)
)
_add("disk_family", [_of("rolling", "spinning"), _of("viscous", "rough", "smooth")])
_add("exact_polynomial", [_of("rolling", "tumbling"), _of("viscous", "rough")])
_add(
    "spectrum",
    [_of("rolling", "spinning", "tumbling")],
    at_=_number(0.2, 1.4),
    contact_=_law,
    disk=_disk,
    certify=_of(False, False, True),
)
_add(
    "stability_map",
    [_of("rolling", "spinning", "tumbling")],
    x_=_axis("at"),
    y_=_axis("k", "radius"),
    contact_=_law,
    certify=_of(False),
    boundaries=_of(True, False),
    modes=_of(True, False),
    workers=_of(None, 1, 2),
    progress=_of(None, lambda *_: None),
)
_add(
    "boundaries",
    [_of("rolling", "spinning", "tumbling")],
    axis_=_axis("at"),
    contact_=_law,
    disk=_disk,
)
_add(
    "drift",
    [],
    at_=_number(1000, 2000),
    tilt_=_number(0.001, 0.01),
    contact_=_friction,
    disk=_disk,
    launch=_of(True, False),
)
_add("hopf", [_of("spinning", "tumbling")], contact_=_friction, disk=_disk, points=_of(20, 60))
_add(
    "launch",
    [_of("rolling", "spinning", "tumbling")],
    at_=_number(0.5, 2),
    tilt=_number(0.01, 0.2),
    disk_=_disk,
)
_add(
    "simulate",
    [_disk, _any_law, _start, _times],
    method=_of("auto", "dop853"),
    tolerance=_of(1e-6, 1e-9),
    pose=_of(True, False),
    flat=_of(1e-6),
    settle=_of(1e-3),
    check=_of(True, False),
    workers=_of(None, 1),
    max_steps=_of(10000, 100),
)


@_call
def _boundaries_k(r: random.Random, place: Path) -> Call:  # noqa: ARG001
    return st.boundaries, ["spinning"], {"axis": _axis("k")(r), "at": 1.3, "contact": _law(r)}


@_call
def _spectrum_own(r: random.Random, place: Path) -> Call:  # noqa: ARG001
    found = _member(r)
    family = found["family"]
    words = dict(zip(family.parameters, found["parameters"], strict=True))
    return st.spectrum, [family], {"at": np.squeeze(found["at"])[()], **words}


@_call
def _map_own(r: random.Random, place: Path) -> Call:  # noqa: ARG001
    axes = ("g", 0.5, 3, r.randint(2, 5)), ("d", 0.1, 1, r.randint(2, 5))
    return st.stability_map, [families()[0]], {"x": axes[0], "y": axes[1]}


@_call
def _boundaries_own(r: random.Random, place: Path) -> Call:  # noqa: ARG001
    return st.boundaries, [families()[0]], {"axis": ("g", -1.3, 3, r.randint(5, 9)), "d": 0.3}


@_call
def _branch(r: random.Random, place: Path) -> Call:  # noqa: ARG001
    family = r.choice(families()[2:4])
    low, high = (0.1, 0.8) if family.name == "leaning" else (1.5, 0.3)
    words = {"points": r.randint(2, 9)} if r.random() < 0.7 else {}
    return st.branch, [family, low, high, [0.25, 0.3][: len(family.parameters)]], words


@_call
def _stream_map(r: random.Random, place: Path) -> Call:
    words = {"x": _axis("at")(r), "y": _axis("mu")(r), "out": place / "s.nc", "overwrite": True}
    if r.random() < 0.5:
        words |= {"growth": True, "out": place / "g.zarr"}
    if r.random() < 0.3:
        words |= {"executor": "threads", "workers": r.randint(1, 2)}
    return st.stream_map, [r.choice(["rolling", "spinning"])], words


@_call
def _write_map(r: random.Random, place: Path) -> Call:
    return st.write_map, [r.choice(datasets()[:1]), place / "m.nc"], {"overwrite": True}


@_call
def _write_motion(r: random.Random, place: Path) -> Call:
    return st.write_motion, [r.choice(datasets()[1:]), place / "r.nc"], {"overwrite": True}


@_call
def _read_map(r: random.Random, place: Path) -> Call:
    path = place / "kept-map.nc"
    if not path.exists():
        st.write_map(datasets()[0], path)
    return st.read_map, [path], {"lazy": False} if r.random() < 0.5 else {}


@_call
def _read_motion(r: random.Random, place: Path) -> Call:  # noqa: ARG001
    path = place / "kept-motion.nc"
    if not path.exists():
        st.write_motion(datasets()[1], path)
    return st.read_motion, [path], {}


@_call
def _animate(r: random.Random, place: Path) -> Call:
    words = {"overwrite": True, "fps": r.choice([10, 25])}
    return st.animate, [datasets()[2], place / "film.html"], words


@_call
def _report(r: random.Random, place: Path) -> Call:
    return st.report, [place / f"report{r.random()}", ["spectrum"]], {"workers": 1}


@_call
def _system(r: random.Random, place: Path) -> Call:  # noqa: ARG001
    x, p = ca.SX.sym("x", 2), ca.SX.sym("p", 1)
    words: dict[str, Any] = {"states": ("a", "b"), "parameters": ("p",)}
    if r.random() < 0.5:
        words |= {"observables": {"e": x[0] * p}, "units": {"a": "m"}}
        words |= {"conditions": (st.Condition(p, "p = {value} is not positive"),)}
    return st.System, ["own", x, p, ca.vertcat(x[1], -p * x[0])], words


@_call
def _mass_matrix(r: random.Random, place: Path) -> Call:  # noqa: ARG001
    x, m = ca.SX.sym("x", 2), ca.SX.sym("m")
    words = {"unknowns": ("d_v",), "rates": {"q": x[1]}, "states": ("q", "v"), "parameters": ("m",)}
    if r.random() < 0.5:
        words |= {"pivots": [(0, 0)]}
    return st.System.from_mass_matrix, ["spring", x, m, m, -x[0]], words


@_call
def _system_methods(r: random.Random, place: Path) -> Call:  # noqa: ARG001
    system = r.choice(systems())
    x = [1.2, 0.3, 0.2, 0.1, 0.0, 0.0][: len(system.states)]
    p = [0.3, 0.2][: len(system.parameters)]
    name = r.choice(["rates", "linearise", "observe", "check", "index"])
    words = [r.choice(system.states)] if name == "index" else [x, p]
    return getattr(system, name), words, {}


@_call
def _condition(r: random.Random, place: Path) -> Call:  # noqa: ARG001
    return st.Condition(ca.SX.sym("x"), "x = {value:.3g} is too small").refusal, [r.random()], {}


@_call
def _family(r: random.Random, place: Path) -> Call:  # noqa: ARG001
    words: dict[str, Any] = {"at": ("g",), "held": {"angle": 0.0}, "unknown": {"rate": 0.0}}
    words |= {"equations": ("angle",)}
    for name, value in (
        ("positive", ("rate",)),
        ("typical", {"g": 2.0}),
        ("conservative", False),
        ("integrals", False),
        ("drifts", False),
    ):
        if r.random() < 0.3:
            words[name] = value
    return st.Family, [systems()[0], "own"], words


@_call
def _family_member(r: random.Random, place: Path) -> Call:  # noqa: ARG001
    found = _member(r)
    return found["family"].member, [found["at"], found["parameters"]], {}


@_call
def _family_methods(r: random.Random, place: Path) -> Call:  # noqa: ARG001
    family, rows = _rows(r)
    name = r.choice(["solve", "states", "checked_states", "matrix", "tangent"])
    if name == "solve":
        return family.solve, [rows["a"], rows["q"]], {}
    return getattr(family, name), list(rows.values()), {}


@_call
def _exact(r: random.Random, place: Path) -> Call:  # noqa: ARG001
    found = st.exact_polynomial("spinning", "viscous")
    return found.coefficients, [[r.random() for _ in found.variables]], {}


@_call
def _landing(r: random.Random, place: Path) -> Call:  # noqa: ARG001
    return _hopf_point().landing, [r.uniform(-0.1, 0.1)], {"amplitude": 0.01}


@lru_cache(maxsize=1)
def _hopf_point() -> Any:
    return st.hopf("spinning", contact=st.Viscous(0.8))[0]


@_call
def _law_methods(r: random.Random, place: Path) -> Call:  # noqa: ARG001
    law = _any_law(r)
    mu = (0.3, 0.01) if isinstance(law, st.RegularisedCoulomb) else 0.3
    name = "power" if isinstance(law, st.Rough) else r.choice(["force", "power"])
    return getattr(law, name), [[0.3, 0.4], 1.0, mu], {}


QUANTITIES = ("final", "path", "outcome", "settling_time", "lift_off_time", "largest_tilt")
LINEAR = ("verdict", "growth_rate", "boundary")
RUNGS = ("steady", "linearised", "second-order", "creep", "rough", "creep-1", "viscous")


def _scene_words(r: random.Random) -> dict[str, Any]:
    laws = [
        st.Viscous(10 ** r.uniform(-2, 4)),
        st.LinearViscous(mu=10 ** r.uniform(-2, 4)),
        st.Coulomb(r.uniform(0.1, 0.5)),
        st.Rough(),
        st.Smooth(),
    ]
    contact: Any = r.choice(laws)
    if r.random() < 0.15:
        contact = dict(zip("ab", r.sample(laws, 2), strict=True))
    asked = r.sample(QUANTITIES, r.randint(1, 3))
    if r.random() < 0.15 and not isinstance(contact, st.Coulomb | dict):
        asked = [r.choice(LINEAR)]
    words = {
        "disk": st.Disk(k=r.uniform(0.25, 0.5)),
        "contact": contact,
        "start": {"theta": r.uniform(1.2, 1.9), "omega3": r.uniform(0, 1)},
        "horizon": 10 ** r.uniform(-1, 1.3),
        "tolerance": 10 ** r.uniform(-9, -1),
        "quantities": tuple(asked),
    }
    if r.random() < 0.3:
        words["uncertain"] = {n: 10 ** r.uniform(-6, -2) for n in r.sample(["theta", "k"], 1)}
    return words


def _system_words(r: random.Random) -> dict[str, Any]:
    family, asked = r.choice([(), (families()[0],)]), r.sample(QUANTITIES[:4], r.randint(1, 2))
    return {
        "disk": systems()[0],
        "contact": {"g": r.uniform(0.5, 2), "d": r.uniform(0, 1)},
        "start": [r.uniform(-1, 1), r.uniform(-1, 1)],
        "horizon": r.uniform(1, 20),
        "quantities": asked,
        "families": family,
        "uncertain": r.choice([{}, {"g": 0.1}]),
    }


def _answered(
    disk: Any,
    contact: Any,
    start: Any,
    horizon: Any,
    tolerance: Any = 1e-6,
    quantities: Any = (),
    uncertain: Any = None,
    families: Any = (),
) -> Any:
    """The answer to a scene, and all that it says."""
    more = {} if uncertain is None else {"uncertain": uncertain}
    scene = st.Scene(
        disk, contact, start, horizon, tolerance, quantities, families=families, **more
    )
    answer = scene.answer()
    return answer, answer.path, answer.report()


def _verified(
    disk: Any,
    contact: Any,
    start: Any,
    horizon: Any,
    tolerance: Any = 1e-6,
    quantities: Any = (),
    uncertain: Any = None,
    families: Any = (),
) -> Any:
    """The same, held against the full model."""
    more = {} if uncertain is None else {"uncertain": uncertain}
    return st.Scene(
        disk, contact, start, horizon, tolerance, quantities, families=families, **more
    ).verify()


@_call
def _scene(r: random.Random, place: Path) -> Call:  # noqa: ARG001
    return st.Scene, [], _scene_words(r)


@_call
def _scene_told(r: random.Random, place: Path) -> Call:  # noqa: ARG001
    return r.choice([_answered, _verified]), [], _scene_words(r)


@_call
def _scene_of_system(r: random.Random, place: Path) -> Call:  # noqa: ARG001
    return r.choice([_answered, _verified]), [], _system_words(r)


@_call
def _scene_only(r: random.Random, place: Path) -> Call:  # noqa: ARG001
    words = {"contact": st.Viscous(10 ** r.uniform(1, 3)), "quantities": ("final",)}
    return st.Scene(**_scene_words(r) | words).answer, [], {"only": r.choice(RUNGS)}


@_call
def _scene_file(r: random.Random, place: Path) -> Call:
    folder = Path(st.__file__).parents[1] / "examples" / "scenes"
    path = r.choice(sorted(folder.glob("*.toml")))
    if r.random() < 0.5:  # some of its characters are others
        text = list(path.read_text(encoding="utf-8"))
        for _ in range(r.randint(1, 4)):
            text[r.randrange(len(text))] = r.choice('0-.e[]{}"=,#\n x\0é')
        path = place / "scene.toml"
        path.write_text("".join(text), encoding="utf-8")
        return _refusing, [path], {}
    return st.Scene.from_toml, [path], {}


def _refusing(path: Path) -> Any:
    """A scene, or nothing where its file is refused as it may be."""
    try:
        return st.Scene.from_toml(path)
    except st.StabilityError as error:
        if found := too_much(str(error)):
            raise AssertionError(found) from error
        return None


@_call
def _reduced_model(r: random.Random, place: Path) -> Call:  # noqa: ARG001
    system = systems()[0]
    return st.ReducedModel, ["slow", system, lambda x, p: (x, p), lambda x, p: x], {}  # noqa: ARG005


WEIGHTY = (
    "scene_told",
    "scene_told",
    "scene_of_system",
    "scene_only",
    "spectrum",
    "stability_map",
    "boundaries",
    "drift",
    "hopf",
    "launch",
    "simulate",
    "spectrum_own",
    "map_own",
    "boundaries_own",
    "branch",
    "system",
    "mass_matrix",
    "system_methods",
    "family",
    "family_member",
    "family_methods",
    "Disk",
)
"""Calls that are made more often: they have more arguments."""


# --- what came back ---


def _nan_in(value: Any, depth: int = 0) -> str:
    """Where a result holds NaN; empty if nowhere."""
    if isinstance(value, (float, complex, np.ndarray)):
        array = np.asarray(value)
        return "NaN" if array.dtype.kind in "fc" and np.isnan(array).any() else ""
    if isinstance(value, xr.Dataset):
        named = {str(n): v.values for n, v in value.variables.items()}
    elif dataclasses.is_dataclass(value):
        named = {f.name: getattr(value, f.name) for f in dataclasses.fields(value)}
    elif isinstance(value, (list, tuple)):
        named = {str(i): v for i, v in enumerate(value)}
    elif isinstance(value, dict):
        named = {str(n): v for n, v in value.items()}
    else:
        return ""
    if depth < 3:
        for name, part in named.items():
            if name not in NAN_SAYS_NOTHING and (found := _nan_in(part, depth + 1)):
                return f"{name}: {found}"
    return ""


def _looked_at(value: Any) -> None:
    """Every attribute of a result of the package, and what it looks like."""
    if type(value).__module__.startswith("stability"):
        repr(value), str(value)
        for name in dir(value):
            if not name.startswith("_"):
                try:
                    part = getattr(value, name)
                    if name in ("tracked",):
                        part()
                except st.StabilityError:
                    pass


def _judged(call: Call, name: str) -> tuple[str, str]:
    """Outcome of a call and what is wrong with it."""
    target, positional, named = call
    if name == "report":
        signal.signal(signal.SIGALRM, _interrupt)
        signal.setitimer(signal.ITIMER_REAL, 1.0)
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            warnings.simplefilter("ignore", StabilityWarning)  # part of the answer
            result = target(*positional, **named)
            if name in SHORT:
                return "done", ""
            _looked_at(result)
        return "done", _nan_in(result) if not _given_nan(call) else ""
    except st.StabilityError as error:
        return "refused", too_much(str(error)) and f"{too_much(str(error))}: {str(error)[:200]!r}"
    except KeyboardInterrupt as stop:
        return "interrupted", too_much(str(stop)) if name == "report" else "interrupted"
    except TypeError as error:
        # Python's own refusal of words has no frame but the one above
        own = error.__traceback__ is not None and error.__traceback__.tb_next is None
        return "no signature", "" if own else _said(error)
    except BaseException as error:
        if isinstance(call[2].get("progress"), ca.Function) and "Error in Function::call" in str(
            error
        ):
            return "no signature", ""  # the user's own function raises, and is heard
        if traceback.extract_tb(error.__traceback__)[-1].filename == fuzz_values.__file__:
            return "no signature", ""  # so does the one that raises
        return "raised", _said(error)
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0)


def _said(error: BaseException) -> str:
    frames = traceback.extract_tb(error.__traceback__)
    ours = [f for f in frames if "/stability/" in f.filename] or frames
    where = f"{Path(ours[-1].filename).name}:{ours[-1].lineno} {ours[-1].name}"
    return f"{type(error).__name__} at {where}: {str(error)[:160]!r}"


def _given_nan(call: Call) -> bool:
    """Whether NaN went into a container of results, which only passes on what it was given."""
    return isinstance(call[0], type) and call[0].__name__ not in ("Disk",)


def _interrupt(*_: Any) -> None:
    raise KeyboardInterrupt


# --- cases ---


def made(seed: str, number: int, place: Path) -> tuple[str, Call, list[str], bool]:
    """The call of a number: its name, itself, what was made odd, and whether it is valid."""
    r = random.Random(f"{seed}:{number}")
    name = r.choice(list(CALLS) + list(WEIGHTY) * 3)
    target, positional, named = CALLS[name](r, place)
    if r.random() < 0.2:
        return name, (target, positional, named), [], True
    notes = []
    for _ in range(r.choice([1, 1, 1, 2])):
        slots: list[Any] = [*range(len(positional)), *named]
        kind = r.random()
        if kind < 0.03 and positional:
            positional.pop()
            notes.append("one word less")
        elif kind < 0.06:
            word, value = odd(r)
            positional.append(value)
            notes.append(f"one word more, {word}")
        elif kind < 0.09:
            word, value = odd(r)
            named[r.choice(["nothing", "at", "k", "contact", "disk", "x"])] = value
            notes.append(f"a keyword more, {word}")
        elif slots:
            slot = r.choice(slots)
            word, value = odd(r, positional[slot] if isinstance(slot, int) else named[slot])
            if isinstance(slot, int):
                positional[slot] = value
            else:
                named[slot] = value
            notes.append(f"{slot}: {word}")
    return name, (target, positional, named), notes, False


def case(seed: str, number: int, place: Path) -> dict[str, Any]:
    """Make one call; how it ended."""
    name, call, notes, valid = made(seed, number, place)
    outcome, detail = _judged(call, name)
    if valid and outcome in ("refused", "no signature"):
        detail = detail or f"a valid call is {outcome}"
    what = f"{name}({'; '.join(notes)})"
    return {
        "what": ascii(what)[:300],
        "status": "fault" if detail else outcome,
        "detail": ascii(detail),
    }


@contextmanager
def workplace() -> Iterator[Path]:
    """A folder for files, to which relative names lead too."""
    with tempfile.TemporaryDirectory() as name, chdir(name):
        yield Path(name)
