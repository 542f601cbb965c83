"""Every reader of wpcal as a function of bytes, with inputs that it accepts."""

import json
from contextlib import suppress
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

from cad.pick.draft import read_draft
from cad.session.rows import Rows, read_rows
from cad.step.append import append_placement, with_entities
from cad.step.bake import bake_text
from cad.step.open_text import read_step_text
from cad.step.part21 import index_part21
from cad.step.products import components_of, find_roots
from cad.workpiece.bodies import read_bodies
from tests.fuzz.audited import audited_targets
from tests.fuzz.batches import batch_targets
from tests.fuzz.further import CELL, further_targets
from tests.fuzz.rpc_lines import rpc_targets
from tests.fuzz.target import FIXTURES, Target, of_path, seed
from tests.fuzz.touch_results import touch_results_targets
from wpcal.brep.graph_file import read_graph
from wpcal.brep.mesh_glb import read_part_glb
from wpcal.controllers.language.grammar import ENCODING
from wpcal.controllers.taught_program import require_program
from wpcal.controllers.user_frames import ANY_FRAME, ProgramReading, parse_uframes, points_in_base, usable_points
from wpcal.core.errors import InputError
from wpcal.core.tables import parse_table
from wpcal.core.transform import RigidTransform
from wpcal.robot.identify.poses_file import parse_tool, read_poses, read_taught_joints
from wpcal.robot.kinematics.arm_file import arm_record, find_arm, read_arm
from wpcal.robot.kinematics.urdf import read_urdf
from wpcal.robot.torch.file import read_torch
from wpcal.seam.seam import JointType, Seam, SeamFrames, SeamPieces, WeldType
from wpcal.taught.pairs import read_pairs
from wpcal.taught.programs import ProgramReader, TaughtProgram
from wpcal.taught.table import taught_csv, taught_from_table
from wpcal.touch.grasp import read_base_points, read_holding
from wpcal.weld.find import find_welds
from wpcal.weld.record import read_stated_welds
from wpcal.weld.rules import read_rules, shipped_rules, shipped_text
from wpcal.weld.runs import weld_runs
from wpcal.weld.xmcf.read import parse_xmcf

TORCHES = tuple(
    path.read_bytes()
    for path in sorted((Path(__file__).parents[2] / "wpcal" / "robot" / "torch" / "torches").glob("*.json"))
)
MOVED = RigidTransform.from_six_tuple([100.0, -20.0, 3.0, 0.1, -0.2, 0.3], target="base", source="part")


@cache
def mh6() -> Any:
    return find_arm("mh6")


def taught(data: bytes, _: Path) -> object:
    points = taught_from_table(parse_table(data, path="taught.csv"))
    assert np.isfinite(points.p_base).all()
    return taught_csv(points)


def rows(data: bytes, _: Path) -> object:
    found = read_rows(data, path="taught.csv")
    again = Rows.from_record(json.loads(json.dumps(found.to_record())))
    with suppress(InputError):
        again.to_taught()
    return again


@cache
def reader_of(suffix: str) -> ProgramReader:
    return require_program(Path(f"teach{suffix}")).load_reader()


def program(data: bytes, path: Path) -> object:
    reader = reader_of(path.suffix)
    found = TaughtProgram(path.name, reader, reader.read(data.decode(ENCODING), path.name))
    names, _ = usable_points(found)
    identity = "0,0,0,1,0,0,0" if path.suffix == ".mod" else "0,0,0,0,0,0"
    points = points_in_base(found, ProgramReading(parse_uframes([identity]), tool=(0, 0, 100), points=names))
    assert np.isfinite(points.p_base).all()
    assert ANY_FRAME == ""
    return taught_csv(points)


def tool_option(data: bytes, _: Path) -> object:
    return parse_tool(data.decode("latin-1").removesuffix(".json"))


def step_text(data: bytes, path: Path) -> object:
    path.write_bytes(data)
    file = read_step_text(path)
    roots = find_roots(file)
    for root in roots:
        components_of(file, root)
    assert file.schema is not None
    writer, _ = append_placement(file, MOVED, name="moved")
    index_part21(with_entities(file, writer), name="moved")
    return bake_text(file, MOVED)


def draft_seed() -> bytes:
    table = {"columns": ["name", "x_mm", "y_mm", "z_mm"], "rows": [["A", "1", "2", "3"]], "keys": ["a1"]}
    part = {"file": "tee.step", "sha256": "0" * 64}
    return json.dumps({"schema": "wpcal/pick-draft/1", "part": part, "file_sha256": None, "table": table}).encode()


WELDS = b"""{"schema": "wpcal/welds/1", "welds": [{"name": "W1", "values": {"thickness_mm": 8, "leg_mm": 12,
"passes": 3, "weave": {"shape": "sine", "width_mm": 3, "length_mm": 2}, "stitch": {"length_mm": 20, "pitch_mm": 50},
"job": 4, "crater": {"time_s": 0.5}, "weld": "fillet weld", "wire_mm": 1.2, "speed_mm_s": 5, "position": "PB"}}]}"""
XMCF = b"""<xmcf><version>3.1.1</version><units length="mm" angle="deg"/><connection_group id="1"><connected_to>
<part index="1" label="a"/></connected_to><connection_list><connection_1d label="X"><loc_list><loc v="0">0 0 0</loc>
<loc v="1">100 0 0</loc></loc_list><seamweld><y_joint technology="arc"><weld_position u="0" x="0" y="0" z="1"
section="Fillet" thickness="4"><regular_segments num_segments="3" length="20" spacing="30"/></weld_position>
<weld_position u="0" x="0" y="0" z="1"><segment_list><segment from="1" to="3"/><segment from="6" to="8"/></segment_list>
</weld_position><sheet_parameter index="1" gap="1" sheet_thickness="8" sheet_angle="90"/></y_joint></seamweld>
</connection_1d></connection_list></connection_group></xmcf>"""


def welds(data: bytes, path: Path) -> object:
    """Read a file of welds, and find the weld of a seam with what it states."""
    path.write_bytes(data)
    line = np.linspace(0.0, 100.0, 5)[:, None] * [1.0, 0.0, 0.0]
    frames = SeamFrames(line[:, 0], line, np.broadcast_to(np.eye(3), (5, 3, 3)), np.full(5, np.pi / 2), "base")
    i, f = np.zeros(1, dtype=np.int64), np.zeros(1)
    pieces = SeamPieces(i, f, f, i, i, np.zeros((1, 3)))
    seam = Seam("W1", JointType.TEE, WeldType.FILLET, ("a", "b"), pieces, False, 100.0, True, True, (), frames)
    stated = read_stated_welds(path, shipped_rules())
    found = find_welds([seam], RigidTransform(np.eye(3), np.zeros(3), "base", "part"), shipped_rules(), stated=stated)
    return [run.seam.frames.p for run in weld_runs(seam, found.welds[0])]


@cache
def targets() -> dict[str, Target]:
    """Return every reader by name."""
    tee = (FIXTURES / "tee" / "tee.step").read_bytes()
    tables = [(FIXTURES / "tee" / name).read_bytes() for name in ("taught.csv", "touches_321.csv")]
    table_seeds = (seed("taught.csv"), *tables)
    arm = json.dumps(arm_record(mh6())).encode()
    found = {
        "taught": Target(taught, table_seeds),
        "rows": Target(rows, table_seeds),
        "pairs": Target(of_path(read_pairs), (seed("pairs.csv"), (FIXTURES / "yin2003" / "table1.csv").read_bytes())),
        "bodies": Target(of_path(read_bodies), ((FIXTURES / "uprights" / "bodies.json").read_bytes(),)),
        "bases": Target(of_path(read_base_points), (seed("bases.csv"),)),
        "poses": Target(of_path(lambda path: read_poses(path, mh6())), (seed("poses.csv"),)),
        "joints": Target(of_path(lambda path: read_taught_joints(path, mh6())), (seed("joints.csv"),)),
        "uframe": Target(lambda data, _: parse_uframes([data.decode("latin-1")]), (b"2=1,2,3,4,5,6", b"wPart")),
        "tool-option": Target(tool_option, (b"800,0,300,0,0,90", b"0,0,100")),
        "urdf": Target(of_path(read_urdf), (seed("arm.urdf"),)),
        "arm": Target(of_path(read_arm), (arm,)),
        "torch": Target(of_path(read_torch), TORCHES),
        "holding": Target(of_path(lambda path: read_holding(path, "0,0,0,0,-90,0")), (CELL.read_bytes(),)),
        "tool": Target(
            of_path(lambda path: parse_tool(str(path))),
            (b'{"schema": "wpcal/tool/1", "xyz_mm": [1, 2, 300.5], "error_95_mm": 0.1}',),
            "tool.json",
        ),
        "draft": Target(of_path(read_draft), (draft_seed(),)),
        "welds": Target(welds, (WELDS,)),
        "xmcf": Target(lambda data, _: parse_xmcf(data, path="welds.xml"), (XMCF,)),
        "weld-rules": Target(of_path(read_rules), (shipped_text().encode(),)),
        "glb": Target(lambda data, _: read_part_glb(data), (part_glb(),)),
        "graph": Target(of_path(read_graph), ((FIXTURES / "graphs" / "plain-block.npz").read_bytes(),)),
        "step": Target(step_text, (tee, (FIXTURES / "lap" / "lap.step").read_bytes()), "part.step"),
    }
    for suffix in ("mod", "ls", "dat", "jbi", "as"):
        found[suffix] = Target(program, (seed(f"teach.{suffix}"),), f"teach.{suffix}")
    found |= touch_results_targets()
    found |= further_targets()
    found |= audited_targets()
    found |= rpc_targets()
    found |= batch_targets()
    return found


def part_glb() -> bytes:
    from wpcal.brep.mesh import PartMesh, SolidMesh
    from wpcal.brep.mesh_glb import write_part_glb

    p = np.array([[0, 0, 0], [10, 0, 0], [0, 10, 0], [0, 0, 10]], dtype=np.float64)
    triangles = np.array([[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]])
    solid = SolidMesh("wedge", p, triangles, np.array([[0, 1], [1, 2]]), (0.5, 0.25, 0.125), None)
    return write_part_glb(PartMesh((solid,), 0.1, 0.2, "0" * 64))
