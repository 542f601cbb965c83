"""What leaves wpcal for a controller, and taught points that come from one."""

from wpcal.controllers.program import ControllerSettings, MotionSettings, WeldPath, WeldProgram, build_program
from wpcal.controllers.registry import Exporter, exporter_named, exporter_names
from wpcal.controllers.torch import ToolAxis, TorchSettings, measure_torch, tool_rotations, wire_directions
from wpcal.taught.user_frames import ProgramReading, read_taught_program

__all__ = [
    "ControllerSettings",
    "Exporter",
    "MotionSettings",
    "ProgramReading",
    "ToolAxis",
    "TorchSettings",
    "WeldPath",
    "WeldProgram",
    "build_program",
    "exporter_named",
    "exporter_names",
    "measure_torch",
    "read_taught_program",
    "tool_rotations",
    "wire_directions",
]
