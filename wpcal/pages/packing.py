"""A GLB file in a form that deflates to half the size: arrays as differences of neighbours, low bytes before high ones.

Nothing is lost: the script of the page (``wpcal/pages/source/src/packing.js``) restores the same bytes. Neighbours in a
mesh are near each other. So the differences are small, and most of their high bytes are zero.
"""

from __future__ import annotations

import struct
from typing import Any

import numpy as np
import numpy.typing as npt

from wpcal.brep.mesh_glb import glb_chunks

UNSIGNED = {5120: "<u1", 5123: "<u2", 5125: "<u4"}
"""By component type of glTF. Signs do not matter, because differences overflow and return."""


def pack_glb(data: bytes) -> bytes:
    """Return the length and text of the JSON chunk, then the numbers of every accessor, column by column.

    Returns: Input for `zlib.compress`.
    Raises `ValueError` if `data` is not a GLB file.
    """
    document, text, binary = glb_chunks(data)
    views = document["bufferViews"]
    arrays = (_packed(accessor, views[accessor["bufferView"]], binary) for accessor in document["accessors"])
    return b"".join([struct.pack("<I", len(text)), text, *arrays])


def _packed(accessor: dict[str, Any], view: dict[str, Any], binary: bytes) -> bytes:
    """Return differences to the row before as planes of bytes; folded: a small negative number stays small."""
    kind = np.dtype(UNSIGNED[accessor["componentType"]])
    width = view.get("byteStride", kind.itemsize) // kind.itemsize
    rows = np.frombuffer(binary, kind, accessor["count"] * width, view["byteOffset"]).reshape(-1, width)
    steps = np.diff(rows, axis=0, prepend=np.zeros((1, width), kind)).view(kind.str.replace("u", "i"))
    folded = ((steps << 1) ^ (steps >> (8 * kind.itemsize - 1))).view(kind)
    columns: npt.NDArray[np.uint8] = np.ascontiguousarray(folded.T).view(np.uint8)
    return columns.reshape(-1, kind.itemsize).T.tobytes()
