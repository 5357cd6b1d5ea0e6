"""Random command lines: valid ones from a grammar, three in four with one to three mutations.

Each runs `stability.cli.main` in this process with captured descriptors.  A valid line must
end with 0; any line with 0 or 2 (130 where it is interrupted on purpose), a message of at most two
short lines, nothing in the folder after a refusal, and JSON that is strict.
"""

from __future__ import annotations

import json
import math
import os
import random
import shutil
import signal
import sys
import tempfile
import traceback
from collections.abc import Iterator
from contextlib import chdir, contextmanager
from pathlib import Path
from typing import Any

from fuzz import too_much

NAMES = ("rolling", "spinning", "tumbling", "circling")
SPECTRAL = ("viscous", "linear-viscous", "smooth", "rough")
DISKS = ("quarter", "le-saux", "gymnastics-hoop")
METHODS = ("auto", "heyoka", "dop853", "lsoda", "radau", "bdf", "cvodes", "idas")
VERDICTS = {"stable", "unstable", "neutral", "undecided"}
SCENES = ("spun-coin", "stiff-launch", "near-threshold-roll")
"""Scenes of one viscous law among the examples."""
INTERRUPTED = ("atlas", "chart", "failures", "report")
"""Commands of minutes, which are stopped by Ctrl-C after a moment where they begin at all."""
MOMENT = 1.0
"""Seconds after which they are stopped."""
AGAIN = 5.0
"""Seconds to the next interruption: Python drops one that falls into a destructor."""
ODD = (
    "",
    " ",
    "0",
    "-0",
    "-0.0",
    "1",
    "-1",
    "0.5",
    "1e308",
    "-1e308",
    "1e309",
    "1e-308",
    "5e-324",
    "nan",
    "-nan",
    "inf",
    "-inf",
    "NaN",
    "infinity",
    "1_000",
    "0x10",
    "1e",
    ".",
    "1.",
    ".5",
    "+1",
    "1,2",
    "1,,2",
    ",",
    "1,2,3",
    "1e400",
    "9" * 400,
    "18446744073709551615",
    "1000000000",
    "99999999999999999999",
    "1e12",
    "1e-12",
    "1e6",
    "1e5",
    "3.141592653589793",
    "0.1 0.2",
    "½",
    "−1",
    "٣",
    "①",
    "x",
    "rolling",
    "viscous",
    "coulomb",
    "x" * 5000,
    "ä" * 400,
    "\udcff",
    "a\0b",
    "a\nb\nc\nd",
    "\x1b[31m",
    "\u202e",
    "%s",
    "{0}",
    "$HOME",
    "~",
    "..",
    "/",
    ".",
    "-",
    "--",
    "---",
    "at:1:2:5",
    "at:1:2:5:log",
    "mu:0.1:1:4",
    "k:0.1:0.5:3",
    "at:0:0:0",
    "at:1:2:1000000000",
    "at:1:2:99999999999999999999",
    "at:::",
    ":::",
    "at:nan:inf:5",
    "at:1:2:-3",
    "at:1e308:2e308:4",
    "at:-1e308:1e308:4",
    "at:1:1.0000000000000002:9",
    "AT:1:2:3",
    "lean:0:1:4",
    "lean:-1:1:4",
    "mass:1:2:3",
    "gravity:1:2:3",
    "c:0.1:1:3",
    "theta:0.1:1:3",
    "phi_dot:1:2:3",
    "out.nc",
    "exists.nc",
    "exists.png",
    "folder",
    "folder/x.nc",
    "missing/x.nc",
    "/proc/x.nc",
    "/dev/null",
    "x.png",
    "x.pdf",
    "x.svg",
    "x.html",
    "x.gif",
    "x.txt",
    "loop",
    "full",
    "n" * 300 + ".nc",
    "quarter",
    "conditions",
    "families",
    "spectrum",
    "motion",
    "true",
    "None",
    "[1]",
    "1j",
    "1;2",
)
OPTIONS = (
    "--at",
    "--lean",
    "--mu",
    "--contact",
    "--disk",
    "--k",
    "--mass",
    "--radius",
    "--gravity",
    "--certify",
    "--json",
    "--x",
    "--y",
    "--out",
    "--plot",
    "--levels",
    "--modes",
    "--verdict-only",
    "--checkpoint",
    "--force",
    "--resolution",
    "--theta",
    "--theta-dot",
    "--phi-dot",
    "--omega3",
    "--slip-x",
    "--slip-y",
    "--epsilon",
    "--time",
    "--points",
    "--method",
    "--tolerance",
    "--no-check",
    "--verify",
    "--only",
    "--pose",
    "--film",
    "--tilt",
    "--latex",
    "--workers",
    "--help",
    "--version",
    "-h",
    "--nothing",
    "-x",
    "-1",
)

Words = list[str]


def _near(r: random.Random, low: float, high: float) -> str:
    value = math.exp(r.uniform(math.log(low), math.log(high)))
    return r.choice([f"{value:.3g}", repr(value), f"{value:.2e}"])


def _body(r: random.Random) -> Words:
    if r.random() < 0.2:
        return ["--disk", r.choice(DISKS)]
    words = ["--k", r.choice(["0.25", "0.5", "0.3125", _near(r, 0.01, 0.5)])] * (r.random() < 0.5)
    return words + _scales(r) * (r.random() < 0.3)


def _scales(r: random.Random) -> Words:
    names = ("--mass", "--radius", "--gravity")
    return [word for name in names for word in (name, _near(r, 0.05, 20))]


def _law(r: random.Random, laws: tuple[str, ...], *, mu: bool = True) -> Words:
    law = r.choice(laws)
    words = [] if law == "viscous" and r.random() < 0.7 else ["--contact", law]
    if law in ("smooth", "rough"):
        return ["--contact", law]
    return words + (["--mu", _near(r, 0.02, 20)] if mu else [])


def _at(r: random.Random, family: str) -> str:
    if family == "tumbling":
        return f"{r.uniform(0.15, 1.5):.4g}"
    if family == "circling":
        return f"{r.uniform(0.6, 2.4):.4g},{r.uniform(0.8, 3):.4g}"
    return ("-" if r.random() < 0.1 else "") + _near(r, 0.2, 6)


def _spectrum(r: random.Random) -> Words:
    family = r.choice(NAMES)
    law = ["--contact", "rough"] if family == "circling" else _law(r, SPECTRAL)
    place = ["--at", _at(r, family)]
    if family == "tumbling" and r.random() < 0.3:
        place = ["--lean", f"{r.uniform(-1, 1):.3g}"]
    certify = ["--certify"] * (r.random() < 0.2)
    return ["spectrum", family, *place, *law, *_body(r), *certify]


def _axis(r: random.Random, name: str) -> str:
    low, high = {
        "at": (0.3, 1.4),
        "mu": (0.05, 4),
        "k": (0.1, 0.5),
        "mass": (0.5, 2),
        "radius": (0.5, 2),
        "gravity": (1, 10),
        "lean": (0.1, 1.2),
        "theta": (0.7, 1.3),
        "phi_dot": (1, 2),
    }[name]
    return f"{name}:{low}:{high}:{r.randint(2, 9)}" + ":log" * (r.random() < 0.3)


def _map(r: random.Random) -> Words:
    family = r.choice(NAMES)
    rough = family == "circling"
    place = "theta" if rough else "lean" if family == "tumbling" and r.random() < 0.3 else "at"
    other = "phi_dot" if rough else r.choice(["mu", "mu", "mu", "k", "radius"])
    law = ["--contact", "rough"] if rough else _law(r, SPECTRAL[:2], mu=other != "mu")
    axes = [_axis(r, place), _axis(r, other)]
    r.shuffle(axes)
    if other == "radius":  # units are given whole
        law += ["--mass", _near(r, 0.05, 20), "--gravity", _near(r, 0.05, 20)]
    words = ["map", family, "--x", axes[0], "--y", axes[1], *law, "--out", "out.nc"]
    kind = r.random()
    if kind < 0.1:
        words += ["--certify", "--levels", str(r.randint(1, 5))]
    elif kind < 0.2 and not rough:
        return [*words, "--verdict-only"]
    elif kind < 0.25:
        words += ["--checkpoint", "kept"]
    elif kind < 0.28:
        words += ["--plot", "x.png"]
    elif kind < 0.35:
        words[-1] = "out.zarr"  # written in chunks: no figure and no modes
        return words + r.choice([[], ["--scheduler", "threads"]])
    return words + ["--modes"] * (r.random() < 0.2)


def _table(r: random.Random) -> Words:
    name = r.choice(["families", "conditions", "drift", "drift", "hopf"])
    if name == "families":
        return ["table", name]
    words = ["table", name, "--k", ",".join(_near(r, 0.1, 0.5) for _ in range(r.randint(1, 2)))]
    if name == "conditions" and r.random() < 0.3:
        return [*words, "--contact", r.choice(["rough", "smooth"])]
    words += ["--mu", _near(r, 0.1, 3)]
    if name == "drift" and r.random() < 0.5:
        words += ["--tilt", _near(r, 0.001, 0.1)]
    return words + _scales(r) * (r.random() < 0.3)


def _simulate(r: random.Random) -> Words:
    creeps = ("creep-1", "creep-2", "creep-3")
    laws = (*SPECTRAL, "coulomb", "coulomb-regularised", *creeps[r.randrange(3) :][:1])
    law = _law(r, laws)
    if "--mu" in law:  # below Painlevé's paradox, and pressed to the plane
        mu = r.uniform(0.05, 0.6) * (1000 if set(creeps) & set(law) else 1)
        law[law.index("--mu") + 1] = f"{mu:.3g}"
    slips = not ({"rough", "smooth", *creeps} & set(law))
    words = ["simulate", "--theta", f"{r.uniform(0.7, 2.3):.4g}", *law]
    words += ["--epsilon", _near(r, 1e-3, 1)] * ("coulomb-regularised" in law)
    body = _body(r) * (r.random() < 0.5)
    if "coulomb" in law and "--k" in body:  # D > 0 for every direction of slip
        body[body.index("--k") + 1] = f"{r.uniform(0.2, 0.5):.3g}"
    size = {n: float(v) for n, v in zip(body[::2], body[1::2], strict=True) if n != "--disk"}
    g, length = size.get("--gravity", 1.0), size.get("--radius", 1.0)
    # turned faster than gravity holds it down, the disk is not in contact
    most = 0.5 * min(1.0, math.sqrt(g / length), math.sqrt(g * length))
    for name in ("--theta-dot", "--phi-dot", "--omega3", *("--slip-x", "--slip-y") * slips):
        if r.random() < 0.5:
            words += [name, f"{r.uniform(-most, most):.3g}"]
    words += ["--time", f"{r.uniform(0.1, 6):.3g}"]
    words += ["--points", str(r.randint(2, 50))] * (r.random() < 0.3)
    words += ["--method", r.choice(METHODS)] * (r.random() < 0.3)
    words += ["--tolerance", _near(r, 1e-12, 1e-3)] * (r.random() < 0.3)
    words += ["--no-check"] * (r.random() < 0.4) + ["--pose"] * (r.random() < 0.2)
    words += ["--out", "out.nc"] * (r.random() < 0.2)
    words += ["--plot", r.choice(["x.png", "x.svg"])] * (r.random() < 0.03)
    return words + ["--film", "x.html"] * (r.random() < 0.05) + body


def _scene(r: random.Random) -> Words:
    folder = Path(__file__).resolve().parents[2] / "examples" / "scenes"
    words = ["scene", str(folder / f"{r.choice(SCENES)}.toml")]
    kind = r.random()
    if kind < 0.3:
        words += ["--verify"]
    elif kind < 0.6:
        words += ["--only", r.choice(["steady", "linearised", "second-order", "creep", "viscous"])]
    return words + ["--out", "out.nc"] * (kind > 0.8)


def _long(r: random.Random) -> Words:
    name = r.choice(INTERRUPTED)
    words = [name, "--out", "new"]
    if name == "atlas":
        return [*words, "--resolution", str(r.randint(8, 40))]
    return words[:1] + ["spectrum"] * (name == "chart") + words[1:] + ["--workers", "1"]


MAKERS = (
    (_spectrum,) * 8 + (_map,) * 4 + (_table,) * 2 + (_simulate,) * 5 + (_scene,) * 2 + (_long,)
)


def _mutated(r: random.Random, words: Words) -> Words:
    words = list(words)
    places = [i for i, w in enumerate(words) if w.startswith("--")]
    kind = r.randrange(14)
    i = r.randrange(len(words)) if words else 0
    if kind == 0 and words:
        del words[i]
    elif kind == 1 and words:
        words.insert(i, words[i])
    elif kind == 2 and words:
        j = r.randrange(len(words))
        words[i], words[j] = words[j], words[i]
    elif kind in (3, 4, 5, 6) and len(words) > 1:
        j = r.randrange(1, len(words))
        words[j] = r.choice(ODD)
    elif kind == 7 and places:  # the value of an option made odd
        j = min(r.choice(places) + 1, len(words) - 1)
        words[j] = r.choice(ODD)
    elif kind in (10, 11) and places:  # a number of any size, so that the line gets far
        j = min(r.choice(places) + 1, len(words) - 1)
        words[j] = f"{r.choice(['', '', '-'])}{10 ** r.uniform(-16, 16):.{r.randint(1, 17)}g}"
    elif kind == 8 and places:
        j = r.choice(places)
        if j + 1 < len(words):
            words[j : j + 2] = [f"{words[j]}={words[j + 1]}"]
    elif kind == 9 and places:
        j = r.choice(places)
        words[j] = words[j][: r.randint(2, len(words[j]))]
    else:
        words.insert(r.randint(0, len(words)), r.choice(OPTIONS))
        if r.random() < 0.7:
            words.insert(r.randint(0, len(words)), r.choice(ODD))
    return words


def line(seed: str, number: int) -> tuple[Words, bool]:
    """The command line of a number, and whether it is valid as it stands."""
    r = random.Random(f"{seed}:{number}")
    words = r.choice(MAKERS)(r)
    words += ["--json"] * (r.random() < 0.5)
    if r.random() < 0.25:
        return words, True
    for _ in range(r.choice([1, 1, 1, 2, 2, 3])):
        words = _mutated(r, words)
    return words, False


@contextmanager
def workplace() -> Iterator[Path]:
    """A folder with a few things in the way."""
    with tempfile.TemporaryDirectory() as name:
        place = Path(name)
        with chdir(place):
            yield place


def tidy(place: Path) -> None:
    for path in place.iterdir():
        if path.is_dir() and not path.is_symlink():
            shutil.rmtree(path)
        else:
            path.unlink()
    (place / "folder").mkdir()
    for name in ("exists.nc", "exists.png"):
        (place / name).write_text("precious")
    (place / "loop").symlink_to("loop")


def _strict(name: str) -> float:
    raise ValueError(f"JSON holds {name}")


def _wrong_json(text: str) -> str:
    try:
        body = json.loads(text, parse_constant=_strict)
    except ValueError as error:
        return f"stdout is no strict JSON: {error}"
    if not isinstance(body, dict):
        return "stdout is no JSON object"
    if "verdict" in body and body["verdict"] not in VERDICTS:
        return f"the verdict is {body['verdict']!r}"
    return ""


def _interrupt(*_: Any) -> None:
    raise KeyboardInterrupt


def run(words: Words) -> tuple[int | str, str, str]:
    """Exit code (or a traceback), standard output and error of `main`."""
    from stability.cli import main

    code: int | str
    kept = [os.dup(1), os.dup(2)]
    streams = sys.stdout, sys.stderr
    with tempfile.TemporaryFile() as out, tempfile.TemporaryFile() as err:
        os.dup2(out.fileno(), 1)
        os.dup2(err.fileno(), 2)
        sys.stdout = open(1, "w", encoding="utf-8", closefd=False)  # noqa: SIM115
        sys.stderr = open(2, "w", encoding="utf-8", closefd=False)  # noqa: SIM115
        try:
            if any(name in words for name in INTERRUPTED):
                signal.signal(signal.SIGALRM, _interrupt)
                signal.setitimer(signal.ITIMER_REAL, MOMENT, AGAIN)
            code = main(words)
        except SystemExit as stop:
            code = stop.code if isinstance(stop.code, int) else f"exit {stop.code!r}"
        except BaseException:
            code = traceback.format_exc()
        finally:
            signal.setitimer(signal.ITIMER_REAL, 0)
            try:
                sys.stdout.flush()
                sys.stderr.flush()
            except (OSError, ValueError) as error:
                code = f"flush: {error}"
            sys.stdout, sys.stderr = streams
            os.dup2(kept[0], 1)
            os.dup2(kept[1], 2)
            for descriptor in kept:
                os.close(descriptor)
        texts = []
        for stream in (out, err):
            stream.seek(0)
            texts.append(stream.read().decode("utf-8", "replace"))
    return code, texts[0], texts[1]


def wrong(words: Words, valid: bool, code: int | str, out: str, err: str, place: Path) -> str:
    """What is wrong with how a command ended; empty if nothing is."""
    if isinstance(code, str):
        return "traceback: " + " | ".join(code.strip().splitlines()[-5:])
    if code not in (0, 2, 130) or (code == 130 and not any(n in words for n in INTERRUPTED)):
        return f"exit code {code}: {err[-300:]}"
    if valid and code == 2:
        return f"a valid line is refused: {err[-300:]}"
    if "Traceback" in err or "Warning" in err:
        return f"on standard error: {err[-400:]}"
    if reason := too_much(err):
        return f"{reason} on standard error: {err[:300]!r}"
    if code == 2 and not err:
        return "refused without a word"
    if code and out:
        return f"output of a refused command: {out[:200]!r}"
    if code == 0 and "--json" in words and out.startswith("{"):
        return _wrong_json(out)
    if code == 2:
        left = sorted(p.name for p in place.iterdir())
        if left != ["exists.nc", "exists.png", "folder", "loop"] or any(
            (place / n).read_text() != "precious" for n in ("exists.nc", "exists.png")
        ):
            return f"refused ({err.strip()[:150]}), yet the folder holds {left}"
    return ""


def case(seed: str, number: int, place: Path) -> dict[str, Any]:
    """Run one command line; how it ended."""
    words, valid = line(seed, number)
    tidy(place)
    code, out, err = run(words)
    detail = wrong(words, valid, code, out, err, place)
    what = " ".join(w if len(w) < 60 else w[:50] + "…" for w in words)
    status = "fault" if detail else {0: "done", 2: "refused", 130: "interrupted"}[int(code)]
    return {"what": ascii(what), "status": status, "detail": ascii(detail)}
