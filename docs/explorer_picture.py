"""The picture of the explorer in the docs: `python docs/explorer_picture.py` takes it again."""

from __future__ import annotations

import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
PICTURE = ROOT / "docs" / "explorer.png"
BROWSERS = ("chromium", "chromium-browser", "google-chrome", "google-chrome-stable")
SIZE = {"width": 1280, "height": 1130}
LINK = "#show=spinning-viscous&at=2.3&mu=0.4&tilt=0.3&time=20"


def main(picture: Path = PICTURE) -> None:
    """Open the page in Chromium and take its picture in the middle of a launch."""
    sys.path.insert(0, str(ROOT / "tests" / "tools"))
    from chromium import chromium, visit

    import stability as st

    with tempfile.TemporaryDirectory() as folder, chromium() as browser:
        page = st.explore("spinning", mu=0.4, out=Path(folder) / "page.html")
        with visit(browser, page, LINK, size=SIZE) as seen:
            seen.page.wait_for_timeout(500)
            seen.page.evaluate("stabilityExplorer.motion.seek(4)")
            seen.page.wait_for_timeout(500)
            seen.page.screenshot(path=str(picture))


if __name__ == "__main__":
    main()
