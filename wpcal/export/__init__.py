"""What leaves wpcal for a controller, and taught points that come from one."""

from wpcal.export.finished import FinishedCalibration, read_finished
from wpcal.export.program import ControllerSettings, MotionSettings, WeldPath, WeldProgram, build_program
from wpcal.export.registry import Exporter, exporter_named, exporter_names
from wpcal.export.taught_program import ProgramReading, read_taught_program
from wpcal.export.torch import ToolAxis, TorchSettings, measure_torch, tool_rotations, wire_directions

__all__ = [
    "ControllerSettings",
    "Exporter",
    "FinishedCalibration",
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
    "read_finished",
    "read_taught_program",
    "tool_rotations",
    "wire_directions",
]
