"""Packing against a plain inverse. The script of the page unpacks the same way; a browser test compares its drawing."""

import json
import struct

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
