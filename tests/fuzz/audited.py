"""`wpcal audit` as a reader: of every record, table, program and mesh. It refuses nothing; it lists faults.

Three things are checked. The audit ends with a report that can be written down. A file that the audit calls clean is
read by the reader of its kind. A file that the audit lists with faults is not called clean by its count.
"""

import json
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path

from tests.fuzz.sample_records import sample_records
from tests.fuzz.target import FIXTURES, Target, seed
from tests.shown_programs import shown_programs
from wpcal.controllers.audit import audit_path
from wpcal.controllers.audit.programs import Surroundings
from wpcal.core.errors import InputError
from wpcal.core.records import to_json
from wpcal.core.transform import RigidTransform
from wpcal.planning.cell.cell_file import read_cell
from wpcal.planning.sequence.kept_plan import with_digest
from wpcal.robot.kinematics.arm_file import read_arm
from wpcal.robot.kinematics.urdf import read_urdf

AROUND = Surroundings(T_base_part=RigidTransform.identity(target="base", source="part"))


class AuditWrongError(Exception):
    """The audit and a reader do not agree."""


@dataclass(frozen=True, slots=True)
class Audited:
    """The audit of one file, compared with the reader of its kind, if it has one; other files may be beside it."""

    read: Callable[[Path], object] | None = None
    beside: Mapping[str, bytes] = field(default_factory=dict)

    def __call__(self, data: bytes, path: Path) -> object:
        for name, other in self.beside.items():
            path.with_name(name).write_bytes(other)
        path.write_bytes(data)
        report = audit_path(path, AROUND)
        to_json({**report.to_record(), "repaired": []}).encode("utf-8")
        if report.fault_count:
            raise InputError(report.files[0].faults[0].message)
        if self.read is not None:
            try:
                self.read(path)
            except InputError as error:
                raise AuditWrongError(f"called clean, but the reader says: {error}") from None
        return report


def audited_targets() -> dict[str, Target]:
    """Return the audit of every kind of file that it knows."""
    samples = {name.split("/")[1]: one for name, one in sample_records().items()}
    plans = {name: with_digest({**one, "made_from": {}}) for name, one in samples.items() if "digest" in one}
    records = {name: json.dumps(one).encode() for name, one in (samples | plans).items()}
    touches = json.loads(records["touches"])
    records["touches"] = json.dumps({**touches, "arm": _arm()}).encode()  # what its schema asks of an arm is not all
    cell, arm = (FIXTURES / "cells" / "two-mh6.json").read_bytes(), json.dumps(_arm()).encode()
    found = {
        "audit-advice": Target(Audited(), (records.pop("advice"),), "advice.json"),
        "audit-plan": Target(Audited(), (records.pop("plan"), records.pop("pareto")), "plan.json"),
        "audit-identification": Target(Audited(), (records.pop("identification"),), "identification.json"),
        "audit-cell": Target(Audited(read_cell), (cell,), "cell.json"),
        "audit-arm": Target(Audited(read_arm), (arm,), "arm.json"),
        "audit-urdf": Target(Audited(read_urdf), (seed("arm.urdf"),), "arm.urdf"),
    }
    elsewhere = ("cell", "arm", "seams", "welds", "weld-rules")  # what their schema asks for is not all
    others = tuple(data for name, data in records.items() if name not in elsewhere)
    found["audit-records"] = Target(Audited(), others, "record.json")
    tables = [FIXTURES / "tee" / "touches_321.csv", FIXTURES / "yin2003" / "table1.csv"]
    seeds = tuple(seed(name) for name in ("taught.csv", "pairs.csv", "bases.csv", "poses.csv", "joints.csv"))
    frames = b"seam,point,s_mm,x_mm,y_mm,z_mm,qx,qy,qz,qw\nW1,0,0,1,2,3,0,0,0,1\nW1,1,5,6,2,3,0,0,0,1\n"
    found["audit-tables"] = Target(Audited(), (*seeds, *(path.read_bytes() for path in tables), frames), "table.csv")
    for suffix, texts in written_programs().items():
        found[f"audit{suffix}"] = Target(Audited(), texts, f"program{suffix}")
    return {**found, **_of_two_robots()}


def _of_two_robots() -> dict[str, Target]:
    """Return the audit of every file of programs of two robots, with the files of the other robot beside it."""
    files = {shown.file: shown.raw for shown in shown_programs("two-robots.md")}
    return {
        f"audit-two-{name}": Target(Audited(beside={k: v for k, v in files.items() if k != name}), (text,), name)
        for name, text in files.items()
    }


def written_programs() -> dict[str, tuple[bytes, ...]]:
    """Return programs of every language that is read back, by suffix."""
    found: dict[str, tuple[bytes, ...]] = {}
    for shown in shown_programs():
        if shown.command.startswith("export"):
            suffix = Path(shown.file).suffix.lower()
            if suffix in (".mod", ".ls", ".dat", ".jbi", ".as", ".script", ".dtx"):
                found[suffix] = (*found.get(suffix, ()), shown.raw)
    return found


def _arm() -> dict[str, object]:
    from wpcal.robot.kinematics.arm_file import arm_record, find_arm

    return {**arm_record(find_arm("mh6"))}
