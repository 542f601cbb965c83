"""Write seams as an xMCF file (ISO/PAS 8329), in the coordinates of the part."""

import xml.etree.ElementTree as ET
from collections.abc import Mapping, Sequence

import numpy as np

from wpcal.core.transform import RigidTransform
from wpcal.seam.seam import JointType, Seam, WeldType
from wpcal.weld.seam_weld import SeamWeld
from wpcal.weld.section import throat_of
from wpcal.weld.values import PREPARATIONS, WeldKind

VERSION = "3.1.1"
TYPES = {
    JointType.TEE: "y_joint",
    JointType.LAP: "overlap_weld",
    JointType.CORNER: "corner_weld",
    JointType.BUTT: "butt_joint",
    JointType.EDGE: "edge_weld",
}
"""The type of seam of a joint. A joint without a word has none."""
FILLETS = ("y_joint", "overlap_weld", "corner_weld")  #: Types whose weld has a throat; that of the others has a width.
FLARED = "flared_joint"


def xmcf_text(seams: Sequence[Seam], T_part_frame: RigidTransform, welds: Mapping[str, SeamWeld]) -> str:
    """Return the text of a file."""
    root = ET.Element("xmcf")
    ET.SubElement(root, "version").text = VERSION
    ET.SubElement(root, "units", length="mm", angle="deg", mass="kg", force="N", time="s")
    groups: dict[tuple[str, ...], list[Seam]] = {}
    for seam in seams:
        groups.setdefault(seam.solids, []).append(seam)
    for number, (solids, own) in enumerate(groups.items(), 1):
        group = ET.SubElement(root, "connection_group", id=str(number))
        connected = ET.SubElement(group, "connected_to")
        for index, solid in enumerate(solids, 1):
            ET.SubElement(connected, "part", index=str(index), label=_legal(solid))
        listed = ET.SubElement(group, "connection_list")
        for seam in own:
            _connection(listed, seam, T_part_frame, welds.get(seam.name))
    ET.indent(root, " ")
    return ET.tostring(root, encoding="unicode", xml_declaration=False) + "\n"


def _connection(parent: ET.Element, seam: Seam, T_part_frame: RigidTransform, weld: SeamWeld | None) -> None:
    connection = ET.SubElement(parent, "connection_1d", label=_legal(seam.name))
    points = ET.SubElement(connection, "loc_list")
    for s, p in zip(seam.frames.s_mm.tolist(), T_part_frame.apply(seam.frames.p).tolist(), strict=True):
        ET.SubElement(points, "loc", v=_number(s)).text = " ".join(map(_number, p))
    element = ET.SubElement(connection, "seamweld")
    is_flare = seam.weld in (WeldType.FLARE_BEVEL, WeldType.FLARE_V)
    kind = FLARED if is_flare else TYPES.get(seam.joint)
    if kind is None:
        return
    joint = ET.SubElement(element, kind, technology="arc")
    out = T_part_frame.R @ seam.frames.R[len(seam.frames) // 2][:, 2]
    x, y, z = (_number(value) for value in out.tolist())
    side = ET.SubElement(joint, "weld_position", u="0.5", x=x, y=y, z=z)
    if weld is not None:
        _state(side, joint, seam, weld, kind)


def _state(side: ET.Element, joint: ET.Element, seam: Seam, weld: SeamWeld, kind: str) -> None:
    """Add what the weld data of a seam says."""
    values = weld.values
    throat = throat_of(values, np.pi - float(np.median(seam.frames.angle_rad)))
    if kind in FILLETS and values.weld is WeldKind.FILLET and throat:
        side.set("section", "Fillet")
        side.set("thickness", _number(throat))
    elif kind == "butt_joint" and values.weld is not None and values.weld in PREPARATIONS:
        side.set("section", PREPARATIONS[values.weld])
    if kind != FLARED:
        side.set("filler", "yes")
    if values.stitch is not None:
        segments = ET.SubElement(side, "segment_list")
        for start, end in weld.stretches_mm:
            ET.SubElement(segments, "segment", {"from": _number(start), "to": _number(end)})
    if values.thickness_mm is not None:
        sheet = ET.SubElement(joint, "sheet_parameter", index="1", sheet_thickness=_number(values.thickness_mm))
        if values.root_gap_mm is not None:
            sheet.set("gap", _number(values.root_gap_mm))


def _number(value: float) -> str:
    return f"{value:.9g}"


def _legal(text: str) -> str:
    """Return a name without characters that XML does not allow."""
    return "".join(c if c >= " " and c not in "\x7f\ufffe\uffff" else "_" for c in text)
