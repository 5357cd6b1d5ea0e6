"""Flutter and branch points of the viscous disk: AUTO-07p against `boundaries`, in one run.

AUTO wants isolated equilibria, but the disk's steady motions come in lines: along each, the
Jacobian has a zero by structure, and no parameter removes it.  Three ways to hand the disk to AUTO,
all generated as C from the package's own CasADi graph, with its exact derivatives:

  reduced  The label c = phi_dot sin²(theta) takes the place of the state phi_dot and becomes a
           parameter.  Since dc/dt = 2 omega3 theta_dot sin(theta) is of second order where omega3
           and theta_dot vanish, spinning and tumbling lose their structural zero and nothing else.
  frozen   phi_dot itself becomes the parameter, which looks as good.  Along tumbling it drops the
           feedback of phi_dot.
  naive    All six states, with mu or k as the parameter.  Exact derivatives give exact zero pivots,
           so naive-fd leaves the derivatives to AUTO's own differences.

Each is continued from several starts.  AUTO covers about the stretch that `boundaries` scans; it
proves nothing, and `boundaries` follows no branch.
"""

from __future__ import annotations

import argparse
import json
import math
import os
import re
import resource
import shutil
import statistics
import subprocess
import tempfile
import time
from collections import Counter
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from fractions import Fraction
from multiprocessing import get_context
from pathlib import Path
from typing import Any

import stability as st

STARTS, REPEATS, SCAN = 10, 7, 200
TIME_LIMIT = 120.0
TOLERANCE = 1e-9  # of EPSL, EPSU, EPSS; at 1e-12 its Newton can fail near the branch point
LOG_LIMIT = 16 * 2**20  # AUTO can loop for ever on a singular pivot and write a note each time
PARAMETERS = ("label", "k", "mu")
TYPE = {"BP": 1, "HB": 3}
UPRIGHT = math.pi / 2
FORMULATIONS = {
    "reduced": "five states, phi_dot = label/sin²(theta)",
    "frozen": "five states, phi_dot = label",
    "naive": "all six states",
    "naive-fd": "all six states, AUTO's own differences",
}
CONSTANTS = {
    "IPS": 1,
    "IRS": 0,
    "ILP": 0,
    "NTST": 1,
    "NCOL": 4,
    "IAD": 3,
    "ISP": 2,
    "ISW": 1,
    "IPLT": 0,
    "NBC": 0,
    "NINT": 0,
    "NMX": 500,
    "NPR": 1000,
    "IID": 0,
    "ITMX": 20,
    "ITNW": 7,
    "NWTN": 3,
    "DSMIN": 1e-9,
    "IADS": 1,
    "NPAR": 36,
}
WRAPPER = """\
#include "auto_f2c.h"
#include "rates.c"
static int asked; /* the parameter that is compared, or -1 for theta */
static int func(integer ndim, const doublereal *u, const integer *icp, const doublereal *par,
                integer ijac, doublereal *f, doublereal *dfdu, doublereal *dfdp) {
  static double w[%(w)d]; static casadi_int iw[%(iw)d];
  const double *arg[%(arg)d] = {u, par};
  double *res[%(res)d] = {f, ijac > 0 ? dfdu : 0, ijac > 1 ? dfdp : 0};
  return rates(arg, res, iw, w, 0);
}
static int stpnt(integer ndim, doublereal t, doublereal *u, doublereal *par) {
  FILE *start = fopen("start", "r"); int i;
  fscanf(start, "%%d", &asked);
  for (i = 0; i < 3; i++) fscanf(start, "%%lf", par + i);
  for (i = 0; i < ndim; i++) fscanf(start, "%%lf", u + i);
  return fclose(start);
}
static int pvls(integer ndim, const doublereal *u, doublereal *par) {
  double x = asked < 0 ? u[0] : par[asked]; /* AUTO prints 11 digits: split it in two */
  par[3] = (float)x; par[4] = x - par[3];
  return 0;
}
static int bcnd() { return 0; } static int icnd() { return 0; } static int fopt() { return 0; }
"""


@dataclass(frozen=True)
class Case:
    """One point to find, and from where."""

    formulation: str
    family: str
    point: str  # HB or BP
    read: str  # what is compared: theta, or the free parameter
    free: str  # the parameter that AUTO varies
    starts: tuple[float, float]
    stop: float
    step: float
    k: float | None = None
    mu: float | None = None
    at: float | None = None

    @property
    def axis(self) -> tuple[str, float, float, int]:
        """The package's axis: the stretch that AUTO covers."""
        if self.read == "theta":
            return "at", 0.1, 1.57, SCAN
        name = "at" if self.free == "label" else self.free
        return name, *sorted((self.starts[0], self.stop)), SCAN

    @property
    def switches(self) -> bool:
        """Whether AUTO is to find the family by itself, where it leaves spinning."""
        return self.read == "theta"

    @property
    def name(self) -> str:
        """The quantity in words."""
        parts = [f"k={Fraction(self.k)}" if self.k else "", f"mu={self.mu:g}" if self.mu else ""]
        parts += [f"at={self.at:g}" if self.at else "", self.point]
        what = "phi_dot" if (self.free, self.read) == ("label", "label") else self.read
        return " ".join([self.family, *filter(None, parts), what])


def cases() -> list[Case]:
    found = []
    for k, mu in ((0.25, 0.8), (0.5, 0.8)):
        end = 0.9 / math.sqrt(k)
        for point in ("HB", "BP"):
            ends = ("label", "label", (5.0, 4.5), end, 0.1)
            found.append(Case("reduced", "spinning", point, *ends, k, mu))
    low = math.sin(0.1)
    # on tumbling label² = sin³/k falls and phi_dot² = 1/(k sin) rises away from spinning
    for formulation, k, mu, starts, end in (
        ("reduced", 0.25, 1.2, (1.2, 1.1), low**1.5),
        ("reduced", 0.5, 0.8, (1.2, 1.1), low**1.5),
        ("frozen", 0.25, 1.2, (0.9, 0.8), low**-0.5),
    ):
        a, b, end = (x / math.sqrt(k) for x in (*starts, end))
        found.append(Case(formulation, "tumbling", "HB", "theta", "label", (a, b), end, 0.1, k, mu))
    for formulation in ("reduced", "naive", "naive-fd"):
        found += [
            Case(formulation, "spinning", "HB", "mu", "mu", (0.5, 0.75), 1.0, 0.1, 0.25, at=2.6),
            Case(formulation, "tumbling", "HB", "mu", "mu", (3.0, 2.5), 0.5, 0.1, 0.25, at=1.0),
            Case(formulation, "spinning", "BP", "k", "k", (0.15, 0.2), 0.35, 0.02, mu=0.8, at=2.0),
        ]
    return sorted(found, key=lambda case: list(FORMULATIONS).index(case.formulation))


def auto_folder() -> Path | None:
    """Where AUTO's objects lie, or None."""
    given, command = os.environ.get("AUTO_DIR"), shutil.which("auto-07p") or shutil.which("auto")
    tries = [Path(given)] if given else []
    if command:
        prefix = Path(command).resolve().parents[1]
        tries += [prefix / "lib" / "auto-07p", prefix]
    return next((t for t in tries if any(t.glob("lib/equilibrium.o"))), None)


def missing() -> str:
    """What keeps AUTO from running here, in one line; empty if nothing does."""
    if auto_folder() is None:
        return "AUTO-07p: missing (Debian: apt-get install auto-07p)"
    for tool in ("gfortran", "gcc"):  # the packaged AUTO links each problem again
        if shutil.which(tool) is None:
            return f"AUTO-07p: installed, but {tool} is missing (Debian: apt-get install {tool})"
    return ""


def write_problem(formulation: str, folder: Path) -> None:
    """The disk as AUTO's C problem file."""
    import casadi as ca

    disk = st.disk_system("viscous")
    par = ca.SX.sym("par", 3)
    u = ca.SX.sym("u", 6 if formulation.startswith("naive") else 5)
    state, rows = u, range(6)
    if not formulation.startswith("naive"):
        phi_dot = par[0] / ca.sin(u[0]) ** 2 if formulation == "reduced" else par[0]
        state, rows = ca.vertcat(u[:2], phi_dot, u[2:]), (0, 1, 3, 4, 5)
    f = ca.substitute(disk.rhs[list(rows)], ca.vertcat(disk.x, disk.p), ca.vertcat(state, par[1:]))
    outputs = [ca.densify(e) for e in (f, ca.jacobian(f, u), ca.jacobian(f, par))]
    function = ca.Function("rates", [u, par], outputs)
    here = Path.cwd()
    os.chdir(folder)  # CasADi writes to the working folder only
    try:
        function.generate("rates.c")
    finally:
        os.chdir(here)
    sizes = {n: getattr(function, f"sz_{n}")() + 1 for n in ("w", "iw", "arg", "res")}
    (folder / "disk.c").write_text(WRAPPER % sizes)


def build(formulation: str, folder: Path) -> dict[str, float]:
    begin = time.perf_counter()
    write_problem(formulation, folder)
    wrote = time.perf_counter()
    library = auto_folder() / "lib"
    objects = [str(o) for o in sorted(library.glob("*.o"))]
    include = f"-I{library.parent / 'include'}"
    link = ["gfortran", "-O2", "-fopenmp", "disk.o", *objects, f"-L{library}", "-lauto_c"]
    for command in (["gcc", "-O2", "-w", include, "-c", "disk.c"], [*link, "-o", "disk"]):
        subprocess.run(command, cwd=folder, check=True, capture_output=True, text=True)
    return {"write_s": wrote - begin, "compile_s": time.perf_counter() - wrote}


def start_of(case: Case, begin: float) -> tuple[list[float], list[float]]:
    """AUTO's parameters and state at a start on the family."""
    given = {"k": case.k, "mu": case.mu} | {case.free: begin}
    theta, phi_dot = UPRIGHT, begin if case.at is None else case.at
    if case.family == "tumbling" and case.at is not None:
        theta, phi_dot = case.at, 1 / math.sqrt(given["k"] * math.sin(case.at))
    label = phi_dot * math.sin(theta) ** 2 if case.formulation == "reduced" else phi_dot
    middle = [0.0, phi_dot, 0.0] if case.formulation.startswith("naive") else [0.0, 0.0]
    return [label, given["k"], given["mu"]], [theta, *middle, 0.0, 0.0]


def write_constants(case: Case, begin: float, tolerance: float, folder: Path) -> None:
    par, u = start_of(case, begin)
    free = PARAMETERS.index(case.free)
    up = case.stop > begin
    constants = (
        CONSTANTS
        | dict.fromkeys(("EPSL", "EPSU", "EPSS"), tolerance)
        | {
            "NDIM": len(u),
            "JAC": int(case.formulation != "naive-fd"),
            "ICP": f"[{free + 1}, 4, 5, 11]",
            "MXBF": -1 if case.switches else 0,
            "DS": math.copysign(case.step / 10, case.stop - begin),
            "DSMAX": case.step,
            ("RL1" if up else "RL0"): case.stop,
        }
    )
    (folder / "fort.2").write_text("".join(f"{n} = {v}\n" for n, v in constants.items()))
    asked = -1 if case.read == "theta" else free
    (folder / "start").write_text(" ".join([str(asked), *(repr(v) for v in par + u)]))


def run_auto(case: Case, begin: float, tolerance: float, folder: Path) -> dict[str, Any]:
    """One continuation: what it found, or a word for how it failed, and its times."""
    for old in folder.glob("fort.*"):
        old.unlink()
    write_constants(case, begin, tolerance, folder)
    out: dict[str, Any] = {"start": begin, "value": None}
    clock = time.perf_counter()
    try:
        done = subprocess.run(
            ["./disk"],
            cwd=folder,
            capture_output=True,
            text=True,
            timeout=TIME_LIMIT,
            preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (LOG_LIMIT, LOG_LIMIT)),
        )
    except subprocess.TimeoutExpired:
        return out | {"failure": f"time-out of {TIME_LIMIT:.0f} s"}
    out["process_s"] = time.perf_counter() - clock
    log = (folder / "fort.9").read_text() if (folder / "fort.9").exists() else ""
    out["singular_pivots"] = log.count("NOTE:Pivot")
    taken = re.search(r"Total Time\s+(\S+)", done.stdout)
    if len(log) >= 0.99 * LOG_LIMIT:
        seen = special_point(case, (folder / "fort.7").read_text())["value"] is not None
        word = f"reports {case.point}, then loops" if seen else "loops"
        return out | {"failure": f"{word}; stopped at a log of {LOG_LIMIT >> 20} MiB"}
    if done.returncode or taken is None:
        return out | {"failure": f"ends early with exit code {done.returncode}"}
    out["continuation_s"] = float(taken[1])
    return out | special_point(case, (folder / "fort.7").read_text())


def special_point(case: Case, diagram: str) -> dict[str, Any]:
    """The first point of the wanted type on the wanted branch of AUTO's diagram."""
    rows = [line.split() for line in diagram.splitlines()]
    points = [r for r in rows if len(r) == 12 and r[0] != "0" and r[1].lstrip("-").isdigit()]
    wanted = "2" if case.switches else "1"
    hits = [r for r in points if r[0].lstrip("-") == wanted and int(r[2]) == TYPE[case.point]]
    if not hits:
        return {"points": len(points), "value": None, "failure": f"reports no {case.point}"}
    value = float(hits[0][9]) + float(hits[0][10])
    if case.read == "theta":
        value = min(value, math.pi - value)  # the mirror image is the same motion
    frequency = 2 * math.pi / float(hits[0][11]) if case.point == "HB" else 0.0
    return {"points": len(points), "value": value, "frequency": frequency}


def ask(case: Case) -> tuple[float, Any]:
    """The package's answer and the time it took [s]."""
    begin = time.perf_counter()
    points = st.boundaries(
        case.family,
        axis=case.axis,
        at=case.at,
        disk=None if case.k is None else st.Disk(k=case.k),
        contact=None if case.mu is None else st.Viscous(case.mu),
    )
    taken = time.perf_counter() - begin
    word = {"HB": "flutter", "BP": "static"}[case.point]
    return taken, next((p for p in points if p.crossing.word == word), None)


def first_call(case: Case) -> float:
    """Time of the call in a fresh interpreter, where nothing is loaded."""
    with ProcessPoolExecutor(1, mp_context=get_context("spawn")) as pool:
        return pool.submit(ask, case).result()[0]


def compare(case: Case, tolerance: float, folder: Path) -> dict[str, Any]:
    a, b = case.starts
    starts = [a + (b - a) * i / (STARTS - 1) for i in range(STARTS)]
    runs = [run_auto(case, start, tolerance, folder) for start in starts]
    asked = [ask(case) for _ in range(REPEATS + 1)][1:]
    point = asked[0][1]
    hits = [r for r in runs if r["value"] is not None]
    row: dict[str, Any] = {
        "formulation": case.formulation,
        "quantity": case.name,
        "axis": case.axis,
        "found": len(hits),
        "starts": STARTS,
        "failures": dict(Counter(r["failure"] for r in runs if "failure" in r)),
        "singular_pivots": statistics.median(r.get("singular_pivots", 0) for r in runs),
        "package": None if point is None else point.value,
        "package_error": None if point is None else point.error,
        "package_frequency": None if point is None else point.frequency,
        "package_median_s": statistics.median(t for t, _ in asked),
        "package_first_call_s": first_call(case),
        "runs": runs,
    }
    if hits:
        row |= {"auto": hits[0]["value"], "auto_frequency": hits[0]["frequency"]}
        for name in ("continuation_s", "process_s"):
            row[f"auto_{name}"] = statistics.median(r[name] for r in hits)
        row["ratio"] = row["package_median_s"] / row["auto_continuation_s"]
        if point is not None:  # of all starts, the one that is furthest off
            row["difference"] = max((r["value"] - point.value for r in hits), key=abs)
    return row


def measure(tolerance: float) -> dict[str, Any]:
    built: dict[str, Any] = {}
    with tempfile.TemporaryDirectory() as name:
        folders = {f: Path(name) / f for f in FORMULATIONS}
        for formulation, folder in folders.items():
            folder.mkdir()
            built[formulation] = build(formulation, folder)
        rows = [compare(case, tolerance, folders[case.formulation]) for case in cases()]
    return {"built": built, "tolerance": tolerance, "rows": rows}


def show(report: dict[str, Any]) -> None:
    print("Viscous disk: AUTO-07p, generated from the package's graph, and `boundaries`, one run.")
    print(
        f"AUTO: {STARTS} starts each, tolerance {report['tolerance']:g}; "
        f"package: {REPEATS} repeats, scan of {SCAN} points.\n"
    )
    for name, built in report["built"].items():
        print(
            f"  {name:<8} {FORMULATIONS[name]}: written in {built['write_s']:.2f} s, "
            f"compiled in {built['compile_s']:.2f} s"
        )
    print("\nValues; ±: proved half-width; difference: AUTO - package, the largest of all starts\n")
    print(f"{'':13}{'quantity':<33}{'AUTO':<17}{'package':<17}{'±':<8}difference")
    for number, row in enumerate(report["rows"], 1):
        value = f"{row['auto']:.13f}" if row["found"] else "not found"
        off = f"{row['difference']:+.1e}" if "difference" in row else "-"
        proved = "none", "-"
        if row["package"] is not None:
            proved = f"{row['package']:.13f}", f"{row['package_error']:.0e}"
        print(
            f"{number:>2}  {row['formulation']:<9}{row['quantity']:<33}{value:<17}"
            f"{proved[0]:<17}{proved[1]:<8}{off}"
        )
    show_times(report["rows"])


def show_times(rows: list[dict[str, Any]]) -> None:
    print(
        "\nTimes [ms], medians; AUTO: the continuation by its own clock; process: with start and "
        "files;\npackage: repeats; fresh: its first call in a new interpreter; pivots: zero "
        "pivots that AUTO\nnotes in its log, and only there, per run\n"
    )
    head = ("reported", "pivots", "AUTO", "process", "package", "fresh", "package/AUTO")
    print("  " + "".join(f"{h:>{len(h) + 4}}" for h in head))
    names = ("auto_continuation_s", "auto_process_s", "package_median_s", "package_first_call_s")
    for number, row in enumerate(rows, 1):
        cells = [f"{row['found']}/{row['starts']}", f"{row['singular_pivots']:.0f}"]
        cells += [f"{1e3 * row[n]:.1f}" if n in row else "-" for n in names]
        cells.append(f"{row['ratio']:.1f}" if "ratio" in row else "-")
        print(
            f"{number:>2}" + "".join(f"{c:>{len(h) + 4}}" for c, h in zip(cells, head, strict=True))
        )
    print("\nStarts from which AUTO did not come through with the point:")
    for number, row in enumerate(rows, 1):
        for why, count in row["failures"].items():
            print(f"{number:>2}  {count} of {row['starts']}: {why}")


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--json", action="store_true", help="print one JSON object")
    parser.add_argument("--tolerance", type=float, default=TOLERANCE, help="AUTO's (%(default)g)")
    given = parser.parse_args()
    problem = missing()
    if problem:
        print(json.dumps(dict([problem.split(": ", 1)])) if given.json else problem)
        return
    try:
        report = measure(given.tolerance)
    except subprocess.CalledProcessError as error:
        last = (error.stderr.strip().splitlines() or ["no message"])[-1]
        report = {"AUTO-07p": f"its problem did not build: {last}"}
    if given.json or "rows" not in report:
        print(json.dumps(report, indent=2))
    else:
        show(report)


if __name__ == "__main__":
    main()
