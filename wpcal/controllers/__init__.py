"""Robot controllers: programs written for them, and taught points read from theirs; one folder per brand."""

from wpcal.controllers.program import ControllerSettings, MotionSettings, WeldPath, WeldProgram, build_program
from wpcal.controllers.registry import Controller, controller_named, controller_names, controllers
from wpcal.controllers.taught_program import read_taught_program
from wpcal.robot.torch.attitude import ToolAxis, TorchSettings, measure_torch, tool_rotations, wire_directions

__all__ = [
    "Controller",
    "ControllerSettings",
    "MotionSettings",
    "ToolAxis",
    "TorchSettings",
    "WeldPath",
    "WeldProgram",
    "build_program",
    "controller_named",
    "controller_names",
    "controllers",
    "measure_torch",
    "read_taught_program",
    "tool_rotations",
    "wire_directions",
]
