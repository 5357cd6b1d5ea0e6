"""Every public name that returns a result says what to cite, or there is a stated reason."""

import inspect
import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import casadi as ca
import pytest

import stability as st
from stability.base.citation import WORKS, cited, gathered
from stability.base.lazy import HOMES

VISCOUS = st.Viscous(0.97)
PLANE: dict[str, Any] = {"x": ("at", 1, 3, 5), "y": ("mu", 0.1, 1, 4)}
SMALL: dict[str, Any] = {"horizon": 1.0, "x": ("theta", 1.2, 1.5, 2), "y": ("omega3", 1, 2, 2)}
OSCILLATOR = ["stability", "kuznetsov2004", "casadi", "arb"]
DISK = ["stability", "przybylska2016", "casadi"]


def _oscillator() -> st.Family:
    x, c = ca.SX.sym("x", 2), ca.SX.sym("c")
    rates = ca.vertcat(x[1], -x[0] + (c - x[0] ** 2) * x[1])
    system = st.System("van der Pol", x, c, rates, states=("q", "v"), parameters=("c",))
    return st.Family(system, "rest", at=("c",), held={"q": 0, "v": 0})


def _motion() -> Any:
    return st.simulate(
        st.Disk(), st.Viscous(0.3), {"theta": 1.3, "omega3": 2.0}, 0.5, method="dop853", check=False
    )


def _again(folder: Path) -> Any:
    return st.read_map(st.write_map(st.stability_map("spinning", **PLANE), folder / "map.nc"))


def _motion_again(folder: Path) -> Any:
    path = st.write_motion(_motion(), folder / "run.nc")
    return st.read_motion(path)


def _launches_again(folder: Path) -> Any:
    st.basins(st.Disk(), st.Viscous(0.3), **SMALL, store=folder / "launches.zarr")
    return st.read_basins(folder / "launches.zarr")


def _streamed(folder: Path) -> Any:
    return st.read_map(st.stream_map("spinning", **PLANE, out=folder / "map.zarr"))


def _scene() -> st.Scene:
    return st.Scene(start={"theta": 1.3, "omega3": 2.0}, contact=st.Viscous(0.3), horizon=1.0)


def _side(points: Any) -> Any:
    return points[:, 0] > points[:, 1] ** 2


RESULTS: dict[str, tuple[Callable[[Path], Any], list[str]]] = {
    "spectrum": (lambda _: st.spectrum("rolling", at=1.8, contact=VISCOUS), [*DISK, "lapack"]),
    "stability_map": (lambda _: st.stability_map("spinning", **PLANE), [*DISK, "arb"]),
    "stream_map": (_streamed, [*DISK, "arb"]),
    "read_map": (_again, [*DISK, "arb"]),
    "boundaries": (
        lambda _: st.boundaries("spinning", axis=("at", 0.1, 5, 9), contact=VISCOUS),
        [*DISK, "arb"],
    ),
    "branch": (
        lambda _: st.branch(st.disk_family("tumbling", "viscous"), 1.5, 1, k=0.2, mu=0.3, points=3),
        DISK,
    ),
    "launch_labels": (
        lambda _: st.launch_labels(
            contact="viscous", mu=0.3, family="spinning", horizon=3.0, varied=("phi_dot", "tilt")
        ),
        DISK,
    ),
    "conditions": (lambda _: st.conditions(st.disk_family("spinning", "rough")), [*DISK, "arb"]),
    "exact_polynomial": (lambda _: st.exact_polynomial("rolling", "viscous"), [*DISK, "arb"]),
    "drift": (lambda _: st.drift(at=1.8, tilt=0.01, contact=VISCOUS), DISK[:2]),
    "hopf": (
        lambda _: st.hopf("spinning", contact=VISCOUS),
        [*DISK[:2], "fiedler2000", "casadi", "arb"],
    ),
    "slow_flow": (
        lambda _: st.slow_flow(
            "rolling", body=st.Spheroid(0.5), contact=VISCOUS, resistance=st.RollingResistance(0.01)
        ),
        [*DISK[:2], "fenichel1979", "casadi"],
    ),
    "retrograde_map": (lambda _: st.retrograde_map([1.0], [0.0], starts=[(80.0, 1.0)]), DISK),
    "painleve_limit": (lambda _: st.painleve_limit(st.Torus(0.2)), [*DISK, "arb"]),
    "codimension_two": (
        lambda _: st.codimension_two("spinning", x=("at", 0.5, 5, 9), y=("mu", 0.1, 3, 9)),
        [*DISK[:2], "kuznetsov2004", "casadi", "arb"],
    ),
    "simulate": (lambda _: _motion(), [*DISK, "scipy", "hairer1993"]),
    "read_motion": (_motion_again, [*DISK, "scipy", "hairer1993"]),
    "basins": (lambda _: st.basins(st.Disk(), st.Viscous(0.3), **SMALL), DISK),
    "read_basins": (_launches_again, DISK),
    "Scene": (lambda _: _scene().answer(), DISK),
    "table": (lambda _: st.table("drift", k=0.25, mu=1), DISK[:2]),
    "fractions": (lambda _: st.fractions([0, 1, 1]), ["stability", "wilson1927"]),
    "uncertainty_exponent": (
        lambda _: st.uncertainty_exponent(_side, [0, 0], [1, 1], [0.01, 0.02, 0.05], points=200),
        ["stability", "grebogi1983", "wilson1927"],
    ),
    "fatal_shock": (lambda _: st.fatal_shock(_side, [0.5, 0.2]), ["stability"]),
}
"""Name: a call of it, and works that it cites among others."""

INPUT = "it says what is asked, and holds no result"
WORD = "a word, an error or a warning"
PART = "a part of a result that says what to cite"
TEXT = "files or text written from a system; what was computed with them is cited by its result"
DRAWN = "drawn from a result that says what to cite"
COUNT = "two numbers alone; the record of fractions says what to cite"
REASONS = {
    **dict.fromkeys(
        (
            "Disk",
            "REAL_DISKS",
            "Body",
            "Egg",
            "from_profile",
            "Torus",
            "Spheroid",
            "EccentricSphere",
            "ThickDisk",
            "AirTorque",
            "PivotingResistance",
            "RollingResistance",
            "Resistance",
            "Contact",
            "Parameter",
            "Smooth",
            "Viscous",
            "LinearViscous",
            "Rough",
            "Coulomb",
            "RegularisedCoulomb",
            "Creep",
            "System",
            "mechanics",
            "linear",
            "tabulated",
            "Condition",
            "UPRIGHT",
            "Family",
            "disk_family",
            "disk_system",
            "launch",
            "Ball",
            "LogUniform",
            "Normal",
            "Uniform",
            "ReducedModel",
            "ExactPolynomial",
        ),
        INPUT,
    ),
    **dict.fromkeys(
        (
            "Verdict",
            "Nonlinear",
            "Crossing",
            "HopfKind",
            "Evidence",
            "Onset",
            "PointKind",
            "Outcome",
            "StabilityError",
            "StabilityWarning",
        ),
        WORD,
    ),
    **dict.fromkeys(
        (
            "BranchPoint",
            "Fold",
            "BoundaryPoint",
            "AxisCrossing",
            "Unresolved",
            "CurveOfZeros",
            "DegeneratePoint",
            "Rung",
        ),
        PART,
    ),
    **dict.fromkeys(
        (
            "Spectrum",
            "Boundaries",
            "Crossings",
            "Conditions",
            "Drift",
            "HopfPoint",
            "CycleBirth",
            "SlowFlow",
            "CodimensionTwo",
            "Equilibria",
            "Exact",
            "Answer",
            "Table",
            "Branch",
            "PainleveLimit",
        ),
        "the class of a result; the function that makes it is tested",
    ),
    **dict.fromkeys(
        (
            "latex",
            "c_code",
            "auto_input",
            "bifurcationkit_input",
            "write_map",
            "write_motion",
            "report",
        ),
        TEXT,
    ),
    **dict.fromkeys(
        (
            "animate",
            "plot_map",
            "plot_retrograde",
            "plot_basins",
            "plot_locus",
            "plot_motion",
            "explore",
        ),
        DRAWN,
    ),
    "wilson": COUNT,
    **dict.fromkeys(("citation", "Citation"), "it is what is asked for"),
}
"""Name: why it needs no citation of its own."""


def test_every_public_name_is_cited_or_has_a_reason() -> None:
    assert sorted([*RESULTS, *REASONS]) == sorted(HOMES)


def test_what_has_no_citation_is_no_dataset_and_no_record_that_is_cited() -> None:
    """A new function that returns a cited kind of result belongs to those that are tested."""
    kinds = ["Dataset", *(n for n in HOMES if hasattr(getattr(st, n), "citation"))]
    for name in REASONS:
        found = getattr(st, name)
        if inspect.isfunction(found):
            returned = str(inspect.signature(found).return_annotation)
            assert name == "citation" or not any(kind in returned.split(".") for kind in kinds)


@pytest.mark.parametrize("name", sorted(RESULTS))
def test_a_result_says_what_to_cite(name: str, tmp_path: Path) -> None:
    make, among = RESULTS[name]
    found = [work.key for work in st.citation(make(tmp_path)).works]
    assert [key for key in found if key in among] == among


TABLES: dict[str, tuple[dict[str, Any], list[str]]] = {
    "list": ({}, ["stability"]),
    "families": ({}, [*DISK[:2], "sympy", "casadi", "arb"]),
    "conditions": ({"k": 0.25, "mu": 1.0, "contact": "viscous"}, [*DISK, "arb"]),
    "drift": ({"k": 0.25, "mu": 1}, DISK[:2]),
    "hopf": ({"k": 0.5, "mu": 1.0}, [*DISK[:2], "fiedler2000", "casadi", "arb"]),
    "codimension": (
        {"family": "spinning", "x": ("at", 0.5, 5, 9), "y": ("mu", 0.1, 3, 9)},
        [*DISK[:2], "kuznetsov2004", "casadi", "arb"],
    ),
}


@pytest.mark.parametrize(
    "name",
    [
        pytest.param(n, marks=pytest.mark.long if n in ("conditions", "families") else ())
        for n in TABLES
    ],
)
def test_a_table_cites_what_its_rows_are_from(name: str) -> None:
    options, among = TABLES[name]
    found = [work.key for work in st.citation(st.table(name, **options)).works]
    assert sorted(set(found) & set(among)) == sorted(among)
    assert not {"heyoka", "scipy", "sundials"} & set(found)  # none runs motions


def test_tables_of_a_users_family_cite_its_result_and_no_disk() -> None:
    family = _oscillator()
    hopf = st.table("hopf", family, x=("c", -1, 1, 9))
    assert [w.key for w in st.citation(hopf).works] == OSCILLATOR
    assert [w.key for w in st.citation(st.hopf(family, axis=("c", -1, 1, 9))).works] == OSCILLATOR
    assert json.loads(hopf.to_json())["citation"] == hopf.citation
    assert st.branch(family, -1, 1, points=3).citation == "stability, casadi"
    exact = st.table("conditions", family)
    assert [w.key for w in st.citation(exact).works] == ["stability", "casadi", "arb"]


def test_every_table_cites_works_that_are_known() -> None:
    from stability.tables.registry import PLACES, definition

    for name in PLACES:
        keys = definition(name).cites.split(", ")
        assert keys[0] == "stability" and set(keys) <= set(WORKS)


def test_a_map_with_points_cites_what_they_are_from() -> None:
    with_points = st.stability_map("spinning", **PLANE, points=True)
    assert "kuznetsov2004" in with_points.attrs["citation"]
    assert "kuznetsov2004" not in st.stability_map("spinning", **PLANE).attrs["citation"]


def test_results_are_gathered_inside_only_and_reach_the_one_around() -> None:
    with gathered() as outer:
        cited(methods=["sundials"])
        with gathered() as inner:
            cited(methods=["heyoka"])
    cited(methods=["scipy"])
    assert inner == ["stability, casadi, heyoka"]
    assert outer == ["stability, casadi, sundials", *inner]


def test_a_list_is_cited_only_where_each_of_it_is() -> None:
    [point] = st.hopf("spinning", contact=st.Viscous(0.8))
    assert st.citation([point, point]) == st.citation(point)
    for nothing in ([], [point, 3.0]):
        with pytest.raises(st.StabilityError, match="says nothing of what to cite"):
            st.citation(nothing)
