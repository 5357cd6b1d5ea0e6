"""What to cite: chosen by what was used, the same on every worker, and the same in every file."""

import json
import re
from dataclasses import replace
from pathlib import Path
from typing import Any

import casadi as ca
import numpy as np
import pytest
import yaml

import stability as st
from stability.base.citation import WORKS
from stability.bodies.contact_laws import MOTION_LAWS
from stability.cli.commands import main
from stability.integrators.selection import METHODS as INTEGRATORS
from stability.integrators.taylor import available

ROOT = Path(__file__).resolve().parents[2]
MODEL = ["stability", "przybylska2016", "casadi"]
START = {"theta": 1.3, "omega3": 2.0}


def keys(result: Any) -> list[str]:
    return [work.key for work in st.citation(result).works]


def spring() -> st.System:
    x = ca.SX.sym("x", 2)
    rates = ca.vertcat(x[1], -x[0] - 0.1 * x[1])
    return st.System("spring", x, ca.SX(0, 1), rates, states=("q", "v"), parameters=())


# --- chosen by what was used ---


@pytest.mark.parametrize(
    ("method", "more"),
    [
        pytest.param("heyoka", ["heyoka"], marks=pytest.mark.long),  # it compiles
        ("dop853", ["scipy", "hairer1993"]),
        ("lsoda", ["scipy", "petzold1983"]),
        ("radau", ["scipy", "hairer1996"]),
        ("bdf", ["scipy", "shampine1997"]),
        ("cvodes", ["sundials"]),
    ],
)
def test_a_motion_cites_its_integrator(method: str, more: list[str]) -> None:
    if method == "heyoka":
        pytest.importorskip("heyoka")
    run = st.simulate(st.Disk(), st.Viscous(0.3), START, 1.0, method=method, check=False)
    assert run.attrs["method"] == method
    assert keys(run) == [*MODEL, *more]


def test_a_branch_of_a_body_cites_its_law() -> None:
    creeping = st.Torus(0.2).family("rolling", "creep-1")
    found = st.branch(creeping, 1.0, 2.0, points=3, tube=0.2, mu=20.0)
    assert keys(found) == [*MODEL[:2], "fenichel1979", "fraser1988", "casadi"]


def test_every_integrator_has_works() -> None:
    for method in INTEGRATORS.values():
        assert method.works and set(method.works) <= set(WORKS)


def test_statistics_cite_what_computed_the_labels() -> None:
    labels = st.launch_labels(
        st.Disk(),
        st.Viscous(0.3),
        varied=("tilt",),
        held={"omega3": 1.2},
        family="rolling",
        horizon=5.0,
    )
    runs = keys(labels)
    assert runs[:3] == MODEL
    assert keys(st.fatal_shock(labels, [0.1], budget=5)) == runs
    assert keys(st.fatal_shock(lambda p: p.sum(axis=1) > 3, [0, 0], reach=5)) == ["stability"]

    class Halves:
        citation = labels.citation

        def __call__(self, points: np.ndarray) -> np.ndarray:
            return np.asarray(points[:, 0] > 0.5)

    found = st.uncertainty_exponent(Halves(), [0], [1], [0.05, 0.1, 0.2], points=200)
    assert keys(found) == [*runs, "grebogi1983", "wilson1927"]


def test_a_limit_of_slip_cites_the_model() -> None:
    assert keys(st.painleve_limit(st.Disk())) == [*MODEL, "arb"]
    assert keys(st.painleve_limit(st.Torus(0.2))) == [*MODEL, "arb"]


def test_a_body_cites_the_work_whose_frames_and_friction_its_equations_have() -> None:
    """`bodies/newton_euler.py` names that work; the body is not a system of the user."""
    torus, law = st.Torus(0.2), st.Viscous(0.3)
    family = torus.family("spinning", "viscous")
    assert keys(st.spectrum("rolling", at=1.8, body=torus, contact=law)) == [*MODEL, "lapack"]
    assert keys(st.spectrum(family, at=1.8, tube=0.2, mu=0.3)) == [*MODEL, "lapack"]
    assert keys(st.conditions(torus.family("spinning", "rough"))) == [*MODEL, "arb"]
    assert keys(st.branch(family, 1.5, 2, tube=0.2, mu=0.3, points=3)) == MODEL
    edges = st.boundaries("spinning", axis=("at", 0.1, 5, 9), body=torus, contact=law)
    assert keys(edges) == [*MODEL, "arb"]
    plane: dict[str, Any] = {"x": ("at", 1, 3, 4), "y": ("mu", 0.1, 1, 3)}
    assert keys(st.stability_map("spinning", body=torus, **plane))[:3] == MODEL
    assert "bodies of revolution" in st.citation().text


def test_a_motion_of_a_users_system_cites_no_disk() -> None:
    run = st.simulate(spring(), None, [1.0, 0.0], 1.0, method="dop853")
    assert keys(run) == ["stability", "casadi", "scipy", "hairer1993"]


def test_a_motion_of_a_body_cites_the_model_with_resistance_or_without() -> None:
    start = {"theta": 1.3, "omega3": 2.0}
    bare = {"method": "dop853", "check": False}
    body = st.simulate(st.Torus(0.2), st.Viscous(0.3), start, 0.5, **bare)
    assert keys(body) == [*MODEL, "scipy", "hairer1993"]
    resisted = st.simulate(
        st.Torus(0.2), st.Viscous(0.3), start, 0.5, **bare, resistance=st.RollingResistance(0.01)
    )
    assert keys(resisted) == [*MODEL, "scipy", "hairer1993"]


def test_dry_friction_cites_the_paper_on_it() -> None:
    run = st.simulate(st.Disk(), st.Coulomb(0.3), START, 0.5, check=False)
    assert keys(run)[:3] == ["stability", "przybylska2016", "lesaux2005"]


def test_a_proof_is_cited_where_one_was_made() -> None:
    plain = st.spectrum("rolling", at=1.8, contact=st.Viscous(0.3))
    assert keys(plain) == [*MODEL, "lapack"]
    proved = st.spectrum("rolling", at=1.8, contact=st.Viscous(0.3), certify=True)
    assert keys(proved) == [*MODEL, "lapack", "arb"]
    assert keys(proved.to_xarray()) == keys(proved)


def test_another_eigensolver_is_not_lapack() -> None:
    def slow(matrices: Any) -> Any:
        return np.linalg.eig(matrices)

    with st_eigensolver(slow):
        found = st.spectrum("rolling", at=1.8, contact=st.Viscous(0.3))
    assert "lapack" not in keys(found)


def st_eigensolver(solver: Any) -> Any:
    from stability.algebra.eigensolver import eigensolver

    return eigensolver(solver)


def test_maps_boundaries_conditions_and_basins_say_what_to_cite(tmp_path: Path) -> None:
    axes: dict[str, Any] = {"x": ("at", 1, 3, 5), "y": ("mu", 0.1, 1, 4)}
    plane = st.stability_map("spinning", **axes)
    assert keys(plane) == [*MODEL, "arb"]
    assert keys(st.read_map(st.write_map(plane, tmp_path / "map.nc"))) == keys(plane)
    edges = st.boundaries("spinning", axis=("at", 0.1, 5, 9), contact=st.Viscous(0.97))
    assert keys(edges) == [*MODEL, "arb"]
    assert keys(st.conditions(st.disk_family("spinning", "rough"))) == [*MODEL, "arb"]
    lots = st.basins(
        st.Disk(), st.Viscous(0.3), x=("theta", 1.2, 1.5, 2), y=("omega3", 1, 2, 2), horizon=1.0
    )
    assert keys(lots) == [*MODEL, *(["heyoka"] * available())]


def test_basins_cite_the_lanes_and_the_linear_verdict_where_they_ran(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    near: dict[str, Any] = {
        "contact": "viscous",
        "mu": 0.3,
        "family": "spinning",
        "horizon": 1.0,
        "x": ("at", 1.0, 3.0, 2),
        "y": ("tilt", 0.1, 0.2, 2),
    }
    lanes = ["heyoka"] * available()
    assert keys(st.basins(**near)) == [*MODEL, "lapack", "arb", *lanes]
    monkeypatch.setattr("stability.basin.outcomes.available", lambda: False)
    assert keys(st.basins(**near)) == [*MODEL, "lapack", "arb"]
    dry: dict[str, Any] = {"x": ("theta", 1.2, 1.5, 2), "y": ("omega3", 1, 2, 2), "horizon": 0.1}
    assert keys(st.basins(st.Disk(), st.Coulomb(0.3), **dry))[1:3] == MODEL[1:2] + ["lesaux2005"]


def test_an_answer_cites_the_rung_that_answered() -> None:
    creeping = st.Scene(contact=st.Viscous(3000.0), start=START, horizon=20.0, tolerance=1e-6)
    found = creeping.answer()
    assert found.model == "creep-1"
    assert keys(found) == ["stability", "przybylska2016", "fenichel1979", "fraser1988", "casadi"]
    whole = creeping.answer(only="viscous")
    assert keys(whole)[:3] == MODEL
    assert set(keys(whole)[3:]) <= {key for method in INTEGRATORS.values() for key in method.works}
    assert keys(whole)[3:]
    laws = {"wet": st.Viscous(0.3), "dry": st.Coulomb(0.3)}
    both = st.Scene(contact=laws, start=START, horizon=1.0, tolerance=1e-3).answer()
    assert {"przybylska2016", "lesaux2005"} <= set(keys(both))


def test_every_law_is_known_to_the_choice() -> None:
    from stability.base.citation import LAWS

    assert set(LAWS) <= set(MOTION_LAWS)


# --- the same everywhere, and readable ---


def test_a_citation_holds_no_date_and_no_version() -> None:
    run = st.simulate(st.Disk(), st.Viscous(0.3), START, 1.0)
    assert re.fullmatch(r"[a-z0-9]+(, [a-z0-9]+)*", run.attrs["citation"])


def test_entries_of_bibtex_are_whole() -> None:
    for work in WORKS.values():
        text = work.bibtex
        assert text.count("{") == text.count("}")
        assert text.isascii()
        kind, key = re.match(r"@(\w+)\{(\w+),\n", text).groups()  # type: ignore[union-attr]
        assert key == work.key
        fields = dict(re.findall(r"^  (\w+) = \{(.*)\},?$", text, re.MULTILINE))
        need = {
            "article": {"author", "title", "journal", "year"},
            "book": {"publisher", "year"},
            "misc": {"title", "note"},
            "inproceedings": {"booktitle"},
        }[kind]
        assert need <= set(fields), key
        assert not work.doi or re.fullmatch(r"10\.\d{4,}/\S+", work.doi)


def test_it_prints_as_text_and_bibtex() -> None:
    found = st.citation()
    assert str(found) == f"{found.text}\n\n{found.bibtex}"
    assert [w.key for w in found.works] == ["stability", "przybylska2016"]
    assert "doi:10.1134/S1560354716020052" in found.text


@pytest.mark.parametrize("nothing", [3.0, "a text", {"a": 1}, Path(__file__)])
def test_what_says_nothing_is_refused(nothing: Any) -> None:
    with pytest.raises(st.StabilityError, match=r"says nothing of what to cite|^a text cannot be"):
        st.citation(nothing)


def test_a_work_of_a_later_version_is_named() -> None:
    run = st.simulate(st.Disk(), st.Viscous(0.3), START, 1.0).assign_attrs(citation="stability, x9")
    with pytest.raises(st.StabilityError, match="cites 'x9'"):
        st.citation(run)


def test_the_command_cites_a_file(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    run = st.simulate(st.Disk(), st.Viscous(0.3), START, 1.0, method="dop853")
    path = st.write_motion(run, tmp_path / "run.nc")
    assert main(["cite", str(path)]) == 0
    assert capsys.readouterr().out.rstrip("\n") == st.citation(run).text
    assert main(["cite", str(path), "--json"]) == 0
    assert [w["key"] for w in json.loads(capsys.readouterr().out)["works"]] == keys(run)
    store = tmp_path / "map.zarr"
    st.stream_map("spinning", x=("at", 1, 3, 5), y=("mu", 0.1, 1, 4), out=store)
    assert main(["cite", str(store), "--bibtex"]) == 0
    assert capsys.readouterr().out.rstrip("\n") == st.citation(st.read_map(store)).bibtex
    assert main(["cite"]) == 0
    assert capsys.readouterr().out.rstrip("\n") == st.citation().text
    (tmp_path / "no.nc").write_text("no")
    assert main(["cite", str(tmp_path / "no.nc")]) == 2
    assert "cannot be read as NetCDF" in capsys.readouterr().err


def test_the_fields_of_the_package_reach_its_entry() -> None:
    """Year, address and DOI are filled in works.json once, and stand in the text and in BibTeX."""
    filled = {"year": "2027", "url": "https://example.org/s", "doi": "10.5281/zenodo.1"}
    own = replace(st.citation().works[0], author="Rossi, Ada and Bo, Cy", **filled)
    for name, value in filled.items():
        assert f"  {name} = {{{value}}}" in own.bibtex
    assert own.text.startswith("A. Rossi and C. Bo, ")
    assert own.text.endswith("2027, https://example.org/s, doi:10.5281/zenodo.1")


def test_the_citation_file_says_the_same() -> None:
    """CITATION.cff, pyproject.toml and `st.citation` agree."""
    cff = yaml.safe_load((ROOT / "CITATION.cff").read_text())
    own, paper = st.citation().works
    project = (ROOT / "pyproject.toml").read_text()
    assert cff["title"] == own.title
    assert f"version {st.__version__}" == own.place
    assert "version" not in cff  # it stands in one place, stability/base/version.py
    assert f'license = "{cff["license"]}"' in project
    assert [a["name"] for a in cff["authors"]] == [own.author.strip("{}")]
    year = str(cff.get("date-released", ""))[:4]
    assert (year, cff.get("url", ""), cff.get("doi", "")) == (own.year, own.url, own.doi)
    [reference] = cff["references"]
    assert reference["doi"] == paper.doi
    assert reference["title"] == paper.title
    assert f"{reference['start']}--{reference['end']}" == paper.pages
    assert f"{reference['volume']}({reference['issue']})" == paper.volume
    assert str(reference["year"]) == paper.year
    people = [f"{a['family-names']}, {a['given-names']}" for a in reference["authors"]]
    assert " and ".join(people) == paper.author
