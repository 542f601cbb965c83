import json
import xml.etree.ElementTree as ET
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from wpcal.core.errors import FormatError, InputError
from wpcal.core.records import to_json
from wpcal.core.robot_space import RobotSpace
from wpcal.robot.kinematics.arm import Arm
from wpcal.robot.kinematics.arm_file import arm_from_record, arm_record, find_arm, read_arm, shipped_arms
from wpcal.robot.kinematics.urdf import read_urdf

ROBOTS = Path(__file__).parents[4] / "shared" / "robots"
URDF_MM = 1e-6  # the links of the data files are rounded to 1e-6 mm and degrees
ROUND_OFF_MM = 1e-9  # three orders above the round-off of a few metres

ARMS_WITH_URDF = sorted(set(shipped_arms()) - {"mh6"})

TWO_JOINTS = """<robot name="bench">
 <link name="root"/><link name="arm"/><link name="hand"/>
 <joint name="first" type="revolute"><parent link="root"/><child link="arm"/>
  <origin xyz="0.1 0 0.3" rpy="0 0 0"/><axis xyz="0 0 1"/><limit lower="-1" upper="2" velocity="3"/></joint>
 <joint name="second" type="{kind}"><parent link="arm"/><child link="hand"/>
  <origin xyz="0.2 0 0" rpy="0.3 0.4 0.5"/><axis xyz="0 1 0"/></joint>
</robot>"""


def urdf_pose(path, q, base, tip):
    """Pose of a tip in a base, joint by joint from the XML with SciPy's rotations: shares no code with the package."""
    joints = {joint.find("child").get("link"): joint for joint in ET.parse(path).getroot().findall("joint")}

    def pose(link):
        way = []
        while link in joints:
            way.insert(0, joints[link])
            link = joints[link].find("parent").get("link")
        T, angles = np.eye(4), list(q)
        for joint in way:
            origin, step = joint.find("origin"), np.eye(4)
            if origin is not None:
                step[:3, :3] = Rotation.from_euler("xyz", [float(v) for v in origin.get("rpy").split()]).as_matrix()
                step[:3, 3] = [1000 * float(v) for v in origin.get("xyz").split()]
            T = T @ step
            if joint.get("type") == "revolute":
                axis = np.array([float(v) for v in joint.find("axis").get("xyz").split()])
                turn = np.eye(4)
                turn[:3, :3] = Rotation.from_rotvec(angles.pop(0) * axis / np.linalg.norm(axis)).as_matrix()
                T = T @ turn
        return T

    return np.linalg.inv(pose(base)) @ pose(tip)


@pytest.mark.skipif(not ROBOTS.is_dir(), reason="the folder of URDF files lies beside the checkout and is not here")
@pytest.mark.parametrize("name", ARMS_WITH_URDF)
def test_a_shipped_arm_moves_as_its_urdf(name):
    path, arm = ROBOTS / name / f"{name}.urdf", find_arm(name)
    for q in np.random.default_rng(0).uniform(-3, 3, (5, 6)):
        wanted = urdf_pose(path, arm.coupling_matrix @ q, "base", "tool0")  # a URDF has no couplings
        np.testing.assert_allclose(arm.forward([q])[0], wanted, rtol=0, atol=URDF_MM * 10)
    mount = urdf_pose(path, np.zeros(6), "base", "base_link")
    np.testing.assert_allclose(arm.mount_mm, mount[:3, 3], rtol=0, atol=URDF_MM)


@pytest.mark.skipif(not ROBOTS.is_dir(), reason="the folder of URDF files lies beside the checkout and is not here")
@pytest.mark.parametrize("folder", ["gp8", "kr16_2", "irb120_3_58", "m20ia", "kr10r1420"])
def test_a_urdf_is_read_as_it_moves(folder):
    path = ROBOTS / folder / f"{folder}.urdf"
    arm = read_urdf(path)
    for q in np.random.default_rng(1).uniform(-3, 3, (5, 6)):
        np.testing.assert_allclose(arm.forward([q])[0], urdf_pose(path, q, "base", "tool0"), rtol=0, atol=ROUND_OFF_MM)


def test_a_small_urdf_with_skew_axes_is_read_as_it_moves(tmp_path):
    path = tmp_path / "bench.urdf"
    path.write_text(TWO_JOINTS.format(kind="revolute"))
    arm = read_urdf(path)
    for q in ([0.0, 0.0], [0.3, -0.7], [-2.0, 1.0]):
        np.testing.assert_allclose(arm.forward([q])[0], urdf_pose(path, q, "root", "hand"), rtol=0, atol=ROUND_OFF_MM)
    assert [joint.name for joint in arm.joints] == ["first", "second"]
    assert (arm.joints[0].min_rad, arm.joints[0].max_rad, arm.joints[0].speed_rad_s) == (-1.0, 2.0, 3.0)


def test_a_urdf_with_a_sliding_joint_is_refused(tmp_path):
    path = tmp_path / "bench.urdf"
    path.write_text(TWO_JOINTS.format(kind="prismatic"))
    with pytest.raises(FormatError, match="joint second is prismatic"):
        read_urdf(path)


@pytest.mark.parametrize("text", ["not xml", "<robot/>", "<robot><joint name='j' type='revolute'/></robot>"])
def test_what_is_no_urdf_is_refused(tmp_path, text):
    path = tmp_path / "bench.urdf"
    path.write_text(text)
    with pytest.raises(FormatError, match=r"bench\.urdf"):
        read_urdf(path)


@pytest.mark.parametrize("name", shipped_arms())
def test_an_arm_file_reads_back_what_was_written(name, tmp_path):
    arm = find_arm(name)
    table = arm.chain.table + 0.01
    identified = arm.as_identified(arm.chain.with_table(table))
    path = tmp_path / "arm.json"
    path.write_text(to_json(arm_record(identified)))
    again = read_arm(path)
    q = np.random.default_rng(2).uniform(-1, 1, (5, 6))
    np.testing.assert_allclose(again.forward(q), identified.forward(q), rtol=0, atol=ROUND_OFF_MM)
    np.testing.assert_allclose(again.as_nominal().forward(q), arm.forward(q), rtol=0, atol=ROUND_OFF_MM)
    assert again.space is RobotSpace.IDENTIFIED
    assert [joint.name for joint in again.joints] == [joint.name for joint in arm.joints]
    np.testing.assert_allclose(again.limits, arm.limits, rtol=0, atol=1e-12)
    assert again.couplings == arm.couplings


def test_every_shipped_arm_states_its_source():
    assert len(shipped_arms()) >= 7
    for name in shipped_arms():
        arm = find_arm(name)
        assert arm.source
        assert arm.licence
        assert arm.space is RobotSpace.NOMINAL


def changed(change):
    record = arm_record(find_arm("mh6"))
    change(record)
    return record


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda r: r["links"].pop(), "5 links, but 6 joints"),
        (lambda r: r["joints"].pop(), "6 links, but 5 joints"),
        (lambda r: r.pop("links"), "'links' is missing"),
        (lambda r: r["links"][0].pop("a_mm"), "'a_mm' is missing"),
        (lambda r: r["links"][0].update(a_mm="wide"), r"links\[0\].a_mm: expected a number"),
        (lambda r: r["links"][0].update(parallel_to_next=1), "true or false"),
        (lambda r: r["joints"][0].update(sign=2), "joint S: sign: expected -1 or 1, got 2"),
        (lambda r: r["joints"][0].update(min_deg=300), "lower limit"),
        (lambda r: r["joints"][0].update(name="L"), "unique"),
        (lambda r: r.update(couplings=[{"joint": "U", "adds": "X", "factor": 1}]), "'X'"),
        (lambda r: r.update(robot_space="true"), 'expected "identified" or "nominal"'),
        (lambda r: r.update(robot_space="identified"), "carries the nominal chain"),
        (lambda r: r.update(mount_mm=[1, 2]), "expected 3 entries"),
        (lambda r: r.update(T_base_dh0={"xyz_mm": [1], "rpy_deg": [0, 0, 0]}), "expected 3 entries"),
        (lambda r: r.update(schema="wpcal/arm/9"), "expected a record of schema"),
    ],
)
def test_a_wrong_arm_file_is_one_clear_error(tmp_path, change, message):
    path = tmp_path / "arm.json"
    path.write_text(json.dumps(changed(change)))
    with pytest.raises(FormatError, match=message):
        read_arm(path)


def test_an_unknown_arm_lists_the_shipped_ones():
    with pytest.raises(InputError, match="m10ia"):
        find_arm("mh7")


def test_pulses_go_both_ways_and_need_their_scale(tmp_path):
    record = changed(lambda r: [joint.update(pulses_per_deg=1000.0 + 10 * i) for i, joint in enumerate(r["joints"])])
    arm = find_arm("mh6")
    with pytest.raises(InputError, match="not stated for joint S"):
        arm.pulses_from_angles(np.zeros(6))
    path = tmp_path / "arm.json"
    path.write_text(json.dumps(record))
    scaled = read_arm(path)
    pulses = scaled.pulses_from_angles(np.deg2rad([1, 2, 3, 4, 5, -6]))
    assert pulses.tolist() == [1000, 2020, 3060, 4120, 5200, -6300]
    np.testing.assert_allclose(np.rad2deg(scaled.angles_from_pulses(pulses)), [1, 2, 3, 4, 5, -6], rtol=0, atol=1e-12)


def test_a_wrong_number_of_joint_angles_is_refused():
    with pytest.raises(InputError, match="6 joints"):
        find_arm("mh6").forward(np.zeros((1, 5)))


def test_a_name_that_no_file_can_have_and_a_joint_without_speed_are_refused(tmp_path):
    with pytest.raises(InputError, match="too long"):
        find_arm("a" * 300)
    record = json.loads(to_json(arm_record(find_arm("mh6"))))
    record["joints"][2]["speed_deg_s"] = 0
    (tmp_path / "arm.json").write_text(json.dumps(record))
    with pytest.raises(FormatError, match=r"joint \w+: speed_deg_s: expected a number from 0.001"):
        read_arm(tmp_path / "arm.json")


def test_what_a_file_leaves_out_an_arm_has_by_itself():
    record = arm_record(find_arm("mh6"))
    arm = arm_from_record({name: record[name] for name in ("name", "links", "joints", "robot_space")})
    bare = arm_record(Arm(arm.name, arm.chain, arm.joints))
    assert arm_record(arm) == bare
    assert bare["mount_mm"] == [0.0, 0.0, 0.0]
    assert np.array_equal(arm.coupling_matrix, np.diag([joint.sign for joint in arm.joints]))
