"""Fake controllers for the links: one robot, its protocols, and the faults of a network."""

import base64
import contextlib
import hashlib
import json
import random
import re
import socket
import socketserver
import ssl
import struct
import threading
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from scipy.spatial.transform import Rotation

from wpcal.core.rotations import zyx_from_rotation
from wpcal.core.transform import RigidTransform

DIGEST = 'Digest realm="validusers@robapi.abb", nonce="abc", qop="auth"'
USER, PASSWORD = "Default User", "not a secret: a fake"
NO_AXES = dict.fromkeys([f"eax{dash}{axis}" for axis in "abcdef" for dash in ("", "_")], "8999999488.000000")
RTDE_TYPES = {"timestamp": "DOUBLE", "actual_TCP_pose": "VECTOR6D", "actual_q": "VECTOR6D", "tcp_offset": "VECTOR6D"}


class CutError(Exception):
    """The fake ends the connection."""


@dataclass
class Robot:
    """What the fake controllers show, and what goes wrong on the way."""

    T_base_tool: RigidTransform = field(
        default_factory=lambda: RigidTransform.from_six_tuple(
            [812.34, -45.67, 501.02, 0.4, -0.2, 2.5], target="base", source="tool"
        )
    )
    tool: str = "7"
    frame: str = "3"
    T_flange_tool: RigidTransform = field(
        default_factory=lambda: RigidTransform.from_six_tuple([60, 10, 370, 0, 0.7, 0], target="flange", source="tool")
    )
    T_base_frame: RigidTransform = field(
        default_factory=lambda: RigidTransform.from_six_tuple([500, 100, 30, 0, 0, 0.3], target="base", source="frame")
    )
    joints_deg: tuple[float, ...] = (10.0, -70.0, 95.5, 0.0, -30.25, 12.0)
    files: dict[str, bytes] = field(default_factory=dict)
    knows_offset: bool = True
    delay_s: float = 0.0
    clock: Callable[[], float] = time.monotonic
    lag_s: float = 0.0  #: By how much the clock of RTDE packages is behind.
    damage: Callable[[bytes], bytes] = bytes  #: What happens to the bytes of an answer.
    asked: list[str] = field(default_factory=list)  #: Everything that clients asked for.

    @property
    def T_frame_tool(self) -> RigidTransform:
        """The tool in the frame that the robot shows."""
        T = np.linalg.inv(self.T_base_frame.matrix) @ self.T_base_tool.matrix
        return RigidTransform.from_matrix(T, target="frame", source="tool")

    def send(self, connection: socket.socket, data: bytes) -> None:
        """Send bytes after the delay, and damaged."""
        if self.delay_s:
            time.sleep(self.delay_s)
        damaged = self.damage(data)
        connection.sendall(damaged)
        if len(damaged) < len(data):
            raise CutError

    @contextlib.contextmanager
    def serve(self, kind: str, tls: ssl.SSLContext | None = None, port: int = 0) -> Iterator[int]:
        """Serve a protocol on a port of this machine."""
        robot, answer = (
            self,
            {"ur": rtde, "ur-log": primary, "kuka": kukavar, "fanuc": web, "fanuc-ftp": ftp, "abb": rws}[kind],
        )

        class Handler(socketserver.BaseRequestHandler):
            def handle(self) -> None:
                with contextlib.suppress(CutError, OSError, EOFError):
                    self.request.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
                    found = self.request if tls is None else tls.wrap_socket(self.request, server_side=True)
                    with found:
                        answer(robot, found)

        socketserver.ThreadingTCPServer.allow_reuse_address = True
        with socketserver.ThreadingTCPServer(("127.0.0.1", port), Handler) as server:
            server.daemon_threads, server.block_on_close = True, False
            threading.Thread(target=server.serve_forever, args=(0.02,), daemon=True).start()
            try:
                yield server.server_address[1]
            finally:
                server.shutdown()


def fake_tls() -> ssl.SSLContext:
    """Return what encrypts with the certificate of the fake."""
    tls = ssl.SSLContext(ssl.PROTOCOL_TLS_SERVER)
    tls.load_cert_chain(Path(__file__).parent / "samples" / "fake_robot.pem")
    return tls


def exact(connection: socket.socket, count: int) -> bytes:
    """Return the next bytes."""
    data = b""
    while len(data) < count:
        more = connection.recv(count - len(data))
        if not more:
            raise EOFError
        data += more
    return data


def lines(connection: socket.socket) -> Iterator[str]:
    """Return the lines that arrive."""
    buffer = b""
    while True:
        while b"\n" not in buffer:
            more = connection.recv(4096)
            if not more:
                return
            buffer += more
        line, _, buffer = buffer.partition(b"\n")
        yield line.decode("latin-1").rstrip("\r")


def angles(T: RigidTransform) -> list[float]:
    """Return x, y, z in mm, and angles about x, y, z in degrees."""
    return [*T.t_mm.tolist(), *np.degrees(zyx_from_rotation(T.R)).tolist()]


def metres(T: RigidTransform) -> list[float]:
    """Return x, y, z in m and the rotation vector."""
    return [*(T.t_mm / 1000.0).tolist(), *Rotation.from_matrix(T.R).as_rotvec().tolist()]


def rtde(robot: Robot, connection: socket.socket) -> None:
    """Universal Robots: RTDE, protocol version 2."""
    names, recipe, hertz = [""], 1, 0.0

    def stream() -> None:
        sent = -1.0
        with contextlib.suppress(OSError, CutError):
            while True:
                while robot.clock() == sent:  # a clock that stands has no package
                    time.sleep(0.0005)
                sent, values = robot.clock(), list[float]()
                for name in names:
                    values += {
                        "timestamp": [sent - robot.lag_s - 1000.0],
                        "actual_TCP_pose": metres(robot.T_base_tool),
                        "actual_q": np.radians(robot.joints_deg).tolist(),
                        "tcp_offset": metres(robot.T_flange_tool),
                    }.get(name, [0.0] * (6 if "actual" in name or "target" in name else 1))
                body = struct.pack(f"!B{len(values)}d", recipe, *values)
                robot.send(connection, struct.pack("!HB", len(body) + 3, ord("U")) + body)
                time.sleep(1.0 / hertz)

    while True:
        size, kind = struct.unpack("!HB", exact(connection, 3))
        data = exact(connection, size - 3)
        robot.asked.append(chr(kind))
        body = b"\x01"
        if kind == ord("O"):
            (hertz,), names = struct.unpack("!d", data[:8]), data[8:].decode().rstrip(",").split(",")
            known = {**RTDE_TYPES} if robot.knows_offset else {k: v for k, v in RTDE_TYPES.items() if k != "tcp_offset"}
            types = [known.get(name, "NOT_FOUND") for name in names]
            body = bytes([recipe]) + ",".join(types).encode()
        elif kind == ord("v"):
            body = struct.pack("!4I", 5, 11, 0, 0)
        robot.send(connection, struct.pack("!HB", len(body) + 3, kind) + body)
        if kind == ord("S"):
            threading.Thread(target=stream, daemon=True).start()


def primary(robot: Robot, connection: socket.socket) -> None:
    """Universal Robots: the primary interface; a touch program that writes into the log when somebody listens."""

    def package(kind: int, body: bytes) -> None:
        robot.send(connection, struct.pack("!iB", len(body) + 5, kind) + body)

    for line in robot.files["log_history.txt"].splitlines():
        package(16, bytes(60))  # the state of the robot
        package(20, struct.pack("!QbbiB", 0, -2, 7, 0, 0) + b"a key message")
        package(20, struct.pack("!Qbb", 0, -3, 0) + line)


def kukavar(robot: Robot, connection: socket.socket) -> None:
    """KUKAVARPROXY: variables by name."""

    def frame(T: RigidTransform, head: str, more: str = "") -> str:
        x, y, z, c, b, a = angles(T)
        return f"{{{head}: X {x:.5f}, Y {y:.5f}, Z {z:.5f}, A {a:.5f}, B {b:.5f}, C {c:.5f}{more}}}"

    while True:
        number, length = struct.unpack("!HH", exact(connection, 4))
        body = exact(connection, length)
        (count,) = struct.unpack("!H", body[1:3])
        name = body[3 : 3 + count].decode()
        robot.asked.append(f"{body[0]} {name}")
        base = robot.T_base_frame
        axes = ", ".join(f"A{row} {value:.5f}" for row, value in enumerate(robot.joints_deg, 1))
        known = {
            "$POS_ACT": frame(robot.T_frame_tool, "E6POS", ", S 2, T 35, E1 0.0, E2 0.0"),
            "$BASE": frame(base, "FRAME"),
            "$TOOL": frame(robot.T_flange_tool, "FRAME"),
            "$ACT_TOOL": robot.tool,
            "$ACT_BASE": robot.frame,
            "$AXIS_ACT": f"{{E6AXIS: {axes}, E1 0.0}}",
            "$IPO_MODE": "#BASE",
        }
        for each in robot.files.values():
            known |= dict(re.findall(r"^(?:DECL \w+ )?(WP\w+(?:\[\])?)=(.*?)\r?$", each.decode(), re.MULTILINE))
        value = known.get(name, "").replace("{X", "{E6POS: X").encode()
        done = b"\x00\x01\x01" if value else b"\x00\x00\x00"
        answer = struct.pack("!BH", body[0], len(value)) + value + done
        robot.send(connection, struct.pack("!HH", number, len(answer)) + answer)


def page(robot: Robot, *, is_new: bool = True) -> str:
    """Return the text of ``curpos.dg``, of V9 or of V7.7 (whose configuration comes last)."""
    cells = [f"{key}: {value:9.2f}" for key, value in zip("XYZWPR", angles(robot.T_base_tool), strict=True)]
    place = "\n".join(["CFG: N U T, 0, 0, 0", *cells] if is_new else [*cells, "CFG: N U T, 0, 0, 0"])
    shown = "\n".join(f"{key}: {value:9.2f}" for key, value in zip("XYZWPR", angles(robot.T_frame_tool), strict=True))
    joints = "\n".join(f"Joint   {row}: {value:9.2f}" for row, value in enumerate(robot.joints_deg, 1))
    return f"""<HTML><BODY><PRE>
F Number: E33151
VERSION : ArcTool
DATE:     11-FEB-20 15:40

CURRENT ROBOT POSITION::
Group #:  1

CURRENT JOINT POSITION:
{joints}

Frame #:  {robot.frame}  Tool #:  {robot.tool}
CURRENT USER FRAME POSITION:
{shown}

Tool #:  {robot.tool}
CURRENT WORLD POSITION:
{place}

CURRENT ROBOT POSITION::
Group #:  2

CURRENT JOINT POSITION:
Joint   1:     12.34

Frame #:  0  Tool #:  7
CURRENT USER FRAME POSITION:
Cartesian position cannot be calculated

Tool #:  7
CURRENT WORLD POSITION:
Cartesian position cannot be calculated
</PRE></BODY></HTML>
"""


def requests(robot: Robot, connection: socket.socket) -> Iterator[tuple[str, dict[str, str]]]:
    """Return path and head of every request."""
    head: list[str] = []
    for line in lines(connection):
        if line:
            head.append(line)
            continue
        robot.asked.append(head[0])
        fields = dict(each.split(": ", 1) for each in head[1:])
        yield head[0].split()[1], {name.lower(): value for name, value in fields.items()}
        head = []


def web(robot: Robot, connection: socket.socket) -> None:
    """FANUC: a web server that closes after each answer."""
    for path, _ in requests(robot, connection):
        name = path.removeprefix("/MD/").lower()
        body = page(robot).encode() if name == "curpos.dg" else robot.files.get(name)
        status = "404 Not Found" if body is None else "200 OK"
        robot.send(connection, f"HTTP/1.0 {status}\r\nContent-Type: text/html\r\n\r\n".encode() + (body or b""))
        connection.close()
        return


def ftp(robot: Robot, connection: socket.socket) -> None:
    """FANUC: an FTP server that asks for no password."""
    robot.send(connection, b"220 R-30iB FTP server ready.\r\n")
    with socket.create_server(("127.0.0.1", 0)) as listening:
        for line in lines(connection):
            robot.asked.append(line)
            word, _, rest = line.partition(" ")
            name = rest.removeprefix("MD:").lower()
            if word == "PASV":
                high, low = divmod(listening.getsockname()[1], 256)
                robot.send(connection, f"227 Entering Passive Mode (127,0,0,1,{high},{low})\r\n".encode())
            elif word == "RETR":
                body = page(robot, is_new=False).encode() if name == "curpos.dg" else robot.files.get(name)
                with listening.accept()[0] as data:
                    robot.send(connection, b"550 not found\r\n" if body is None else b"150 opening\r\n")
                    if body is not None:
                        robot.send(data, body)
                if body is not None:
                    robot.send(connection, b"226 done\r\n")
            else:
                robot.send(connection, b"230 logged in\r\n" if word == "USER" else b"200 ok\r\n")


def rws(robot: Robot, connection: socket.socket) -> None:
    """ABB: Robot Web Services, 1 with digest, 2 (asked for by its media type) with basic authentication."""
    for path, head in requests(robot, connection):
        is_second = "v=2.0" in head.get("accept", "")
        given = head.get("authorization", "")
        if not (basic_is_right(given) if is_second else digest_is_right(given, path)):
            scheme = 'Basic realm="OmniCore"' if is_second else DIGEST
            robot.send(
                connection,
                f"HTTP/1.1 401 Unauthorized\r\nWWW-Authenticate: {scheme}\r\nContent-Length: 0\r\n\r\n".encode(),
            )
            continue
        T = robot.T_base_tool
        q = Rotation.from_matrix(T.R).as_quat()
        state: dict[str, str] = {"_type": "ms-mechunit", "tool-name": robot.tool, "wobj-name": robot.frame}
        if "/robtarget" in path:
            state = {"_type": "ms-robtargets", **{key: f"{v:.6f}" for key, v in zip("xyz", T.t_mm, strict=True)}}
            state |= {**dict.fromkeys(("cf1", "cf4", "cf6", "cfx"), "0"), **NO_AXES}
            state |= {f"q{row}": f"{q[column]:.9f}" for row, column in ((1, 3), (2, 0), (3, 1), (4, 2))}
        elif "/jointtarget" in path:
            state = {f"rax_{row}": f"{value:.5f}" for row, value in enumerate(robot.joints_deg, 1)} | NO_AXES
            state["_type"] = "ms-jointtarget"
        inner = {"state": [state]} if is_second else {"_links": {}, "_embedded": {"_state": [state]}}
        body = json.dumps(inner).encode()
        home = "/fileservice/HOME" if is_second else "/fileservice/$HOME"
        where, name = path.partition("?")[0], path.partition("?")[0].rpartition("/")[2].lower()
        if where == home:
            listed = [{"_type": "fs-file", "_title": each} for each in robot.files]
            body = json.dumps({"_embedded": {"resources" if is_second else "_state": listed}}).encode()
        elif "/fileservice/" in path:
            is_there = where.startswith(home) and "hal+json" not in head.get("accept", "")
            body = robot.files.get(name, b"") if is_there else b""
        status = "404 Not Found" if "/fileservice/" in path and not body else "200 OK"
        cookie = "Set-Cookie: -http-session-=4::http.session::1; path=/"
        first = (
            f"HTTP/1.1 {status}\r\n{cookie}\r\nContent-Type: application/json\r\nContent-Length: {len(body)}\r\n\r\n"
        )
        robot.send(connection, first.encode() + body)


def basic_is_right(given: str) -> bool:
    """Tell whether an authorization is of the user of the fakes."""
    return given == "Basic " + base64.b64encode(f"{USER}:{PASSWORD}".encode()).decode()


def digest_is_right(given: str, path: str) -> bool:
    """Tell the same of a digest."""
    values = {key: a or b for key, a, b in re.findall(r'(\w+)=(?:"([^"]*)"|([^\s,]+))', given)}
    if not given.startswith("Digest ") or values.get("uri") != path:
        return False
    who, what = (
        hashlib.md5(text.encode()).hexdigest() for text in (f"{USER}:{values['realm']}:{PASSWORD}", f"GET:{path}")
    )
    text = ":".join([who, *(values[key] for key in ("nonce", "nc", "cnonce", "qop")), what])
    return hashlib.md5(text.encode()).hexdigest() == values["response"]


def damaged(rng: random.Random, *, is_text: bool) -> Callable[[bytes], bytes]:
    """Return a fault of the bytes of some answers, or another way to print numbers and names in all."""
    kind = rng.choice(("cut", "bits", "noise", "doubled", *(("comma", "names") if is_text else ())))

    def damage(data: bytes) -> bytes:
        if not data or (kind not in ("comma", "names") and rng.random() < 0.6):
            return data
        found = bytearray(data)
        if kind == "cut":
            return data[: rng.randrange(len(data))]
        if kind == "bits":
            for _ in range(rng.randint(1, 4)):
                found[rng.randrange(len(found))] ^= 1 << rng.randrange(8)
        elif kind == "noise":
            at = rng.randrange(len(found))
            found[at:at] = rng.randbytes(rng.randint(1, 40))
        elif kind == "doubled":
            found += data
        elif kind == "comma":
            found = bytearray(data.replace(b".", b","))
        else:
            found = bytearray(data.replace(b"X", b"Y", 1).replace(b'"x"', b'"y"', 1))
        return bytes(found) if len(found) >= len(data) else bytes(found) + b" " * (len(data) - len(found))

    return damage
