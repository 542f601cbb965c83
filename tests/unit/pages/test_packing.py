"""Bundles equal a fresh build and are in the wheel; packing against a plain inverse."""

import json
import re
import shutil
import struct
import subprocess
import tarfile
import zipfile
from pathlib import Path

import numpy as np
import pytest

from wpcal.brep.mesh import PartMesh, SolidMesh
from wpcal.brep.mesh_glb import write_part_glb
from wpcal.pages.packing import UNSIGNED, pack_glb


def unpack(packed: bytes) -> bytes:
    """Restore the GLB file number by number."""
    (length,) = struct.unpack_from("<I", packed)
    text = packed[4 : 4 + length]
    document = json.loads(text)
    binary = bytearray(-(-document["buffers"][0]["byteLength"] // 4) * 4)
    at = 4 + length
    for accessor in document["accessors"]:
        view = document["bufferViews"][accessor["bufferView"]]
        kind = np.dtype(UNSIGNED[accessor["componentType"]])
        width = view.get("byteStride", kind.itemsize) // kind.itemsize
        size = accessor["count"] * width * kind.itemsize
        planes = np.frombuffer(packed[at : at + size], np.uint8).reshape(kind.itemsize, width, -1)
        at += size
        rows = np.zeros((accessor["count"], width), dtype=np.int64)
        for column in range(width):
            total = 0
            for i in range(accessor["count"]):
                folded = sum(int(planes[k, column, i]) << (8 * k) for k in range(kind.itemsize))
                total += -(folded + 1) // 2 if folded % 2 else folded // 2
                rows[i, column] = total % 256**kind.itemsize
        binary[view["byteOffset"] : view["byteOffset"] + size] = rows.astype(kind).tobytes()
    chunks = struct.pack("<I4s", len(text), b"JSON") + text + struct.pack("<I4s", len(binary), b"BIN\0") + bytes(binary)
    return struct.pack("<4sII", b"glTF", 2, 12 + len(chunks)) + chunks


@pytest.mark.parametrize("count", [50, 70_000])
def test_the_bytes_come_back(count: int) -> None:
    rng = np.random.default_rng(4)
    triangles = rng.integers(0, count, size=(40, 3))
    solid = SolidMesh("ü", rng.normal(size=(count, 3)), triangles, triangles[:, :2], (0.1, 0.2, 0.3))
    data = write_part_glb(PartMesh((solid, solid), 0.1, 0.6))
    assert unpack(pack_glb(data)) == data


def test_what_is_no_glb_is_refused() -> None:
    with pytest.raises(ValueError, match="GLB"):
        pack_glb(b"glTF" + bytes(30))


ROOT = Path(__file__).parents[3]
BUNDLES = ROOT / "wpcal" / "pages" / "bundles"
SOURCE = ROOT / "wpcal" / "pages" / "source"


def test_a_rebuild_gives_the_same_bytes(tmp_path: Path) -> None:
    node = shutil.which("node")
    if node is None:
        pytest.skip("node is not here; the bundles are compared where it is")
    if not (SOURCE / "node_modules" / "esbuild").is_dir():
        pytest.skip("wpcal/pages/source/node_modules is not here; `make viewer` installs it")
    command = [node, "build.mjs", "--out", str(tmp_path)]
    done = subprocess.run(command, cwd=SOURCE, capture_output=True, text=True, check=False, timeout=120)
    assert (done.returncode, done.stderr) == (0, "")
    built = {file.name: file.read_bytes() for file in tmp_path.iterdir()}
    kept = {file.name: file.read_bytes() for file in BUNDLES.iterdir()}
    assert built.keys() == kept.keys()
    changed = [name for name in built if built[name] != kept[name]]
    assert not changed, f"{', '.join(changed)}: run `make viewer` and commit"


def test_the_lock_file_names_no_host_and_no_folder() -> None:
    text = (SOURCE / "package-lock.json").read_text(encoding="utf-8")
    assert '"resolved"' not in text
    assert "file:" not in text


def test_the_licence_of_three_js_travels_with_it() -> None:
    head = (BUNDLES / "viewer.js").read_text(encoding="utf-8")[:2000]
    assert "three.js authors" in head
    assert "THE SOFTWARE IS PROVIDED" in head


SOURCES = "wpcal/pages/source/"
BUILT = {f"wpcal/pages/bundles/{file.name}" for file in (ROOT / "wpcal" / "pages" / "bundles").iterdir()}
NEEDED_OUTSIDE = ("README.md", "CONTRIBUTING.md", "LICENSE", "CHANGELOG.md", "Makefile", "docs/images/report.png")
NO_HATCHLING = "hatchling is not installed; `make demo` installs it with the other tools of a developer"


def test_the_wheel_has_the_bundles_and_not_their_source(tmp_path: Path) -> None:
    wheel = pytest.importorskip("hatchling.builders.wheel", reason=NO_HATCHLING)
    (built,) = wheel.WheelBuilder(str(ROOT)).build(directory=str(tmp_path), versions=["standard"])
    with zipfile.ZipFile(built) as archive:
        names = set(archive.namelist())
    assert names >= BUILT | {"wpcal/pages/html.py", "cad/__init__.py"}
    assert [name for name in names if name.startswith(SOURCES) or "node_modules" in name] == []


def test_the_source_distribution_has_what_a_reader_needs_without_installed_packages(tmp_path: Path) -> None:
    sdist = pytest.importorskip("hatchling.builders.sdist", reason=NO_HATCHLING)
    (built,) = sdist.SdistBuilder(str(ROOT)).build(directory=str(tmp_path), versions=["standard"])
    with tarfile.open(built) as archive:
        names = {name.partition("/")[2] for name in archive.getnames()}
    kept = {"build.mjs", "package.json", "package-lock.json", "biome.json", "src/viewer.js", "test/rows.test.js"}
    pictures = set(re.findall(r"\]\((docs/images/[^)]+)\)", (ROOT / "README.md").read_text(encoding="utf-8")))
    assert names >= BUILT | {SOURCES + name for name in kept} | {*NEEDED_OUTSIDE, *pictures, ".ci/run"}
    assert [name for name in names if "node_modules" in name] == []
