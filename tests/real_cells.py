"""A cell rebuilt without wpcal: meshes and joints from URDF files, places from the cell's JSON, collisions by FCL.

The planner's own bodies are convex hulls and capsules; here the triangles of the meshes themselves are compared.
"""

import json
import xml.etree.ElementTree as ET
from pathlib import Path
from typing import Any

import fcl
import numpy as np
import trimesh
from scipy.spatial.transform import Rotation

Array = np.ndarray[Any, Any]
FLOOR_MM = 50.0  #: Thickness of the floor, whose top is that of the cell.
TORCH = 7  #: The torch counts as the link after the flange.
APART = 4  #: Links of one robot that are this far apart in the chain must not meet: nearer ones touch by construction.


def matrix(xyz_mm: Any, rpy_rad: Any) -> Array:
    T = np.eye(4)
    T[:3, :3] = Rotation.from_euler("xyz", rpy_rad).as_matrix()
    T[:3, 3] = xyz_mm
    return T


def of_record(record: dict[str, Any]) -> Array:
    return matrix(record["xyz_mm"], np.radians(record["rpy_deg"]))


class Chain:
    """A robot as its URDF file says: where its links are, in mm in the controller's base frame."""

    def __init__(self, path: Path) -> None:
        root = ET.parse(path).getroot()
        self.joints = {joint.find("child").get("link"): joint for joint in root.findall("joint")}
        self.steps: dict[str, tuple[str, Array, Array | None, int]] = {}
        self.names = [link.get("name") for link in root.findall("link")]
        moving = [joint for joint in self._in_order() if joint.get("type") in ("revolute", "continuous")]
        self.number = {joint.get("name"): row for row, joint in enumerate(moving)}
        self.limits = [
            tuple(float(joint.find("limit").get(key, "nan")) for key in ("lower", "upper", "velocity"))
            for joint in moving
        ]
        tip = [name for name in ("tool0", "flange") if name in self.names]
        self.tip = tip[0] if tip else moving[-1].find("child").get("link")
        base = self._pose("base", np.zeros(len(moving))) if "base" in self.names else np.eye(4)
        self.from_base = np.linalg.inv(base)
        self.meshes = {}
        for link in root.findall("link"):
            mesh = link.find("collision/geometry/mesh")
            if mesh is not None:
                scale = [float(v) for v in mesh.get("scale", "1 1 1").split()]
                shape = trimesh.load(path.parent / mesh.get("filename"), force="mesh")
                origin = link.find("collision/origin")
                T = np.eye(4) if origin is None else self._origin(origin)
                points = np.asarray(shape.vertices) * scale * 1000.0
                self.meshes[link.get("name")] = points @ T[:3, :3].T + T[:3, 3], np.asarray(shape.faces)

    def _in_order(self) -> list[ET.Element]:
        def depth(joint: ET.Element) -> int:
            count, link = 0, joint.find("parent").get("link")
            while link in self.joints:
                count, link = count + 1, self.joints[link].find("parent").get("link")
            return count

        return sorted(self.joints.values(), key=depth)

    @staticmethod
    def _origin(origin: ET.Element) -> Array:
        xyz, rpy = ([float(v) for v in origin.get(key, "0 0 0").split()] for key in ("xyz", "rpy"))
        return matrix(1000.0 * np.array(xyz), rpy)

    def _step(self, link: str) -> tuple[str, Array, Array | None, int]:
        """Return what carries a link: the link before it, the fixed place in it, the axis and the number of a joint."""
        if link not in self.steps:
            joint = self.joints[link]
            place = np.eye(4) if joint.find("origin") is None else self._origin(joint.find("origin"))
            number, axis = self.number.get(joint.get("name"), -1), None
            if number >= 0:
                axis = np.array([float(v) for v in joint.find("axis").get("xyz").split()])
                axis /= np.linalg.norm(axis)
            self.steps[link] = joint.find("parent").get("link"), place, axis, number
        return self.steps[link]

    def _pose(self, link: str, q: Array) -> Array:
        T = np.eye(4)
        while link in self.joints:
            link, place, axis, number = self._step(link)
            if axis is not None:
                x, y, z = axis
                K = np.array([[0, -z, y, 0], [z, 0, -x, 0], [-y, x, 0, 0], [0, 0, 0, 0]])  # Rodrigues
                angle = np.asarray(q)[..., number, None, None]
                T = (np.eye(4) + np.sin(angle) * K + (1 - np.cos(angle)) * (K @ K)) @ T
            T = place @ T
        return T

    def pose(self, link: str, q: Array) -> Array:
        return self.from_base @ self._pose(link, q)

    def moved_by(self, link: str) -> int:
        """Return how many joints move a link."""
        count = 0
        while link in self.joints:
            count += self.joints[link].get("name") in self.number
            link = self.joints[link].find("parent").get("link")
        return count


def bvh(points: Array, faces: Array) -> fcl.CollisionObject:
    model = fcl.BVHModel()
    model.beginModel(len(points), len(faces))
    model.addSubModel(np.ascontiguousarray(points), np.ascontiguousarray(faces))
    model.endModel()
    return fcl.CollisionObject(model, fcl.Transform())


class RealCell:
    """A cell of one robot with real meshes.

    The part is given as triangles (m, 3, 3) in its own frame.
    """

    def __init__(
        self, cell_json: Path, urdfs: dict[str, Path], part: Array | None, T_carrier_part: Array | None = None
    ) -> None:
        record = json.loads(cell_json.read_text(encoding="utf-8"))
        robot = record["torch_robot"]
        self.robot = Chain(urdfs["robot"])
        self.T_robot, self.T_tool = of_record(robot["T_world_base"]), of_record(robot["T_flange_tool"])
        self.turn = Chain(urdfs["positioner"]) if "positioner" in urdfs else None
        place = record.get("T_world_part")
        if self.turn is not None:
            self.T_turn, place = of_record(record["positioner"]["T_world_base"]), record["positioner"]["T_flange_part"]
        self.T_carrier_part = of_record(place) if T_carrier_part is None else T_carrier_part
        # (name, group, number of joints that move it, object, local place)
        self.bodies: list[tuple[str, str, int, Any, Array]] = []
        for name, mesh in self.robot.meshes.items():
            self.bodies.append((name, "robot", self.robot.moved_by(name), bvh(*mesh), np.eye(4)))
        for shape in robot["torch"]:
            # the ball at the end of a capsule is beyond the mouth of a nozzle
            own = [self._hull(shape)] if "hull_mm" in shape else [self._capsule(one) for one in shape["capsules"]]
            self.bodies += [(shape["name"], "torch", TORCH, *one) for one in own]
        if self.turn is not None:
            for name, mesh in self.turn.meshes.items():
                row = self.turn.moved_by(name)
                self.bodies.append((f"positioner {name}", "turn", row, bvh(*mesh), np.eye(4)))
        for shape in record["bench"]:
            self.bodies.append((shape["name"], "bench", 0, *self._hull(shape)))
        floor = fcl.CollisionObject(fcl.Box(1e5, 1e5, FLOOR_MM), fcl.Transform())
        low = matrix([0, 0, record.get("floor_z_mm", 0.0) - FLOOR_MM / 2], [0, 0, 0])
        self.bodies.append(("floor", "floor", 0, floor, low))
        if part is not None:
            points = np.ascontiguousarray(part.reshape(-1, 3))
            self.bodies.append(("part", "part", 9, bvh(points, np.arange(len(points)).reshape(-1, 3)), np.eye(4)))
        self._pairs = self._managed()

    @staticmethod
    def _hull(shape: dict[str, Any]) -> tuple[Any, Array]:
        hull = trimesh.convex.convex_hull(np.array(shape["hull_mm"]))
        return bvh(hull.vertices, hull.faces), np.eye(4)

    @staticmethod
    def _capsule(capsule: dict[str, Any]) -> tuple[Any, Array]:
        p, q = np.array(capsule["p_mm"]), np.array(capsule["q_mm"])
        T = np.eye(4)
        if np.linalg.norm(q - p) > 0:
            T[:3, :3] = Rotation.align_vectors([q - p], [[0, 0, 1]])[0].as_matrix()
        T[:3, 3] = (p + q) / 2
        return fcl.CollisionObject(fcl.Capsule(capsule["radius_mm"], float(np.linalg.norm(q - p))), fcl.Transform()), T

    def _managed(self) -> list[tuple[list[int], list[int]]]:
        """Return the groups of bodies that must not meet: rows of the first, rows of the second."""

        def rows(group: str, least: int = 0, most: int = 9) -> list[int]:
            return [i for i, body in enumerate(self.bodies) if body[1] == group and least <= body[2] <= most]

        moving = rows("robot", 2) + rows("torch")
        turned = rows("turn", 1) + rows("part")
        groups = [
            (moving, rows("bench") + rows("floor") + rows("turn") + rows("part")),
            (rows("robot", 1, 1), rows("part") + rows("turn")),
            (rows("torch"), rows("robot", 0, TORCH - APART)),
            (rows("robot", 4), rows("robot", 0, 0)),
            (rows("robot", 5), rows("robot", 1, 1)),
        ]
        if self.turn is not None:
            groups += [
                (turned, rows("bench")),
                (rows("part"), rows("floor") + rows("turn", 0, 0) + rows("robot", 0, 0)),
            ]
        made = []
        for first, second in groups:
            managers = []
            for some in (first, second):
                manager = fcl.DynamicAABBTreeCollisionManager()
                manager.registerObjects([self.bodies[i][3] for i in some])
                manager.setup()
                managers.append(manager)
            made.append((managers[0], managers[1], first, second))
        return made

    def places(self, q: Array) -> dict[str, Array]:
        """Return where the tool and the part are in `world`."""
        tool = self.T_robot @ self.robot.pose(self.robot.tip, q[:6]) @ self.T_tool
        carrier = np.eye(4) if self.turn is None else self.T_turn @ self.turn.pose(self.turn.tip, q[6:])
        return {"tool": tool, "part": carrier @ self.T_carrier_part}

    def _place(self, q: Array) -> None:
        at = self.places(q)
        for name, group, _, shape, local in self.bodies:
            if group == "robot":
                T = self.T_robot @ self.robot.pose(name, q[:6])
            elif group == "turn":
                T = self.T_turn @ self.turn.pose(name.removeprefix("positioner "), q[6:])
            elif group in ("torch", "part"):
                T = at["tool" if group == "torch" else "part"] @ local
            else:
                T = local
            shape.setTransform(fcl.Transform(np.ascontiguousarray(T[:3, :3]), T[:3, 3]))

    def collision(self, q: Array) -> tuple[str, str] | None:
        """Return the names of two bodies that meet at a state (rad), or None."""
        self._place(q)
        for first, second, rows, others in self._pairs:
            first.update()
            second.update()
            data = fcl.CollisionData(request=fcl.CollisionRequest())
            first.collide(second, data, fcl.defaultCollisionCallback)
            if data.result.is_collision:
                for i in rows:
                    for j in others:
                        result = fcl.CollisionResult()
                        if fcl.collide(self.bodies[i][3], self.bodies[j][3], fcl.CollisionRequest(), result):
                            return self.bodies[i][0], self.bodies[j][0]
        return None
