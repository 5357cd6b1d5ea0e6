"""A disk that is really full in the middle of a store: a sentence, and the same call goes on."""

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest
from programs import needed

SCRIPT = """
import json, os, sys
from pathlib import Path
import stability as st
from stability.base.errors import FileError

kind, disk, other = sys.argv[1], Path(sys.argv[2]), Path(sys.argv[3])
filler, asked = disk / "filler", []

def fill(done, total):
    asked.append((done, total))
    if 0 < done < total and not filler.exists():
        with filler.open("wb", buffering=0) as file:
            try:
                while True:
                    file.write(bytes(4096))
            except OSError:
                pass

def run(out, progress=None):
    if kind == "basins":
        st.basins(contact="viscous", mu=0.3, family="spinning", x=("at", 0.5, 3, 12),
                  y=("tilt", 0.1, 0.5, 8), horizon=10.0, check=False, chunk=16, workers=1,
                  store=out, progress=progress)
    else:
        st.stream_map("spinning", x=("at", 0.5, 4, 4096), y=("mu", 0.1, 2, 1024), out=out,
                      progress=progress)

def tree(folder):
    return {str(p.relative_to(folder)): p.read_bytes() for p in folder.rglob("*") if p.is_file()}

out, said = disk / "a.zarr", ""
try:
    run(out, fill)
except FileError as error:
    said = str(error)
filled, before = filler.exists(), tree(out)
filler.unlink(missing_ok=True)
first = []
run(out, lambda done, total: first.append(done))
run(other / "b.zarr")
print(json.dumps({
    "said": said, "filled": filled, "chunks": len(before), "kept": first[0],
    "same": tree(out) == tree(other / "b.zarr"), "all": len(tree(out)),
    "litter": [p.name for p in disk.rglob(".stability-*")],
}))
"""


def small_disk(folder: Path) -> list[str]:
    """Words before a command that give it a disk of its own in this folder, of 24 MiB."""
    mount = f'mount -t tmpfs -o size=24m tmpfs "{folder}" && exec "$@"'
    return ["unshare", "-rm", "sh", "-c", mount, "sh"]


@pytest.mark.few(1)
@pytest.mark.outside
@pytest.mark.parametrize("kind", ["basins", "stream_map"])
def test_a_store_goes_on_after_a_full_disk(kind: str, tmp_path: Path) -> None:
    needed("util-linux", "unshare")
    disk, other = tmp_path / "disk", tmp_path / "other"
    disk.mkdir()
    other.mkdir()
    words = small_disk(disk)
    if subprocess.run([*words, "true"], capture_output=True, check=False).returncode:
        pytest.skip("no disk can be mounted here")
    done = subprocess.run(
        [*words, sys.executable, "-c", SCRIPT, kind, str(disk), str(other)],
        capture_output=True,
        text=True,
        check=False,
        env=dict(os.environ),
        timeout=200,
    )
    assert done.returncode == 0, done.stderr
    found = json.loads(done.stdout)
    assert found["filled"]
    assert "No space left on device" in found["said"]
    assert found["said"].endswith("give the same command again to go on.")
    assert found["said"].count("\n") == 0
    assert 0 < found["chunks"] < found["all"]
    assert found["kept"] > 0
    assert found["same"]
    assert found["litter"] == []
