"""C code of graphs: it compiles, its own example agrees, and a second caller sees the same."""

import ctypes
import subprocess
from pathlib import Path

import casadi as ca
import numpy as np
import pytest
from programs import needed

import stability as st
from stability.cli.commands import main

STRICT = ["cc", "-O1", "-std=c99", "-Wall", "-Wextra", "-Wno-unused", "-Werror"]


def run(code: object, folder: Path) -> subprocess.CompletedProcess[str]:
    needed("gcc", "cc")
    return subprocess.run(code, shell=True, cwd=folder, capture_output=True, text=True)  # type: ignore[call-overload,no-any-return]


@pytest.mark.outside
@pytest.mark.few(2)
@pytest.mark.parametrize("law", ["viscous", "rough", "smooth"])
def test_the_example_compiles_and_agrees(law: str, tmp_path: Path) -> None:
    code = st.c_code(st.disk_system(law), tmp_path / "disk", name=f"disk {law}")
    assert code.inputs == ("x", "p") and code.outputs == ("f", "J")
    done = run(code.command, code.folder)
    assert done.returncode == 0, done.stderr
    assert float(done.stdout.split()[-1]) <= 1e-12
    assert done.stdout.startswith(f"disk_{law}: ")


@pytest.mark.outside
def test_the_example_sees_a_wrong_number(tmp_path: Path) -> None:
    code = st.c_code(st.disk_system("viscous"), tmp_path, name="disk")
    example = tmp_path / "example.c"
    words = example.read_text()
    at = words.index("{0x", words.index("wanted[POINTS]"))
    example.write_text(words[: at + 1] + "9" + words[at + 1 :].replace("0x", "", 1))
    broken = example.read_text().replace("{9", "{0x1.9", 1)
    example.write_text(broken)
    done = run(code.command, tmp_path)
    assert done.returncode != 0


@pytest.mark.outside
def test_values_are_those_of_python_through_another_caller(tmp_path: Path) -> None:
    """The function called by ctypes at new points, against `System.rates` and `linearise`."""
    system = st.disk_system("viscous")
    st.c_code(system, tmp_path, name="disk")
    needed("gcc", "cc")
    done = subprocess.run(
        [*STRICT, "-shared", "-fPIC", "disk.c", "-lm", "-o", "disk.so"],
        cwd=tmp_path,
        capture_output=True,
        text=True,
    )
    assert done.returncode == 0, done.stderr
    library = ctypes.CDLL(str(tmp_path / "disk.so"))
    real = ctypes.POINTER(ctypes.c_double)
    rng = np.random.default_rng(3)
    for _ in range(20):
        x, p = rng.uniform(0.4, 1.3, 6), rng.uniform(0.2, 0.5, 2)
        f, slopes, work = np.zeros(6), np.zeros(36), np.zeros(1000)
        arg = (real * 8)(x.ctypes.data_as(real), p.ctypes.data_as(real))
        res = (real * 8)(f.ctypes.data_as(real), slopes.ctypes.data_as(real))
        assert library.disk(arg, res, (ctypes.c_longlong * 8)(), work.ctypes.data_as(real), 0) == 0
        assert f == pytest.approx(system.rates(x, p), rel=1e-13, abs=1e-13)
        assert slopes.reshape(6, 6).T == pytest.approx(system.linearise(x, p), rel=1e-11, abs=1e-11)


@pytest.mark.outside
def test_any_function_becomes_code_with_dense_outputs(tmp_path: Path) -> None:
    a, b = ca.SX.sym("a", 2, 2), ca.SX.sym("b")
    f = ca.Function("mixed", [a, b], [ca.diag(a[0, :].T) * b, ca.sin(b)], ["a", "b"], ["m", "s"])
    code = st.c_code(f, tmp_path, points=7)
    assert (code.inputs, code.outputs) == (("a", "b"), ("m", "s"))
    done = run(code.command, tmp_path)
    assert done.returncode == 0, done.stderr
    assert "at 7 points" in done.stdout


def test_what_is_no_graph_is_refused(tmp_path: Path) -> None:
    with pytest.raises(st.StabilityError, match=r"give a System, a Family, or a casadi\.Function"):
        st.c_code("rolling", tmp_path)  # type: ignore[arg-type]
    with pytest.raises(st.StabilityError, match="points is 0"):
        st.c_code(st.disk_system("rough"), tmp_path, points=0)
    x = ca.SX.sym("x")
    nowhere = st.System("nowhere", x, ca.SX(0, 1), ca.sqrt(-x), states=("x",), parameters=())
    with pytest.raises(st.StabilityError, match="no example can be made"):
        st.c_code(nowhere, tmp_path)
    assert not list(tmp_path.iterdir())


def test_files_stay_unless_they_may_be_replaced(tmp_path: Path) -> None:
    st.c_code(st.disk_system("rough"), tmp_path, name="disk")
    (tmp_path / "disk.c").write_text("mine")
    with pytest.raises(st.StabilityError, match="exists"):
        st.c_code(st.disk_system("rough"), tmp_path, name="disk")
    assert (tmp_path / "disk.c").read_text() == "mine"
    st.c_code(st.disk_system("rough"), tmp_path, name="disk", overwrite=True)
    assert "CASADI" in (tmp_path / "disk.c").read_text()


def test_two_calls_write_the_same_bytes(tmp_path: Path) -> None:
    for name in ("one", "two"):
        st.c_code(st.disk_system("viscous"), tmp_path / name, name="disk")
    for file in (tmp_path / "one").iterdir():
        assert file.read_bytes() == (tmp_path / "two" / file.name).read_bytes()


@pytest.mark.outside
def test_the_command_writes_code_of_a_system(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    place = str(Path(__file__).parents[2] / "examples" / "linear_bicycle.py:upright")
    assert main(["export", "c", "--system", place, "--out", str(tmp_path / "b"), "--json"]) == 0
    assert '"command": "cc -O2 example.c' in capsys.readouterr().out
    [source] = [p for p in (tmp_path / "b").glob("*.c") if p.name != "example.c"]
    done = run(f"cc -O2 example.c {source.name} -lm -o example && ./example", tmp_path / "b")
    assert done.returncode == 0, done.stderr
