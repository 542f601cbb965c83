"""OPC UA for Robotics (OPC 40010): the joints of a controller, and the position by wpcal's own model of the arm.

A server of this companion specification tells the angles of the axes, not the position of the tool. The arm is named in
the address (``arm=kr16.json``), and the tool by ``--tool``.
"""

from __future__ import annotations

import time
from pathlib import Path
from typing import Any

import numpy as np

from wpcal.core.transform import RigidTransform
from wpcal.robot.kinematics.arm import Arm
from wpcal.robot.kinematics.arm_file import find_arm
from wpcal.robot.links.reading import Address, Credentials, LinkError, Reading, Setting, numbers
from wpcal.robot.links.wire import ANSWER_S

PORT = 4840
AXES = "Axes"  #: Folder of a motion device; in each of its objects is ParameterSet/ActualPosition.
RADIANS = {17_476: np.pi / 180.0, 4_405_297: 1.0}
"""Radians per unit, by the numbers that OPC UA has for degree and radian (DD and C81 of UNECE Recommendation 20)."""
DEPTH = 6  #: From the folder of objects to a motion device: DeviceSet, system, MotionDevices, device, Axes.
OF_SERVER = ("Server", "Aliases", "Locations")  #: Folders of every server: not of a robot.
MOST_NODES = 500  #: Looked at for the axes.


class OpcUaLink:
    """The axes of one motion device."""

    def __init__(self, address: Address, arm: Arm) -> None:
        from asyncua.sync import Client
        from asyncua.ua.uaerrors import UaError

        self._arm, self._errors = arm, (UaError, OSError, TimeoutError, RuntimeError)
        self._client = Client(f"opc.tcp://{address.host}:{address.port or PORT}", timeout=ANSWER_S)
        try:
            self._client.connect()
            self._axes = self._find_axes()
            self._units = np.array([self._radians(axis) for axis in self._axes])
        except self._errors as error:
            self.close()
            raise LinkError(f"{address.host}: OPC UA: {error or type(error).__name__}") from None
        except LinkError:
            self.close()
            raise
        if len(self._axes) < len(arm.chain):
            self.close()
            raise LinkError(f"{address.host}: {len(self._axes)} axes with ActualPosition, expected {len(arm.chain)}")

    def read(self) -> Reading:
        """Return the position of the flange by the model of the arm."""
        asked = time.monotonic()
        try:
            values = self._client.read_values(self._axes)
        except self._errors as error:
            raise LinkError(f"OPC UA: {error or type(error).__name__}") from None
        shown = (self._units * numbers([str(value) for value in values]))[: len(self._arm.chain)]
        T = RigidTransform.from_matrix(self._arm.forward(shown[None])[0], target="base", source="tool")
        return Reading(T, Setting("0"), Setting("base"), shown, asked)

    def results(self, plan: Path) -> dict[str, bytes]:
        """Refuse: no files are read."""
        raise LinkError("no files are read over OPC UA")

    def close(self) -> None:
        """End the session."""
        try:
            self._client.disconnect()
        except self._errors:
            self._client.tloop.stop()

    def _find_axes(self) -> list[Any]:
        """Return the variables ActualPosition of the first motion device, in the order of their axes."""
        layer, seen = [self._client.nodes.objects], 0
        for _ in range(DEPTH):
            inner = []
            for node in layer:
                for child in node.get_children():
                    seen, name = seen + 1, child.read_browse_name().Name
                    if seen > MOST_NODES:
                        raise LinkError(f"no folder {AXES} among {MOST_NODES} nodes")
                    if name == AXES:
                        return self._positions(child)
                    inner += [child] if name not in OF_SERVER else []
            layer = inner
        return []

    def _radians(self, position: Any) -> float:
        """Return the radians per unit of a position."""
        for each in position.get_properties():
            if each.read_browse_name().Name == "EngineeringUnits":
                unit = RADIANS.get(each.read_value().UnitId)
                if unit is not None:
                    return unit
        raise LinkError("an axis without EngineeringUnits of degrees or radians")

    def _positions(self, axes: Any) -> list[Any]:
        named = {axis.read_browse_name().Name: axis for axis in axes.get_children()}
        found = []
        for name in sorted(named):
            inside = {each.read_browse_name().Name: each for each in named[name].get_children()}
            inside |= {
                each.read_browse_name().Name: each
                for folder in inside.values()
                for each in folder.get_children()
                if "ParameterSet" in inside
            }
            if "ActualPosition" in inside:
                found.append(inside["ActualPosition"])
        return found


def open_opcua(address: Address, credentials: Credentials) -> OpcUaLink:
    """Return the open link."""
    if address.arm is None:
        raise LinkError("OPC UA tells joints only: name the arm behind the address, as ,arm=kr16.json")
    try:
        import asyncua  # noqa: F401
    except ImportError:
        raise LinkError("OPC UA needs the package asyncua: pip install 'wpcal[opcua]'") from None
    return OpcUaLink(address, find_arm(address.arm))
