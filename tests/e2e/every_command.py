"""Every command of wpcal with arguments that make it do its work, and a folder with the files that they name."""

import json
import shutil
from pathlib import Path

import numpy as np

from tests.drift_jobs import Planted, simulated_jobs, write_batch
from tests.one_robot_cells import one_robot_record, write_cell
from tests.running import run_here
from tests.simulated_poses import XIONG_2015_ERRORS, random_joints, simulate_poses
from wpcal.core.rotations import quaternion_from_rotation
from wpcal.robot.kinematics.arm_file import find_arm

FIXTURES = Path(__file__).parents[2] / "fixtures"
SEAM_FRAMES = 2  #: Points of the seam that is planned: the search is not what is tested.

COMMANDS = {
    "calibrate": "tee.step taught.csv -o out",
    "batch": "jobs.csv -o new -j 1",
    "advise": "tee.step --count 3",
    "audit": "out",
    "bases": "cell/two-mh6.json touched.csv -o new",
    "bodies": "tee.step -o new.json",
    "cell": "check cell/two-mh6.json -o new",
    "correct": "joints.csv --robot mh6",
    "demo": "-o new",
    "diff": "out out",
    "drift": "many -o drift.html",
    "export": "out -f rapid -f dxf -f glb -f ros -o new",
    "features": "tee.step",
    "fit": "table1.csv",
    "identify": "mh6 poses.csv -o new",
    "match": "tee.step taught.csv",
    "pick": "tee.step --no-browser -o new.csv",
    "place": "one/cell.json out -o map.svg",
    "plan": "cell/two-mh6.json seams.json --seam W1 -o new",
    "report": "out --force",
    "rpc": "",
    "seams": "tee.step --png seams.png --html seams.html",
    "sheet": "tee.step -o sheet.pdf --touch V2,V4,V16",
    "shop": "show",
    "study": "table1.csv --trials 20",
    "taught": "points.mod --uframe base",
    "tcp": "joints.csv --robot mh6",
    "torches": "-o torches.svg",
    "touches": "tee.step --touches 6 -o new",
    "touchup": "back/WPCAL.mod --of out --written written -o new",
    "verify": "out",
    "welds": "out",
}
"""In an order in which every command finds its input: `calibrate` writes the folder that others read."""
NEEDS_ROBOT = {"teach"}  #: Commands that do nothing without a robot that answers; tests of links run them against one.


def joint_rows() -> str:
    """Return postures of an arm."""
    joints = np.rad2deg(random_joints(find_arm("mh6"), 6, rng=np.random.default_rng(3)))
    lines = ["name,q1_deg,q2_deg,q3_deg,q4_deg,q5_deg,q6_deg"]
    return "\n".join([*lines, *(f"P{i}," + ",".join(f"{q:.6f}" for q in row) for i, row in enumerate(joints))]) + "\n"


def pose_rows() -> str:
    """Return forty measured poses of an arm with the errors of a paper."""
    arm, rng = find_arm("mh6"), np.random.default_rng(0)
    seen = simulate_poses(arm, XIONG_2015_ERRORS, random_joints(arm, 40, rng=rng), rng=rng)
    table = np.column_stack([np.rad2deg(seen.joints), seen.p_base, quaternion_from_rotation(seen.R_base_flange)])
    header = "q1_deg,q2_deg,q3_deg,q4_deg,q5_deg,q6_deg,x_mm,y_mm,z_mm,qx,qy,qz,qw"
    return "\n".join([header, *(",".join(f"{value:.9f}" for value in row) for row in table)]) + "\n"


def touched_rows() -> str:
    """Return points that two robots touched."""
    p_base1 = np.array([[700.0, -200, 300], [800, 100, 350], [650, 0, 500], [900, 50, 420]])
    p_base2 = (p_base1 - [1500.0, 0, 0]) * [-1, -1, 1]
    names = "name,base1_x_mm,base1_y_mm,base1_z_mm,base2_x_mm,base2_y_mm,base2_z_mm"
    rows = (f"P{i}," + ",".join(map(str, row)) for i, row in enumerate(np.hstack([p_base1, p_base2]).tolist()))
    return "\n".join([names, *rows]) + "\n"


def write_inputs(folder: Path) -> None:
    """Write what the commands read."""
    for name in ("tee.step", "taught.csv"):
        shutil.copy(FIXTURES / "tee" / name, folder)
    shutil.copy(FIXTURES / "yin2003" / "table1.csv", folder)
    shutil.copytree(FIXTURES / "cells", folder / "cell")
    (folder / "one").mkdir()
    write_cell(folder / "one", one_robot_record())
    record = json.loads((FIXTURES / "cells" / "saddle-seams.json").read_text(encoding="utf-8"))
    record["seams"][0]["frames"] = record["seams"][0]["frames"][:SEAM_FRAMES]
    (folder / "seams.json").write_text(json.dumps(record), encoding="utf-8")
    (folder / "joints.csv").write_text(joint_rows())
    (folder / "poses.csv").write_text(pose_rows())
    (folder / "touched.csv").write_text(touched_rows())
    write_batch(folder / "many", simulated_jobs(40, seed=1, planted=(Planted("P3", 20, 1.0),)), failed=1)
    (folder / "jobs.csv").write_text("job,part,taught\none,tee.step,taught.csv\n")
    done = run_here("export", FIXTURES / "tee" / "golden", "-f", "rapid", "-o", folder / "as", "--only", "W2,W3")
    assert done.returncode == 0, done.stderr
    (folder / "as" / "rapid").rename(folder / "written")
    text = (folder / "written" / "WPCAL.mod").read_text(encoding="utf-8")
    (folder / "back").mkdir()
    (folder / "back" / "WPCAL.mod").write_text(text.replace("56.00000,10.00000]", "55.60000,10.30000]"))
    target = "[[812.29,-240.62,165.80],[1,0,0,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]]"
    (folder / "points.mod").write_text(f"MODULE M\n  CONST robtarget V2:={target};\nENDMODULE\n")
