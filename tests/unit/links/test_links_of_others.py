"""The fakes as clients of others see them, and our client at a server of others. These packages are no dependencies."""

import json
import subprocess
import sys
from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from tests.robot_servers import PASSWORD, USER, Robot, metres
from wpcal.robot.kinematics.arm_file import find_arm
from wpcal.robot.links.opcua import open_opcua
from wpcal.robot.links.reading import Address

pytestmark = pytest.mark.deep


def of_others(name: str) -> Any:
    return pytest.importorskip(name, reason="no client of others is installed")


def test_ur_rtde_reads_our_fake() -> None:
    """In a process of its own: its constructor waits for the server without letting another thread run."""
    of_others("rtde_receive")
    names = ["timestamp", "actual_TCP_pose", "actual_q"]
    code = f"""
import json, rtde_receive, time
client = rtde_receive.RTDEReceiveInterface("127.0.0.1", 25.0, {names})
time.sleep(0.3)
print(json.dumps([client.getActualTCPPose(), client.getActualQ()]))
client.disconnect()
"""
    robot = Robot()
    with robot.serve("ur", port=30004):
        done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=30, check=True)
    place, joints = json.loads(done.stdout.splitlines()[-1])
    np.testing.assert_allclose(place, metres(robot.T_base_tool), rtol=0, atol=1e-12)
    np.testing.assert_allclose(np.degrees(joints), robot.joints_deg, rtol=0, atol=1e-12)


def test_py_openshowvar_reads_our_fake() -> None:
    library, robot = of_others("py_openshowvar"), Robot()
    with robot.serve("kuka") as port:
        client = library.openshowvar("127.0.0.1", port)
        assert client.read("$ACT_TOOL", debug=False) == b"7"
        assert client.read("$TOOL", debug=False).startswith(b"{FRAME: X 60.00000, Y 10.00000, Z 370.00000, A ")
        assert client.read("$NONE", debug=False) is None
        client.close()


def test_abb_robot_client_reads_our_fake() -> None:
    library, robot = of_others("abb_robot_client.rws"), Robot()
    with robot.serve("abb") as port:
        client = library.RWS(f"http://127.0.0.1:{port}", USER, PASSWORD)
        found = client.get_robtarget(tool="7", wobj="wobj0", coordinate="Wobj")
        np.testing.assert_allclose(found.trans, robot.T_base_tool.t_mm, rtol=0, atol=1e-6)
        turn = Rotation.from_quat(np.roll(found.rot, -1)).as_matrix()
        np.testing.assert_allclose(turn, robot.T_base_tool.R, rtol=0, atol=1e-8)
        np.testing.assert_allclose(client.get_jointtarget().robax, robot.joints_deg, rtol=0, atol=1e-4)


def test_our_client_reads_the_server_of_asyncua() -> None:
    library, ua = of_others("asyncua.sync"), of_others("asyncua.ua")
    arm, joints = find_arm("irb1600_6_12"), [10.0, 20.0, -15.0, 5.0, 40.0, -60.0]
    server = library.Server()
    server.set_endpoint("opc.tcp://127.0.0.1:48401")
    with server:
        place = server.nodes.objects
        for name in ("DeviceSet", "MotionDeviceSystem", "MotionDevices", "Arm", "Axes"):
            place = place.add_object(1, name)
        for row, value in enumerate(joints, 1):
            inside = place.add_object(1, f"Axis_{row}").add_object(1, "ParameterSet")
            unit, factor = (17_476, 1.0) if row % 2 else (4_405_297, np.pi / 180.0)  # degrees and radians
            position = inside.add_variable(1, "ActualPosition", float(value * factor))
            position.add_property(0, "EngineeringUnits", ua.EUInformation(UnitId=unit))
        link = open_opcua(Address(host="127.0.0.1", port=48401, arm="irb1600_6_12"), lambda _: ("", ""))
        found = link.read()
        link.close()
    np.testing.assert_allclose(np.degrees(found.joints_rad), joints, rtol=0, atol=1e-9)
    expected = arm.forward(np.radians([joints]))[0]
    np.testing.assert_allclose(found.T_base_tool.matrix, expected, rtol=0, atol=1e-9)
    assert found.tool.name == "0"
