"""Damage to files, drawn at random: what disks, networks and editors do to them."""

from collections.abc import Callable
from pathlib import Path

import h5py
import numpy as np

Random = np.random.Generator
Kind = Callable[[bytes, Random, bytes], bytes]


def flips(content: bytes, random: Random, _: bytes) -> bytes:
    """One to eight bytes become others."""
    data = bytearray(content)
    for place in random.integers(len(data), size=random.integers(1, 9)):
        data[place] ^= int(random.integers(1, 256))
    return bytes(data)


def truncated(content: bytes, random: Random, _: bytes) -> bytes:
    """The end is missing: anything, or a few bytes."""
    most = len(content) if random.random() < 0.5 else 200
    return content[: -int(random.integers(1, most))]


def appended(content: bytes, random: Random, _: bytes) -> bytes:
    """Something follows."""
    return content + random.bytes(int(random.integers(1, 300)))


def zeroed(content: bytes, random: Random, _: bytes) -> bytes:
    """A block is zero."""
    size = int(random.integers(1, min(4096, len(content))))
    start = int(random.integers(0, len(content) - size + 1))
    return content[:start] + bytes(size) + content[start + size :]


def moved(content: bytes, random: Random, _: bytes) -> bytes:
    """A block has the content of another place."""
    size = int(random.integers(1, min(512, len(content) // 2)))
    a, b = (int(v) for v in random.integers(0, len(content) - size, size=2))
    return content[:a] + content[b : b + size] + content[a + size :]


def swapped(_: bytes, __: Random, other: bytes) -> bytes:
    """Another file of the same kind lies there, as a whole."""
    return other


def spliced(content: bytes, random: Random, other: bytes) -> bytes:
    """The end is that of another file."""
    cut = int(random.integers(1, min(len(content), len(other))))
    return content[:cut] + other[cut:]


KINDS: dict[str, Kind] = {
    f.__name__: f for f in (flips, truncated, appended, zeroed, moved, spliced, swapped)
}


def damage(
    content: bytes, other: bytes, random: Random, *, swaps: bool = True
) -> tuple[str, bytes]:
    """A kind of damage by name, and the content after it, which differs from that before."""
    while True:
        name = str(random.choice(list(KINDS)))
        if name == "swapped" and not swaps:
            continue
        found = KINDS[name](content, random, other)
        if found != content:
            return name, found


def bomb(path: Path, kind: str) -> None:
    """A small HDF5 file of many gigabytes that says that it is a map."""
    with h5py.File(path, "w") as file:
        file.attrs["format"] = "stability map 1"
        if kind == "sparse":  # chunks that were never written
            file.create_dataset(
                "verdict", (150_000, 150_000), "i1", chunks=(1000, 1000), compression="gzip"
            )
        elif kind == "contiguous":  # space that was never taken
            file.create_dataset("verdict", (6 * 10**9,), "f8")
        elif kind == "twice":  # compressed and compressed again
            plist = h5py.h5p.create(h5py.h5p.DATASET_CREATE)
            plist.set_chunk((2**26,))
            plist.set_deflate(9)
            plist.set_deflate(9)
            space = h5py.h5s.create_simple((2**33,))
            made = h5py.h5d.create(file.id, b"verdict", h5py.h5t.NATIVE_INT8, space, plist)
            h5py.Dataset(made)[: 2**26] = np.zeros(2**26, "i1")
        else:
            raise ValueError(kind)


BOMBS = ("sparse", "contiguous", "twice")
