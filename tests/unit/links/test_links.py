"""Links against fake controllers: what they read, what they ask, and what never becomes a row."""

import contextlib
import random
import socket
import threading
import time
from dataclasses import replace
from functools import partial
from types import SimpleNamespace

import numpy as np
import pytest

from tests.few import few
from tests.robot_servers import PASSWORD, USER, Robot, damaged, fake_tls, page
from wpcal.core.transform import RigidTransform
from wpcal.robot.kinematics.arm_file import find_arm
from wpcal.robot.links import abb, fanuc, judge, kuka, ur, wire
from wpcal.robot.links.judge import STILL_MM, Accepted, ArmMovesError, RowJudge
from wpcal.robot.links.reading import Address, LinkError, Reading, RobotLink, Setting
from wpcal.robot.links.registry import installed_links, link_opener
from wpcal.robot.links.watch import Watch

OPEN = {
    "ur": ur.open_ur,
    "kuka": kuka.open_kuka,
    "fanuc": fanuc.open_http,
    "fanuc-ftp": fanuc.open_ftp,
    "abb": abb.open_irc5,
}
PRINTED_MM, PRINTED_RAD = 0.0051, 1.6e-4  #: Half of the last digit of FANUC's page: 0.01 mm and 0.01 degrees.
ASKED = {
    "ur": {"V", "O", "S"},
    "kuka": {f"0 ${name}" for name in ("BASE", "TOOL", "ACT_TOOL", "ACT_BASE", "POS_ACT", "AXIS_ACT", "IPO_MODE")},
    "fanuc": {"GET"},
    "fanuc-ftp": {"USER", "TYPE", "PASV", "RETR"},
    "abb": {"GET"},
}
CASES = 10_000


def credentials(_: str) -> tuple[str, str]:
    return USER, PASSWORD


def opened(kind: str, port: int) -> RobotLink:
    return OPEN[kind](Address(host="127.0.0.1", port=port), credentials)


def read_once(link: RobotLink) -> Reading:
    with contextlib.closing(link):
        return link.read()


@pytest.mark.parametrize("kind", OPEN)
def test_a_link_reads_the_position_in_the_base_and_asks_for_nothing_else(kind: str) -> None:
    robot = Robot()
    with robot.serve(kind) as port:
        link = opened(kind, port)
        for turn in range(3):
            robot.T_base_tool = RigidTransform.from_six_tuple(
                [300.0 * turn - 400, 712.5, -3.25, 0.3 * turn, -0.5, 2.0], target="base", source="tool"
            )
            time.sleep(0.1 if kind == "ur" else 0.0)  # a stream holds the position before
            found = link.read()
            assert found.T_base_tool.is_close(robot.T_base_tool, atol_mm=2 * PRINTED_MM, atol_rad=2 * PRINTED_RAD)
            np.testing.assert_allclose(np.degrees(found.joints_rad), robot.joints_deg, rtol=0, atol=PRINTED_MM)
        link.close()
    expected = ("", "base") if kind == "ur" else ("7", "3")
    assert (found.tool.name, found.frame.name) == expected
    words = robot.asked if kind in ("ur", "kuka") else [line.split()[0] for line in robot.asked]
    assert set(words) <= ASKED[kind]


def test_every_kind_is_an_entry_point_with_its_function() -> None:
    loaded = {name: point.load() for name, point in installed_links().items()}
    assert {name: loaded[name] for name in OPEN} == OPEN
    assert {"omnicore", "opcua"} <= set(loaded)


@pytest.mark.parametrize(
    "text", ["ur", "ur:", "none:10.0.0.1", "ur:10.0.0.1,tol=7", "ur:a b", "ur:h:99999", "ur:h,tool"]
)
def test_what_is_no_address_is_one_line(text: str) -> None:
    with pytest.raises(LinkError) as error:
        link_opener(text)
    assert "\n" not in str(error.value)


def reading(x_mm: float = 0.0, *, ago_s: float = 0.0, tool: str = "7", frame: str = "1") -> Reading:
    T = RigidTransform(np.eye(3), np.array([x_mm, 0.0, 0.0]), "base", "tool")
    return Reading(T, Setting(tool), Setting(frame), None, time.monotonic() - ago_s)


def stood(**changes: str) -> list[Reading]:
    return [reading(ago_s=ago, **changes) for ago in (0.3, 0.2, 0.05)]


def test_an_arm_that_stood_is_accepted_once_it_has_stood() -> None:
    assert RowJudge().accept(stood()).note == "tool 7, frame 1"
    with pytest.raises(ArmMovesError):
        RowJudge().accept(stood()[1:])
    with pytest.raises(ArmMovesError):
        RowJudge().accept([reading(3 * STILL_MM, ago_s=0.3), *stood()[1:]])


@pytest.mark.parametrize(
    ("judge_", "readings", "says"),
    [
        (RowJudge(), [reading(ago_s=2.0), reading(ago_s=0.6)], "0.6 s old"),
        (RowJudge(tool="2"), stood(), "tool 7 is active, expected tool 2"),
        (RowJudge(frame="0"), stood(), "frame 1 is active, expected frame 0"),
        (RowJudge(), stood(tool="0"), "which is the flange"),
        (RowJudge(), [reading(1e6, ago_s=ago) for ago in (0.3, 0.05)], "farther away"),
        (RowJudge(), [*stood(tool="6")[:2], *stood()[2:]], "changed just now"),
    ],
)
def test_what_must_not_become_a_row_is_refused_in_one_line(
    judge_: RowJudge, readings: list[Reading], says: str
) -> None:
    shift = time.monotonic() - max(each.asked_s for each in readings) - (0.6 if "old" in says else 0.01)
    with pytest.raises(LinkError, match=says) as error:
        judge_.accept([replace(each, asked_s=each.asked_s + shift) for each in readings])
    assert "\n" not in str(error.value)


def test_a_second_row_has_the_tool_of_the_first_and_may_be_shown_in_another_frame() -> None:
    one = RowJudge()
    one.accept(stood())
    assert "row before was shown in frame 1" in one.accept(stood(frame="2")).note
    with pytest.raises(LinkError, match="row before was touched with tool 7"):
        one.accept(stood(tool="8"))


def test_without_a_tool_on_the_pendant_the_given_one_is_used() -> None:
    tool = RigidTransform(np.eye(3), np.array([0.0, 0.0, 320.0]), "flange", "tool")
    found = RowJudge(T_flange_tool=tool).accept(stood(tool="tool0"))
    assert found.T_base_tool.t_mm.tolist() == [0.0, 0.0, 320.0]
    assert "--tool" in found.note


def test_joints_of_another_moment_than_the_position_are_refused() -> None:
    """By the model of the robot, wherever it stands; the tool's values are --tool, if the robot tells none."""
    arm, tool = find_arm("irb1600_6_12"), offset("flange", "tool", 320.0)
    place = RigidTransform.from_six_tuple([10, 20, 500, 0, 0, 1.0], target="base", source="model")
    one = RowJudge(T_flange_tool=tool, arm=arm)
    for turn, q in enumerate(
        np.radians([[10.0, 20, -15, 5, 40, -60], [40.0, 10, 5, 5, 30, 20], [40.0, 10, 5, 5, 30, 20]])
    ):
        flange = RigidTransform.from_matrix(arm.forward(q[None])[0], target="model", source="flange")
        reads = [
            replace(each, T_base_tool=place @ flange @ tool, joints_rad=q + 0.01 * (turn == 2)) for each in stood()
        ]
        if turn < 2:
            assert one.accept(reads).kept().T_flange_tool == [320.0, 0, 0, 0, 0, 0]
    with pytest.raises(LinkError, match=r"joints and position are \d+\.\d mm apart"):
        one.accept(reads)


@pytest.mark.parametrize("kind", OPEN)
def test_a_key_takes_the_position_and_an_arm_that_comes_to_rest(kind: str) -> None:
    robot = Robot(delay_s=0.02)
    before = robot.T_base_tool
    with robot.serve(kind) as port:
        watch = Watch(lambda: opened(kind, port), RowJudge())
        first = watch.take()
        robot.T_base_tool = RigidTransform(before.R, before.t_mm + np.array([0.0, 0.0, 4.0]), "base", "tool")
        second = watch.take()
        watch.close()
    moved = second.T_base_tool.t_mm - first.T_base_tool.t_mm
    np.testing.assert_allclose(moved, [0, 0, 4], rtol=0, atol=4 * PRINTED_MM)
    assert second.reading.asked_s > first.reading.asked_s


def test_a_robot_that_is_not_there_is_one_line_at_once_and_found_when_it_is_back() -> None:
    robot = Robot()
    with robot.serve("kuka") as port:
        pass
    watch = Watch(lambda: opened("kuka", port), RowJudge())
    with pytest.raises(LinkError, match="no connection"):
        watch.take()
    with robot.serve("kuka", port=port):
        assert found_again(watch).T_base_tool.is_close(robot.T_base_tool, atol_mm=1e-4, atol_rad=1e-6)
    watch.close()


def found_again(watch: Watch) -> Accepted:
    """Press the key until the robot answers."""
    while True:
        with contextlib.suppress(LinkError):
            return watch.take()


@pytest.mark.parametrize("is_new", [True, False])
def test_the_page_of_a_public_controller_is_read(is_new: bool) -> None:
    """As printed by R-30iA (V7.70) and R-30iB Plus (V9.40): zeros before the point are dropped, other groups follow."""
    place = RigidTransform.from_six_tuple([-0.06, 836.54, 328.94, 0.2, 0, -1.5], target="base", source="tool")
    text = page(Robot(T_base_tool=place), is_new=is_new).replace("-0.06", " -.06")
    found = fanuc.reading_of_page(text, 0.0)
    assert found.T_base_tool.is_close(place, atol_mm=2 * PRINTED_MM, atol_rad=2 * PRINTED_RAD)
    for wrong in (
        text.replace("  -.06", "******"),
        text.replace("Group #:  1", "Group #:  3"),
        text[:400],
        "",
        "4" * 9000,
    ):
        with pytest.raises(LinkError):
            fanuc.reading_of_page(wrong, 0.0)


def test_the_certificate_of_the_first_connection_is_pinned_and_said(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(abb, "_PINNED", {})
    robot = Robot()
    with robot.serve("abb", fake_tls()) as port:
        address = Address(host="127.0.0.1", port=port)
        found = read_once(abb.open_omnicore(address, credentials))
        said = capsys.readouterr().err
        assert said.count("certificate pinned for this run") == 1
        pin = said.partition("pin=")[2].split()[0]
        read_once(abb.open_omnicore(replace(address, pin=pin), credentials))
        asked = len(robot.asked)
        with pytest.raises(LinkError, match="not the pinned one"):
            read_once(abb.open_omnicore(replace(address, pin="0" * 64), credentials))
    assert found.T_base_tool.is_close(robot.T_base_tool, atol_mm=1e-5, atol_rad=1e-7)
    assert len(robot.asked) == asked, "something was sent to a controller with another certificate"
    assert capsys.readouterr().err == ""


def test_no_password_is_sent_in_plain_text_to_who_asks_for_it() -> None:
    answer = b"HTTP/1.1 401 Unauthorized\r\nWWW-Authenticate: Basic realm=x\r\nContent-Length: 0\r\n\r\n"
    with socket.create_server(("127.0.0.1", 0)) as server:
        threading.Thread(target=pour, args=(server, answer), daemon=True).start()
        with pytest.raises(LinkError, match="asks for the password in plain text"):
            read_once(opened("abb", server.getsockname()[1]))


@pytest.mark.parametrize("kind", ["ur", "kuka", "fanuc", "fanuc-ftp", "abb"])
@pytest.mark.parametrize(
    "answer", [b"", b"\xff" * 70_000, b"HTTP/1.1 200 OK\r\nContent-Length: 99999999999\r\n\r\n", "drip"]
)
def test_half_huge_and_endless_answers_are_one_line(kind: str, answer: bytes | str) -> None:
    with socket.create_server(("127.0.0.1", 0)) as server:
        threading.Thread(target=pour, args=(server, answer), daemon=True).start()
        with pytest.raises(LinkError) as error:
            read_once(opened(kind, server.getsockname()[1]))
    assert "\n" not in str(error.value)


def pour(server: socket.socket, answer: bytes | str) -> None:
    """Answer each connection with the same bytes, or one byte at a time without an end."""
    with contextlib.suppress(OSError):
        while True:
            connection, _ = server.accept()
            with connection, contextlib.suppress(OSError):
                while answer == "drip":
                    connection.sendall(b"2")
                    time.sleep(0.05)
                connection.sendall(answer)  # type: ignore[arg-type]


def test_a_decimal_comma_is_no_end_of_a_number() -> None:
    with pytest.raises(LinkError):
        fanuc.reading_of_page(page(Robot()).replace(".", ","), 0.0)
    robot = Robot(damage=lambda data: data.replace(b".", b","))
    with robot.serve("kuka") as port, pytest.raises(LinkError, match="not a structure of numbers"):
        read_once(opened("kuka", port))


def test_a_frame_that_changes_within_a_reading_is_refused() -> None:
    robot = Robot()
    robot.damage = partial(with_another_frame, robot, random.Random(1))
    with robot.serve("kuka") as port, pytest.raises(LinkError, match=r"\$BASE or \$TOOL changed"):
        read_once(opened("kuka", port))


@pytest.mark.parametrize("count", few([200, CASES], 1))
def test_no_fault_of_network_person_or_controller_makes_a_wrong_row(
    count: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    """With a clock of its own: four readings 0.1 s apart are one key."""
    rng, clock = random.Random(20), SimpleNamespace(now=5000.0)
    for module in (abb, fanuc, judge, kuka, ur):
        monkeypatch.setattr(module, "time", SimpleNamespace(monotonic=lambda: clock.now))
    monkeypatch.setattr(ur, "HERTZ", 2000.0)
    monkeypatch.setattr(wire, "ANSWER_S", 0.15)
    taken = dict.fromkeys(FAULTS, 0)
    for kind in OPEN:
        robot, asked = Robot(clock=lambda: clock.now), RowJudge()
        with robot.serve(kind) as port:
            link: RobotLink | None = None
            for number in range(count // len(OPEN)):
                fault = FAULTS[number % len(FAULTS)]
                link, is_taken = one_key(fault, (kind, port), robot, asked, rng, clock, link)
                taken[fault] += is_taken
            if link is not None:
                link.close()
    assert taken["none"] >= 0.9 * (count // len(OPEN) // len(FAULTS)) * len(OPEN)
    assert taken["tool"] == taken["old"] == taken["moving"] == taken["stops"] == 0


FAULTS = ("none", "damage", "tool", "old", "moving", "damage", "stops", "frame", "between")


def one_key(
    fault: str,
    where: tuple[str, int],
    robot: Robot,
    asked: RowJudge,
    rng: random.Random,
    clock: SimpleNamespace,
    link: RobotLink | None,
) -> tuple[RobotLink | None, bool]:
    """Press one key with a fault; return the link, and whether a row was made. A wrong row fails."""
    place = [rng.uniform(-1500, 1500) for _ in range(3)] + [rng.uniform(-1.4, 1.4) for _ in range(3)]
    start = Robot()
    robot.T_base_tool = RigidTransform.from_six_tuple(np.round(place, 2), target="base", source="tool")
    robot.tool, robot.T_flange_tool, robot.damage = start.tool, start.T_flange_tool, bytes
    kind, _ = where
    readings: list[Reading] = []
    try:
        link = link or opened(*where)
        if fault == "damage":
            robot.damage = damaged(rng, is_text=kind != "ur")
        if fault == "between":
            robot.damage = partial(with_another_frame, robot, rng)
        wrong_from = rng.randrange(5)
        for turn in range(5):
            if fault == "tool" and turn == wrong_from:
                robot.tool = rng.choice(["0", "8", "", "77"])
                robot.T_flange_tool = offset("flange", "tool", rng.uniform(1, 400))
            if fault == "moving" or (fault == "stops" and turn == 3):
                robot.T_base_tool = offset("base", "base", rng.uniform(0.1, 4)) @ robot.T_base_tool
            if fault == "frame" and turn == 1:
                robot.T_base_frame = offset("base", "frame", rng.uniform(1, 400))
            clock.now += 0.1
            readings.append(link.read())
        if fault == "old":
            clock.now += rng.uniform(0.51, 20)
        found = asked.accept(readings)
    except LinkError as error:
        message = str(error)
        if link is not None and (fault == "damage" or "refused" not in message):
            link.close()
            link = None
        return link, "\n" in message
    off = float(np.linalg.norm(found.T_base_tool.t_mm - robot.T_base_tool.t_mm))
    assert off <= STILL_MM + 2 * PRINTED_MM, (fault, kind, off)
    assert kind == "ur" or found.reading.tool.name == "7", (fault, kind)
    return link, True


def with_another_frame(robot: Robot, rng: random.Random, data: bytes) -> bytes:
    """Change the frame after each answer, and so between the answers of one reading."""
    robot.T_base_frame = offset("base", "frame", rng.uniform(1, 400))
    return data


def offset(target: str, source: str, x_mm: float) -> RigidTransform:
    return RigidTransform(np.eye(3), np.array([x_mm, 0.0, 0.0]), target, source)


def test_a_position_that_was_kept_back_is_older_by_all_but_the_drift_of_two_clocks(monkeypatch):
    monkeypatch.setattr(ur, "time", SimpleNamespace(monotonic=lambda: 108.0))
    link = object.__new__(ur.UrLink)
    link._offset_s, link._last_s = 5.0, 99.0
    assert link._offset_at(101.0) == pytest.approx(5.0002, rel=0, abs=1e-9)
    assert link._offset_at(104.0) == 4.0  # a quicker way than before
