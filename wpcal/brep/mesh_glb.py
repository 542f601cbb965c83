"""`part.glb`: a part's triangles as a small glTF 2.0 file, which other viewers can open.

The file has one node per solid. Positions are 16-bit steps from the corner of the solid's own box (extension
``KHR_mesh_quantization``); the scale and translation of the node convert them to millimetres in the frame `part`. The
root node ``part`` converts to metres with y up, as glTF requires. ``asset.extras`` holds the deflection and angle of
the mesh and the hash of the model.

References: Khronos Group, glTF 2.0 Specification (ISO/IEC 12113:2022), and its extension KHR_mesh_quantization.
"""

import json
import struct
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from wpcal.brep.mesh import PartMesh, Rgb, SolidMesh, vertex_normals
from wpcal.core.arrays import FloatArray, frozen
from wpcal.core.errors import FormatError
from wpcal.core.result_files import PART_FILE

STEPS = 65535  #: Positions are 16-bit: steps of at least 1/65535 of a solid's size.
STEPS_PER_DEFLECTION = 10
"""Finer steps would store digits below the accuracy of the triangles, and such digits do not compress."""
LARGEST_BYTE = 127.0  #: Normals are 8-bit, exact to 0.5°: steps of the shading are not visible.
METRES_Y_UP = [1e-3, 0, 0, 0, 0, 0, -1e-3, 0, 0, 1e-3, 0, 0, 0, 0, 0, 1]
"""Column by column, as glTF stores a matrix: (x, y, z) mm become (x, z, -y) / 1000."""
UNSIGNED_SHORT, UNSIGNED_INT, BYTE = 5123, 5125, 5120
ARRAY, ELEMENTS = 34962, 34963
TRIANGLES, LINES = 4, 1
_HEADER, _CHUNK = struct.Struct("<4sII"), struct.Struct("<I4s")
PART_RGB: Rgb = (0.72, 0.76, 0.80)  #: Light steel, for other viewers, if the model states no colour.


def write_part_glb(mesh: PartMesh) -> bytes:
    """Write a part as GLB. Contents of the file, the same for the same mesh."""
    buffer = _Buffer()
    step_mm = mesh.deflection_mm / STEPS_PER_DEFLECTION
    nodes = [_solid_node(buffer, number, solid, step_mm) for number, solid in enumerate(mesh.solids)]
    root = {"name": "part", "matrix": METRES_Y_UP, "children": list(range(1, len(nodes) + 1))}
    document = {
        "asset": {
            "version": "2.0",
            "generator": "wpcal",
            "extras": {
                "frame": "part",
                "deflection_mm": mesh.deflection_mm,
                "angle_rad": mesh.angle_rad,
                "sha256": mesh.sha256,
            },
        },
        "extensionsUsed": ["KHR_mesh_quantization"],
        "extensionsRequired": ["KHR_mesh_quantization"],
        "scene": 0,
        "scenes": [{"nodes": [0]}],
        "nodes": [root, *nodes],
        "meshes": buffer.meshes,
        "materials": buffer.materials,
        "accessors": buffer.accessors,
        "bufferViews": buffer.views,
        "buffers": [{"byteLength": len(buffer.data)}],
    }
    return _container(document, bytes(buffer.data))


def _container(document: dict[str, Any], data: bytes) -> bytes:
    text = json.dumps(document, separators=(",", ":")).encode("ascii")
    text += b" " * (-len(text) % 4)
    data += b"\0" * (-len(data) % 4)
    chunks = _CHUNK.pack(len(text), b"JSON") + text + _CHUNK.pack(len(data), b"BIN\0") + data
    return _HEADER.pack(b"glTF", 2, _HEADER.size + len(chunks)) + chunks


@dataclass(slots=True)
class _Buffer:
    """The lists of a glTF document while they grow."""

    data: bytearray = field(default_factory=bytearray)
    views: list[dict[str, Any]] = field(default_factory=list)
    accessors: list[dict[str, Any]] = field(default_factory=list)
    meshes: list[dict[str, Any]] = field(default_factory=list)
    materials: list[dict[str, Any]] = field(default_factory=list)
    colours: dict[Rgb | None, int] = field(default_factory=dict)

    def add(self, rows: Any, component: int, target: int, **accessor: Any) -> int:
        """Append an array; rows of attributes are padded to a multiple of four bytes."""
        kind = "SCALAR" if rows.ndim == 1 else "VEC3"
        view: dict[str, Any] = {"buffer": 0, "byteOffset": len(self.data), "target": target}
        if rows.ndim == 2:
            rows = np.pad(rows, ((0, 0), (0, 1)))
            view["byteStride"] = int(rows.itemsize * rows.shape[1])
        raw = rows.tobytes()
        view["byteLength"] = len(raw)
        self.data += raw + b"\0" * (-len(raw) % 4)
        self.views.append(view)
        head = {"bufferView": len(self.views) - 1, "componentType": component, "count": len(rows), "type": kind}
        self.accessors.append({**head, **accessor})
        return len(self.accessors) - 1

    def material(self, color_rgb: Rgb | None) -> int:
        """Return the number of the material of a colour."""
        if color_rgb not in self.colours:
            self.colours[color_rgb] = len(self.materials)
            factors = {
                "baseColorFactor": [*linear_light(color_rgb or PART_RGB), 1.0],
                "metallicFactor": 0.0,
                "roughnessFactor": 0.7,
            }
            stated = {"stated": color_rgb is not None}
            self.materials.append({"pbrMetallicRoughness": factors, "doubleSided": True, "extras": stated})
        return self.colours[color_rgb]


def linear_light(rgb: Rgb) -> Rgb:
    """Return linear light of sRGB (IEC 61966-2-1), rounded to six decimals: far below a step of a screen."""
    r, g, b = (round(v / 12.92 if v <= 0.04045 else ((v + 0.055) / 1.055) ** 2.4, 6) for v in rgb)
    return r, g, b


def _srgb(linear: list[float]) -> Rgb:
    r, g, b = (round(v * 12.92 if v <= 0.0031308 else 1.055 * v ** (1 / 2.4) - 0.055, 4) for v in linear[:3])
    return r, g, b


def _solid_node(buffer: _Buffer, number: int, solid: SolidMesh, step_mm: float) -> dict[str, Any]:
    low = solid.points.min(axis=0)
    scale = max(float(np.ptp(solid.points, axis=0).max()) / STEPS, step_mm)
    steps = np.rint((solid.points - low) / scale).astype("<u2")
    limits = {"min": steps.min(axis=0).tolist(), "max": steps.max(axis=0).tolist()}
    position = buffer.add(steps, UNSIGNED_SHORT, ARRAY, **limits)
    n = vertex_normals(solid.points, solid.triangles) if solid.normals is None else solid.normals
    turns = np.rint(LARGEST_BYTE * n).astype("<i1")
    normal = buffer.add(turns, BYTE, ARRAY, normalized=True)
    kind, component = ("<u2", UNSIGNED_SHORT) if len(solid.points) < STEPS else ("<u4", UNSIGNED_INT)
    material = buffer.material(solid.color_rgb)
    faces = {
        "attributes": {"POSITION": position, "NORMAL": normal},
        "indices": buffer.add(solid.triangles.astype(kind).ravel(), component, ELEMENTS),
        "material": material,
        "mode": TRIANGLES,
    }
    primitives = [faces]
    if len(solid.edges):
        indices = buffer.add(solid.edges.astype(kind).ravel(), component, ELEMENTS)
        primitives.append({"attributes": {"POSITION": position}, "indices": indices, "mode": LINES})
    buffer.meshes.append({"name": solid.name, "primitives": primitives})
    return {"name": solid.name, "mesh": number, "translation": low.tolist(), "scale": [scale] * 3}


# Reading -------------------------------------------------------------------------------------------------------------


def read_part_glb(data: bytes, *, path: str = PART_FILE) -> PartMesh:
    """Read a file of `write_part_glb`. Points exact to one step of the file.

    Raises `FormatError` if `data` is not such a file.
    """
    try:
        document, _, binary = glb_chunks(data)
        extras = document["asset"]["extras"]
        solids = tuple(_read_solid(document, binary, node) for node in document["nodes"] if "mesh" in node)
        return PartMesh(solids, float(extras["deflection_mm"]), float(extras["angle_rad"]), extras["sha256"])
    except (KeyError, IndexError, TypeError, ValueError) as error:
        raise FormatError(f"is not a part.glb of wpcal: {type(error).__name__} {error}", path=path) from None


def glb_chunks(data: bytes) -> tuple[dict[str, Any], bytes, bytes]:
    """Return the JSON of a GLB file, the unchanged text of the JSON, and the binary chunk.

    Raises `ValueError` if `data` is not a complete GLB file.
    """
    if len(data) < _HEADER.size + _CHUNK.size or _HEADER.unpack_from(data) != (b"glTF", 2, len(data)):
        raise ValueError("not a complete GLB file")
    size, _ = _CHUNK.unpack_from(data, _HEADER.size)
    start = _HEADER.size + _CHUNK.size
    text = data[start : start + size]
    return json.loads(text), text, data[start + size + _CHUNK.size :]


def _read_solid(document: dict[str, Any], binary: bytes, node: dict[str, Any]) -> SolidMesh:
    primitives = {item["mode"]: item for item in document["meshes"][node["mesh"]]["primitives"]}
    faces = primitives[TRIANGLES]
    steps = _read(document, binary, faces["attributes"]["POSITION"])
    points: FloatArray = frozen(steps * node["scale"][0] + np.array(node["translation"]))
    triangles = _read(document, binary, faces["indices"]).reshape(-1, 3).astype(np.int64)
    edges = np.zeros((0, 2), dtype=np.int64)
    if LINES in primitives:
        edges = _read(document, binary, primitives[LINES]["indices"]).reshape(-1, 2).astype(np.int64)
    material = document["materials"][faces["material"]]
    colour = material["pbrMetallicRoughness"]["baseColorFactor"] if material["extras"]["stated"] else None
    normals: FloatArray = frozen(_read(document, binary, faces["attributes"]["NORMAL"]) / LARGEST_BYTE)
    rgb = None if colour is None else _srgb(colour)
    return SolidMesh(node["name"], points, triangles, edges, rgb, normals)


def _read(document: dict[str, Any], binary: bytes, number: int) -> Any:
    accessor = document["accessors"][number]
    view = document["bufferViews"][accessor["bufferView"]]
    kind = np.dtype({BYTE: "<i1", UNSIGNED_SHORT: "<u2", UNSIGNED_INT: "<u4"}[accessor["componentType"]])
    width = view.get("byteStride", kind.itemsize) // kind.itemsize
    rows = np.frombuffer(binary, kind, accessor["count"] * width, view["byteOffset"]).reshape(-1, width)
    return rows[:, :3] if accessor["type"] == "VEC3" else rows.ravel()
