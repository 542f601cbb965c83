"""A GLB file in a form that deflates to half: every array as differences of neighbours, low bytes before high bytes.

Nothing is lost: the page's script (``wpcal/pages/source/src/packing.js``) restores the same bytes. Neighbours in a mesh
are near each other, so differences are small, and their high bytes are zeros in a row.
"""

from __future__ import annotations

import struct
from typing import Any

import numpy as np
import numpy.typing as npt

from wpcal.brep.mesh_glb import glb_chunks

UNSIGNED = {5120: "<u1", 5123: "<u2", 5125: "<u4"}
"""By glTF's component type; differences run over the end of the range and back, so signs do not matter."""


def pack_glb(data: bytes) -> bytes:
    """Return the JSON chunk's length and text, then every accessor's numbers, column by column.

    Parameters
    ----------
    data : bytes
        As `wpcal.brep.mesh_glb.write_part_glb` writes it: every accessor has a view of its own, in order.

    Returns
    -------
    bytes
        For `zlib.compress`.

    Raises
    ------
    ValueError
        When it is no GLB file.
    """
    document, text, binary = glb_chunks(data)
    views = document["bufferViews"]
    arrays = (_packed(accessor, views[accessor["bufferView"]], binary) for accessor in document["accessors"])
    return b"".join([struct.pack("<I", len(text)), text, *arrays])


def _packed(accessor: dict[str, Any], view: dict[str, Any], binary: bytes) -> bytes:
    """Difference to the row before, folded so that small negative numbers are small, in planes of bytes."""
    kind = np.dtype(UNSIGNED[accessor["componentType"]])
    width = view.get("byteStride", kind.itemsize) // kind.itemsize
    rows = np.frombuffer(binary, kind, accessor["count"] * width, view["byteOffset"]).reshape(-1, width)
    steps = np.diff(rows, axis=0, prepend=np.zeros((1, width), kind)).view(kind.str.replace("u", "i"))
    folded = ((steps << 1) ^ (steps >> (8 * kind.itemsize - 1))).view(kind)
    columns: npt.NDArray[np.uint8] = np.ascontiguousarray(folded.T).view(np.uint8)
    return columns.reshape(-1, kind.itemsize).T.tobytes()
