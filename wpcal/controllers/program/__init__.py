"""Programs before they are written in a language: targets, moves, arcs, searches, and what couples two robots."""

from wpcal.controllers.program.weld_program import (
    ControllerSettings,
    MotionSettings,
    SafePoint,
    WeldPath,
    WeldProgram,
    build_program,
)

__all__ = ["ControllerSettings", "MotionSettings", "SafePoint", "WeldPath", "WeldProgram", "build_program"]
