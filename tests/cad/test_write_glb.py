"""GLB, read back from its bytes: the container, its JSON and its buffer, as glTF 2.0 describes them."""

import json
import struct

import numpy as np

from cad.write_glb import TRIAD_MM, write_glb
from wpcal.core.transform import RigidTransform
from wpcal.export import WeldPath, WeldProgram
from wpcal.seam.seam import JointType, Seam, SeamFrames, SeamPieces, WeldType

SAME_MM = 1e-4
"""32-bit numbers of metres: 6e-8 of 0.5 m."""
LINES = 1


def parse(data):
    """Segments by name of node, back in mm with z up."""
    magic, version, length = struct.unpack_from("<4sII", data)
    assert (magic, version, length) == (b"glTF", 2, len(data))
    json_length, _ = struct.unpack_from("<I4s", data, 12)
    document = json.loads(data[20 : 20 + json_length])
    binary = data[28 + json_length :]
    found = {}
    for node in document["nodes"]:
        if "mesh" not in node:
            continue
        (primitive,) = document["meshes"][node["mesh"]]["primitives"]
        assert primitive["mode"] == LINES
        accessor = document["accessors"][primitive["attributes"]["POSITION"]]
        start = document["bufferViews"][accessor["bufferView"]].get("byteOffset", 0) + accessor.get("byteOffset", 0)
        x, y, z = np.frombuffer(binary, "<f4", 3 * accessor["count"], start).reshape(-1, 3).T
        found[node["name"]] = 1000.0 * np.stack([x, -z, y], axis=1).reshape(-1, 2, 3)
    return found


def test_seams_and_triads_are_named_nodes_in_metres_with_y_up():
    p = np.stack([np.linspace(400, 500, 6), np.full(6, 20.0), np.full(6, -3.25)], axis=1)
    R = np.broadcast_to(np.diag([1.0, -1.0, -1.0]), (6, 3, 3))
    none = np.zeros(1, dtype=np.int64)
    pieces = SeamPieces(none, none, none, none, none, np.zeros((1, 3)))
    frames = SeamFrames(np.arange(4.0), p[1:-1], R[1:-1], np.ones(4), "base")
    seam = Seam("Naht ä", JointType.TEE, WeldType.FILLET, (), pieces, False, 60.0, True, True, (), frames)
    program = WeldProgram((WeldPath(seam, p, R, None),), RigidTransform.identity(target="base", source="part"))
    found = parse(write_glb(program)["WPCAL.glb"])
    expected = np.stack([p[1:-2], p[2:-1]], axis=1)
    np.testing.assert_allclose(found["Naht ä"], expected, rtol=0, atol=SAME_MM)
    axes = found["Naht ä triads"].reshape(4, 3, 2, 3)
    np.testing.assert_allclose(axes[:, :, 0], np.repeat(p[1:-1, None], 3, axis=1), rtol=0, atol=SAME_MM)
    drawn = (axes[:, :, 1] - axes[:, :, 0]) / TRIAD_MM
    np.testing.assert_allclose(drawn, np.swapaxes(R[1:-1], 1, 2), rtol=0, atol=SAME_MM)
