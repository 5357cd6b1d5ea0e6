"""The explorer: size, time to the first picture, time of a frame while a slider is swept.

In software rendering, or with `--gpu` on the graphics card (`--gpu vulkan`, `gl-egl`, `d3d11`,
`metal` say through which interface). Every slider is swept; the one that asks most is printed.
Times are of the wall on this machine, whose other work counts: run it alone.
"""

import argparse
import os
import sys
import tempfile
import time
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parents[1]
FRAMES = 80
SWEEP = """async (frames) => {
  const {view, diagram} = stabilityExplorer, found = [];
  const frame = () => new Promise((r) => requestAnimationFrame(r));
  const pause = (time) => new Promise((r) => setTimeout(r, time));
  for (const q of view.subject.quantities) {
    const middle = view.state.values[q.name], times = [];
    await pause(400);
    await frame();
    let last = performance.now();
    for (let i = 0; i < frames; i++) {
      view.move({[q.name]: middle * (1 + 0.4 * Math.sin(i / 12))}, q.name);
      await frame();
      const now = performance.now();
      times.push(now - last);
      last = now;
    }
    found.push({name: q.name, times, share: diagram.rating.share});
    view.move({[q.name]: middle}, q.name);
  }
  return found;
}"""
RENDERER = """() => {
  const gl = document.createElement("canvas").getContext("webgl2");
  const known = gl && gl.getExtension("WEBGL_debug_renderer_info");
  return gl ? gl.getParameter(known ? known.UNMASKED_RENDERER_WEBGL : gl.RENDERER) : "no WebGL";
}"""
PAINT = "performance.getEntriesByName('first-contentful-paint').map((e) => e.startTime)[0]"


def quantile(values: list[float], share: float) -> float:
    return sorted(values)[int(share * (len(values) - 1))]


def swept(browser: Any, path: Path, name: str, link: str = "") -> None:
    """Print the times of frames while a slider of a page is swept: the slider that asks most."""
    from chromium import visit

    with visit(browser, path, link) as seen:
        all_found = seen.page.evaluate(SWEEP, FRAMES)
    found = max(all_found, key=lambda one: quantile(one["times"][20:], 0.5))
    times = found["times"][20:]
    print(
        f"  {name:26} frame {quantile(times, 0.5):5.1f} ms (9 in 10 below "
        f"{quantile(times, 0.9):.0f}), slider {found['name']}, resolution "
        f"{found['share']:.2f}"
    )


def main() -> None:
    sys.path.insert(0, str(ROOT / "tests" / "tools"))
    from chromium import GPU, SOFTWARE, chromium, visit

    import stability as st
    from stability.tables.benchmarks.oscillators import governor

    wanted = argparse.ArgumentParser(description=__doc__)
    wanted.add_argument("--gpu", nargs="?", const="gl-egl", help="interface of the graphics card")
    gpu = wanted.parse_args().gpu
    rendering = (*GPU, f"--use-angle={gpu}") if gpu else SOFTWARE
    print(f"load of the machine {os.getloadavg()[0]:.1f}, {os.cpu_count()} cores")
    with tempfile.TemporaryDirectory() as folder, chromium(rendering=rendering) as browser:
        begun = time.process_time()
        path = st.explore("spinning", mu=0.3, out=Path(folder) / "page.html")
        made = time.process_time() - begun
        print(f"page: {path.stat().st_size / 1e6:.2f} MB, made in {made:.1f} s of CPU")
        paints, readies = [], []
        for _ in range(5):
            begun = time.perf_counter()
            with visit(browser, path, ready=False) as seen:
                seen.page.wait_for_selector("[data-ready]", timeout=60_000)
                readies.append(time.perf_counter() - begun)
                drawn_by = seen.page.evaluate(RENDERER)
                paints.append(seen.page.evaluate(PAINT) / 1000)
        least, most = min(paints), max(paints)
        print(
            f"first picture after {quantile(paints, 0.5):.2f} s (median of 5; {least:.2f} to "
            f"{most:.2f}), 3-D after {quantile(readies, 0.5):.2f} s"
        )
        print(f"a slider swept, 1280 x 800, drawn by {drawn_by}:")
        for link in ("rolling-viscous", "spinning-viscous", "tumbling-viscous", "spinning-rough"):
            swept(browser, path, link, f"#show={link}")
        others = {
            "torus, tumbling": ("tumbling", {"body": st.Torus(0.2)}),
            "egg, tumbling": ("tumbling", {"body": st.Egg(0.2)}),
            "solved-for members": (governor(), {"at": 0.4, "a": 0.5, "b": 0.5}),
        }
        for name, (family, given) in others.items():
            path = st.explore(family, **given, certify=False, out=Path(folder) / f"{name}.html")
            swept(browser, path, f"{name}, {path.stat().st_size / 1e6:.1f} MB")


if __name__ == "__main__":
    main()
