"""Nothing that lies beside a customer's file is run: every command, in a folder full of modules with known names."""

from __future__ import annotations

import json
import os
import shutil
import signal
import subprocess
import sys
from importlib.metadata import entry_points, packages_distributions
from pathlib import Path

import numpy as np
import pytest

from tests.running import FINISHED, TIMEOUT_S
from wpcal.cli.main import EXIT_INTERRUPTED
from wpcal.core.rotations import quaternion_from_rotation
from wpcal.robot.identify.simulation import XIONG_2015_ERRORS, random_joints, simulate_poses
from wpcal.robot.kinematics.arm_file import find_arm

FIXTURES = Path(__file__).parents[2] / "fixtures"
WPCAL = Path(sys.executable).with_name("wpcal")
"""The command as a user calls it."""
MARK = "RUN"
TRAP = f"open({MARK!r}, 'a').write(__name__ + ' ' + __file__ + chr(10))\nraise SystemExit(99)\n"
ALSO = ("sitecustomize", "usercustomize", "conftest", "setup", "resource", "_wpcal")
PACKAGES = ("wpcal", "cad")
SEAM_FRAMES = 2
"""Points of the seam that is planned: the search is not what is tested."""

COMMANDS = {
    "advise": "tee.step --points 3",
    "bases": "cell/two-mh6.json touched.csv -o new",
    "calibrate": "tee.step taught.csv -o new",
    "correct": "joints.csv --robot mh6",
    "demo": "-o new",
    "diff": "out out",
    "export": "out -f rapid -f dxf -f glb -f ros -o new",
    "features": "tee.step",
    "fit": "table1.csv",
    "identify": "mh6 poses.csv -o new",
    "match": "tee.step taught.csv",
    "pick": "tee.step --no-browser -o new.csv",
    "plan": "cell/two-mh6.json seams.json --seam W1 -o new",
    "report": "out --force",
    "seams": "tee.step --png seams.png --html seams.html",
    "sheet": "tee.step -o sheet.pdf --points V2,V4,V16",
    "study": "table1.csv --trials 20",
    "taught": "points.mod --uframe base",
    "tcp": "joints.csv --robot mh6",
}
"""Every command with arguments that make it do its work."""


def joint_rows() -> str:
    joints = np.rad2deg(random_joints(find_arm("mh6"), 6, rng=np.random.default_rng(3)))
    lines = ["name,q1_deg,q2_deg,q3_deg,q4_deg,q5_deg,q6_deg"]
    return "\n".join([*lines, *(f"P{i}," + ",".join(f"{q:.6f}" for q in row) for i, row in enumerate(joints))]) + "\n"


def pose_rows() -> str:
    arm, rng = find_arm("mh6"), np.random.default_rng(0)
    seen = simulate_poses(arm, XIONG_2015_ERRORS, random_joints(arm, 40, rng=rng), rng=rng)
    table = np.column_stack([np.rad2deg(seen.joints), seen.p_base, quaternion_from_rotation(seen.R_base_flange)])
    header = "q1_deg,q2_deg,q3_deg,q4_deg,q5_deg,q6_deg,x_mm,y_mm,z_mm,qx,qy,qz,qw"
    return "\n".join([header, *(",".join(f"{value:.9f}" for value in row) for row in table)]) + "\n"


def touched_rows() -> str:
    p_base1 = np.array([[700.0, -200, 300], [800, 100, 350], [650, 0, 500], [900, 50, 420]])
    p_base2 = (p_base1 - [1500.0, 0, 0]) * [-1, -1, 1]
    names = "name,base1_x_mm,base1_y_mm,base1_z_mm,base2_x_mm,base2_y_mm,base2_z_mm"
    rows = (f"P{i}," + ",".join(map(str, row)) for i, row in enumerate(np.hstack([p_base1, p_base2]).tolist()))
    return "\n".join([names, *rows]) + "\n"


def set_traps(folder: Path) -> None:
    """Write a module that leaves a mark for every name that Python or an installed package imports."""
    names = {*sys.stdlib_module_names, *packages_distributions(), *ALSO} - set(PACKAGES)
    for name in names:
        if name.isidentifier():
            (folder / f"{name}.py").write_text(TRAP)
    for name in PACKAGES:
        (folder / name).mkdir()
        (folder / name / "__init__.py").write_text(TRAP)


@pytest.fixture(scope="module")
def hostile(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with inputs for every command and traps beside them."""
    folder = tmp_path_factory.mktemp("hostile")
    for name in ("tee.step", "taught.csv"):
        shutil.copy(FIXTURES / "tee" / name, folder)
    shutil.copy(FIXTURES / "yin2003" / "table1.csv", folder)
    shutil.copytree(FIXTURES / "cells", folder / "cell")
    record = json.loads((FIXTURES / "cells" / "saddle-seams.json").read_text(encoding="utf-8"))
    record["seams"][0]["frames"] = record["seams"][0]["frames"][:SEAM_FRAMES]
    (folder / "seams.json").write_text(json.dumps(record), encoding="utf-8")
    (folder / "joints.csv").write_text(joint_rows())
    (folder / "poses.csv").write_text(pose_rows())
    (folder / "touched.csv").write_text(touched_rows())
    target = "[[812.29,-240.62,165.80],[1,0,0,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]]"
    (folder / "points.mod").write_text(f"MODULE M\n  CONST robtarget V2:={target};\nENDMODULE\n")
    (folder / "matplotlibrc").write_text("text.usetex: True\nbackend: module://evil\n")
    (folder / "evil.py").write_text(TRAP)
    subprocess.run([WPCAL, "calibrate", "tee.step", "taught.csv", "-o", "out"], cwd=folder, check=True)
    set_traps(folder)
    return folder


def test_every_command_is_tried() -> None:
    assert set(COMMANDS) == {entry.name for entry in entry_points(group="wpcal.commands")}


@pytest.mark.parametrize("command", COMMANDS)
def test_no_module_beside_the_files_is_run(hostile: Path, command: str) -> None:
    (hostile / MARK).unlink(missing_ok=True)
    shutil.rmtree(hostile / "new", ignore_errors=True)
    process = subprocess.Popen(
        [WPCAL, command, *COMMANDS[command].split()],
        cwd=hostile,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )
    if command == "pick":
        assert process.stdout is not None
        assert "is at http" in process.stdout.readline()
        process.send_signal(signal.SIGINT)
    _, errors = process.communicate(timeout=TIMEOUT_S)
    assert not (hostile / MARK).exists(), (hostile / MARK).read_text()
    assert process.returncode in (*FINISHED, EXIT_INTERRUPTED), errors  # the picker ends by Ctrl-C


def test_an_empty_entry_of_pythonpath_is_not_the_current_folder(hostile: Path) -> None:
    """A trailing colon is common in what shells of robot software set. Python itself reads such an entry early."""
    for file in hostile.glob("*.py"):
        if file.stem not in ("numpy", "scipy", "OCP", "build123d"):
            file.unlink()
    for name in PACKAGES:
        shutil.rmtree(hostile / name)
    (hostile / MARK).unlink(missing_ok=True)
    environment = {**os.environ, "PYTHONPATH": "/nowhere" + os.pathsep}
    done = subprocess.run([WPCAL, "features", "tee.step"], cwd=hostile, env=environment, check=False)
    assert not (hostile / MARK).exists()
    assert done.returncode == 0
