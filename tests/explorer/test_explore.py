"""The file of the page and what it is made of; arguments that are refused."""

import json
import re
from pathlib import Path
from typing import Any

import casadi as ca
import numpy as np
import pytest

import stability as st
from stability.algebra.exact.routh import routh
from stability.algebra.number_types import numpy_algebra
from stability.algebra.program import Program
from stability.explorer import page
from stability.explorer.source import graph

FOLDER = Path(page.__file__).parent


def test_one_file_below_a_size_without_addresses(page_of_disk: Path) -> None:
    text = page_of_disk.read_text(encoding="utf-8")
    assert page_of_disk.stat().st_size < 1_500_000
    addresses = set(re.findall(r"(?:https?:)?//[a-z0-9.-]+\.[a-z]{2,}[^\s\"'`)<]*", text))
    assert {a for a in addresses if "www.w3.org" not in a} == set()
    assert "The MIT License" in text and "three.js authors" in text
    assert text.count("</script>") == 3


def test_every_module_is_joined_and_small() -> None:
    script = page.script()
    for path in sorted((FOLDER / "script").rglob("*.js")):
        name = path.relative_to(FOLDER / "script").with_suffix("").as_posix()
        assert f"const of_{re.sub(r'[^a-z0-9_]', '_', name)} = " in script, f"{name} is not used"
        lines = path.read_text(encoding="utf-8").splitlines()
        assert len(lines) < 400 and lines[0].startswith("// "), name
    assert not re.search(r"^(import|export) ", script, re.MULTILINE)


def test_the_library_is_pinned_and_names_no_registry() -> None:
    lock = (FOLDER / "library" / "package-lock.json").read_text(encoding="utf-8")
    assert "http" not in lock
    wanted = json.loads((FOLDER / "library" / "package.json").read_text(encoding="utf-8"))
    version = json.loads(lock)["packages"]["node_modules/three"]["version"]
    assert wanted["dependencies"]["three"] == version
    revision = version.split(".")[1]
    assert f'"{revision}"' in (FOLDER / "library" / "three.js").read_text(encoding="utf-8")


def test_every_operation_of_a_graph_is_written() -> None:
    x = ca.SX.sym("x", 2)
    rows = [
        x[0] + x[1],
        x[0] - 3,
        2 * x[1],
        x[0] / x[1],
        -x[0],
        x[0] ** 2,
        x[1] ** 3,
        1 / x[1],
        ca.sin(x[0]),
        ca.cos(x[0]),
        ca.tan(x[0]),
        ca.sqrt(x[1]),
        ca.exp(x[0]),
        ca.log(x[1]),
        ca.fabs(x[0]),
        ca.atan2(x[0], x[1]),
        x[1] ** 0.3,
        ca.sinh(x[0]),
    ]
    program = Program(ca.Function("f", [x], [ca.vertcat(*rows)]))
    source = graph(program)
    # JavaScript's operators are Python's, and its functions have names of their own
    lines = source.split("const ", 1)[1].rsplit(";\nreturn ", 1)[0]
    body = re.sub(r",(t\d+ = )", r"\n\1", lines)
    space: dict[str, Any] = {"a0": [0.7, 1.3], "Math": _Math()}
    exec(body, space)
    asked = source.rsplit("return ", 1)[1].rstrip(";}\n ")
    found = eval(asked, space)
    true = [float(v) for v in program.run(numpy_algebra(), [[0.7, 1.3]])[0]]
    assert found == pytest.approx(true, rel=1e-14)


class _Math:
    """JavaScript's Math."""

    abs, pow, asin, acos, atan = np.abs, np.power, np.arcsin, np.arccos, np.arctan

    def __getattr__(self, name: str) -> Any:
        return getattr(np, name)


def test_routh_counts_what_the_roots_say() -> None:
    generator = np.random.default_rng(3)
    stable = 0
    for _ in range(300):
        degree = int(generator.integers(2, 7))
        roots = generator.normal(-0.8, 1.0, degree // 2) + 1j * generator.normal(0, 2, degree // 2)
        real = generator.normal(-0.8, 1.0, degree % 2)
        poly = np.poly(np.concatenate([roots, roots.conj(), real])).real[::-1]
        every = bool(max([*roots.real, *real]) < 0)
        assert all(v > 0 for v in routh(poly.tolist())) == every
        stable += every
    assert 30 < stable < 270


@pytest.mark.parametrize(
    ("given", "said"),
    [
        ({"family": "wobbling"}, "wobbling"),
        ({"mu": -1.0}, "mu is -1"),
        ({"contact": "coulomb", "mu": 0.3}, "coulomb"),
        ({"disk": st.Disk(mass=[1.0, 2.0], radius=1.0, gravity=1.0)}, "mass is an array"),
        (
            {"disk": st.Disk(mass=1.0, radius=0.1, gravity=1.0), "family": "tumbling", "at": 4.0},
            "at is 4",
        ),
        ({"disk": 0.3}, "stability.Disk"),
        ({"family": "tumbling", "at": 4.0}, "at is 4"),
        ({"at": float("nan")}, "at is nan"),
        ({"at": [1.0, 2.0]}, "one number"),
        ({"x": ("foo", 1, 2)}, "foo"),
        ({"x": ("at", 2, 1)}, "x"),
        ({"body": 0.3}, "stability.Body"),
        ({"body": st.Torus(0.2), "disk": st.Disk()}, "body and disk are both given"),
        (
            {"body": st.Torus(0.2), "contact": "linear-viscous", "c": 0.1},
            "draws smooth, viscous or rough",
        ),
        ({"body": st.Torus(0.2), "family": "vertical"}, "not smooth at theta = 0"),
        ({"body": st.Torus(0.2), "family": "circling"}, "circling"),
        ({"body": st.Torus(0.2), "family": "rolling", "pole": 0}, "pole"),
        ({"pole": "pi"}, "pole"),
        ({"x": ("at", 0.0, 2.0, "log")}, "above zero"),
        ({"nu": 3.0}, "nu"),
    ],
)
def test_a_bad_argument_is_one_sentence(given: dict[str, Any], said: str, tmp_path: Path) -> None:
    target = tmp_path / "page.html"
    with pytest.raises(st.StabilityError) as error:
        st.explore(out=target, **given)
    assert said in str(error.value) and not target.exists()


def test_a_disk_may_be_given_as_the_body(tmp_path: Path) -> None:
    paths = [
        st.explore(certify=False, out=tmp_path / f"{name}.html", **{name: st.Disk(k=0.4)})
        for name in ("disk", "body")
    ]
    assert paths[0].read_text() == paths[1].read_text()


def test_a_bad_family_or_file_is_one_sentence(tmp_path: Path) -> None:
    x, p = ca.SX.sym("x", 2), ca.SX.sym("p")
    system = st.System(
        "oscillator", x, p, ca.vertcat(x[1], -x[0] - p * x[1]), states=("q", "v"), parameters=("c",)
    )
    rest = st.Family(system, "rest", at=("c",), held={"q": 0.0, "v": 0.0})
    with pytest.raises(st.StabilityError, match="a diagram needs two"):
        st.explore(rest, at=0.2, out=tmp_path / "page.html")
    with pytest.raises(st.StabilityError, match=r"\.html"):
        st.explore(out=tmp_path / "page.txt")
    (tmp_path / "page.html").write_text("mine")
    with pytest.raises(st.StabilityError):
        st.explore(out=tmp_path / "page.html")
    assert (tmp_path / "page.html").read_text() == "mine"


def test_a_missing_widget_library_is_one_sentence(monkeypatch: pytest.MonkeyPatch) -> None:
    import sys

    monkeypatch.setitem(sys.modules, "anywidget", None)
    with pytest.raises(st.StabilityError, match=r"pip install '\.\[widget\]'"):
        st.explore(certify=False)


@pytest.mark.long
def test_a_body_has_its_numbers_as_sliders(tmp_path: Path) -> None:
    path = st.explore(
        "rolling", body=st.Torus(0.2), mu=0.3, certify=False, out=tmp_path / "tyre.html"
    )
    text = path.read_text(encoding="utf-8")
    data = json.loads(re.search(r'id="data">(.*?)</script>', text, re.DOTALL)[1])["data"]
    keys = {s["key"] for s in data["subjects"]}
    assert {"rolling viscous", "spinning rough", "tumbling viscous", "tumbling smooth"} <= keys
    [start] = [s for s in data["subjects"] if s["key"] == "rolling viscous"]
    assert [q["name"] for q in start["quantities"]] == ["omega3", "tube", "mu"]
