"""What machine and settings cannot spoil: memory, sizes, a matplotlibrc, a backend."""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import casadi as ca
import numpy as np
import pytest
from random_systems import hop

import stability as st
from stability.cli.terminal import starved

PLOT = [
    "map",
    "rolling",
    "--x",
    "at:1:2:4",
    "--y",
    "mu:0.1:1:4",
    "--out",
    "m.nc",
    "--plot",
    "m.png",
    "--force",
]


def command(words: list[str], place: Path, **environment: str) -> tuple[int, str, str]:
    done = subprocess.run(
        [sys.executable, "-m", "stability", *words],
        cwd=place,
        env=os.environ | environment,
        capture_output=True,
        text=True,
        check=False,
    )
    return done.returncode, done.stdout, done.stderr


@pytest.mark.long
def test_a_figure_is_the_same_whatever_the_users_settings_are(tmp_path: Path) -> None:
    assert command(PLOT, tmp_path)[::2] == (0, "")
    plain = (tmp_path / "m.png").read_bytes()
    odd = "text.usetex: True\nbackend: bogus\nfont.size: 40\nsavefig.bbox: tight\naxes.grid: True\n"
    (tmp_path / "matplotlibrc").write_text(odd)
    assert command(PLOT, tmp_path, MPLBACKEND="bogus")[::2] == (0, "")
    assert (tmp_path / "m.png").read_bytes() == plain


def test_too_little_memory_is_said_in_one_sentence(tmp_path: Path) -> None:
    words = "-m stability spectrum rolling --at 1 --mu 1"
    done = subprocess.run(
        ["bash", "-c", f"ulimit -v 300000; exec {sys.executable} {words}"],
        cwd=tmp_path,
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 2
    assert "292 MiB of memory" in done.stderr
    assert done.stderr.count("\n") == 1


@pytest.mark.parametrize(
    "error",
    [
        MemoryError(),
        RuntimeError("std::bad_alloc"),
        ImportError("x.so: failed to map segment from shared object"),
    ],
)
def test_the_end_of_memory_is_known_in_each_librarys_words(error: Exception) -> None:
    assert starved(error)
    assert not starved(KeyError("x"))


def test_a_library_that_does_not_load_within_a_limit_of_memory_is_short_of_it(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Xarray says "No module named 'h5py'" where that module did not fit."""
    error = ImportError("No module named 'h5py', backend not available.")
    assert not starved(error)
    monkeypatch.setattr("stability.cli.terminal.allowed_memory", lambda: 7 * 10**8)
    assert starved(error)


@pytest.mark.long
def test_every_limit_of_memory_gives_a_map_or_a_sentence(tmp_path: Path) -> None:
    words = "-m stability map rolling --x at:0.5:4:900 --y mu:0.01:10:900:log --out m.nc --force"
    ends = []
    for limit in range(500_000, 900_001, 10_000):
        done = subprocess.run(
            ["bash", "-c", f"ulimit -v {limit}; exec {sys.executable} {words}"],
            cwd=tmp_path,
            capture_output=True,
            text=True,
            check=False,
            timeout=120,
        )
        ends.append(done.returncode)
        assert done.returncode in (0, 2), (limit, done.stderr)
        assert done.returncode == 0 or done.stderr.count("\n") == 1, (limit, done.stderr)
    assert set(ends) == {0, 2}


SIZES: dict[str, Callable[[], Any]] = {
    "branch": lambda: st.branch(st.disk_family("tumbling", "rough"), 0.5, 1, [0.25], points=10**9),
    "hopf": lambda: st.hopf("spinning", contact=st.Viscous(1.0), points=2**64 - 1),
    "spectra": lambda: st.spectrum(  # the two broadcast to 10¹⁰ members
        "rolling", at=np.ones((10**5, 1)), contact=st.Viscous(np.ones(10**5))
    ),
    "map": lambda: st.stability_map("rolling", x=("at", 1, 2, 10**6), y=("mu", 1, 2, 10**6)),
    "scan": lambda: st.boundaries("rolling", axis=("at", 1, 2, 10**7), contact=st.Rough()),
    "workers": lambda: st.stability_map(
        "rolling", x=("at", 1, 2, 3), y=("mu", 1, 2, 3), workers=10**9
    ),
}


@pytest.mark.parametrize("name", SIZES)
def test_a_size_without_bound_is_refused_with_the_limit(name: str) -> None:
    with pytest.raises(st.StabilityError, match="at most"):
        SIZES[name]()


def test_spectra_in_pieces_are_the_spectra(monkeypatch: pytest.MonkeyPatch) -> None:
    """A user's family with unknowns and zeros that hold at some members only, and the disk's."""
    family = hop().family
    at = np.linspace(0.25, 0.4, 40).reshape(8, 5)

    def ask() -> list[st.Spectrum]:
        law = st.Viscous(np.linspace(0.1, 2, 5))
        return [
            st.spectrum("rolling", at=at * 4, contact=law),
            *(st.spectrum(family, at=at, escalate=e) for e in (True, False)),
        ]

    whole = ask()
    monkeypatch.setattr("stability.spectra.spectrum.PIECE", 70)  # one or seven members at once
    for one, other in zip(whole, ask(), strict=True):
        for name in ("eigenvalues", "radius", "codes", "states", "structural_zeros"):
            assert np.array_equal(getattr(one, name), getattr(other, name)), name
        assert np.array_equal(one.modes.participation, other.modes.participation)


@pytest.mark.long
def test_ten_million_spectra_stay_within_the_memory() -> None:
    code = (
        "import resource, numpy as np, stability as st\n"
        "at = np.linspace(0.5, 4, 10**7)\n"
        "s = st.spectrum('rolling', at=at, contact=st.Viscous(0.3))\n"
        "assert set(np.unique(s.codes)) <= {1, 2} and np.isfinite(s.eigenvalues).all()\n"
        "print(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 2**20)"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    assert float(done.stdout) < 6.0, "GiB"


@pytest.mark.parametrize("mu", [5e-324, 1e-200, 1e300])
def test_friction_of_any_size_gets_an_answer(mu: float) -> None:
    """Isolation of roots never ended where coefficients have thousands of digits."""
    found = st.boundaries("spinning", axis=("at", 0.02, 50, 31, "log"), contact=st.Viscous(mu))
    assert found.complete
    assert len(found) == (mu < 1)


CALLS: dict[str, tuple[Callable[[], Any], str]] = {
    "ragged at": (lambda: st.drift(at=[[1], [2, 3]], tilt=0.1, contact=st.Viscous(1.0)), "at is"),
    "long text": (lambda: st.Disk.named("x" * 5000), "known are quarter"),
    "graph": (lambda: st.stability_map("rolling", x=ca.SX.sym("q", 300), y=()), "x is a SX"),  # type: ignore[arg-type]
    "long double": (lambda: _spring(np.longdouble("1e4000")), "forcing is"),
    "words": (lambda: st.Viscous(0.3).force("ab", 1, 0.5), "of one number type"),
    "verdict": (lambda: st.Verdict(np.zeros(0)), "give undecided, stable, unstable, neutral"),
    "law": (lambda: st.disk_system(ca.DM(1)), "known are smooth"),  # type: ignore[arg-type]
    "flag": (lambda: st.write_map(_small(), "x.nc", overwrite=np.ones(2)), "True, False or"),  # type: ignore[arg-type]
    "shapes": (lambda: st.Disk(mass=[1, 2], radius=[1, 2, 3], gravity=1), "do not broadcast"),
    "sentence": (lambda: st.Condition(ca.SX(1), "{nothing}"), "braces"),
    "two names": (lambda: _spring(-1.0, ("q", "q")), "twice"),
    "values": (lambda: st.exact_polynomial("rolling", "rough").coefficients("ab"), "one number"),
}


def _small() -> Any:
    return st.stability_map("rolling", x=("at", 1, 2, 2), y=("mu", 1, 2, 2), boundaries=False)


def _spring(force: Any, states: tuple[str, ...] = ("q", "v")) -> st.System:
    x, m = ca.SX.sym("x", 2), ca.SX.sym("m")
    return st.System.from_mass_matrix(
        "spring",
        x,
        m,
        m,
        force,
        unknowns=("d_v",),
        rates={"q": x[1]},
        states=states,
        parameters=("m",),
    )


@pytest.mark.parametrize("name", CALLS)
def test_odd_arguments_get_one_short_line(name: str) -> None:
    call, sentence = CALLS[name]
    with pytest.raises(st.StabilityError) as caught:
        call()
    text = str(caught.value)
    assert sentence in text
    assert len(text) <= 300
    assert text.isprintable()
