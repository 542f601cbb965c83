"""One way to run the exported touch program of any controller, and to take the files that a person copies from it."""

from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, cast

import numpy as np
from scipy.spatial.transform import Rotation

from tests.touch_robots import saved
from tests.touch_robots.robot import Array, Robot, Senses, Torch, Welder
from tests.touch_robots.solid import Solid
from wpcal.controllers.language.touch import ENDED_TEXT
from wpcal.controllers.registry import controller_named
from wpcal.controllers.run.machine import Run, rigid

T_FLANGE_TOOL = rigid(Rotation.from_euler("xyz", [10.0, 35.0, 20.0], degrees=True).as_matrix(), [30.0, -5.0, 410.0])
"""Where the torch is on the flange: no axis of the tool is along one of the flange."""
CONFIG = ("--config", "fanuc=N U T, 0, 0, 0", "--config", "inform=1,0,0,0,0,0,0,0")
"""What the exports of these two need; no arm is simulated."""


@dataclass(frozen=True)
class Brand:
    """How a person starts the program of a controller.

    `tool`: what the tool is called there, `main`: the routine that is started, `results`: what is given to wpcal of the
    files that are copied (a folder if empty), `stored_mm`: half of the last stored digit of a place below 1 m.
    """

    controller: Callable[..., Any]
    tool: Any
    main: str
    results: str
    stored_mm: float
    given: dict[str, Any] = field(default_factory=dict)
    saved: Callable[[Any], dict[str, str]] = lambda _: {}
    welds: str = ""  #: The routine that searches and welds.


def running(name: str) -> Callable[..., Any]:
    """Return what executes the programs of a controller."""
    return cast("Callable[..., Any]", controller_named(name).load_interpreter())


BRANDS = {
    "rapid": Brand(
        running("rapid"),
        "tTorch",
        "run_WPCAL_touch",
        "WPCAL_touch_res.mod",
        5e-4,
        {"signals": {"diTouch": True}},
        welds="run_WPCAL_touch_weld",
    ),
    "krl": Brand(
        running("krl"), 1, "WPCAL_touch", "WPCAL_touch.dat", 1e-5, {"signals": {1: True}}, welds="WPCAL_touch"
    ),
    "fanuc": Brand(running("fanuc"), 1, "WPCAL_TOUCH", "", 5e-4, {"signals": {"DI[1]": True}}, saved.fanuc),
    "inform": Brand(running("inform"), 1, "WPCAL_TOUCH", "VAR.DAT", 5e-4, {"signals": {"RIN#(1)": True}}, saved.inform),
    "urscript": Brand(running("urscript"), 1, "", "log.txt", 5e-4, {"signals": {"0": True}}, saved.urscript),
    "as": Brand(running("as"), "tTorch", "WPCAL_touch", "saved.as", 1e-6, {"signals": {"1001": True}}, saved.kawasaki),
}


@dataclass
class Ran:
    """A run, the robot that made it, and what was copied from the controller."""

    run: Run
    robot: Robot
    results: Path


def displacement(mm: tuple[float, float, float], degrees: tuple[float, float, float] = (0.0, 0.0, 0.0)) -> Array:
    return rigid(Rotation.from_euler("xyz", degrees, degrees=True).as_matrix(), mm)


def run_program(
    brand: str,
    folder: Path,
    solid: Solid,
    out: Path,
    *,
    senses: Senses | None = None,
    torch: Torch | None = None,
    goes_on: bool = True,
    kind: type[Robot] = Robot,
) -> Ran:
    """Load all files of `folder`, run the program, and copy the results to `out`.

    `goes_on`: whether the operator starts the program again after a stop; `kind`: a `Welder` searches and welds.
    """
    how = BRANDS[brand]
    files = {path.name: path.read_bytes().decode() for path in sorted(folder.iterdir()) if path.suffix != ".json"}
    torch = torch or Torch(T_FLANGE_TOOL)
    robot = kind(solid, torch, senses)
    tools = {how.tool: T_FLANGE_TOOL}
    on_stop = lambda message: goes_on and ENDED_TEXT not in message  # noqa: E731
    controller = how.controller(files, robot, tools=tools, on_stop=on_stop, **how.given)
    run = controller.start(how.welds if kind is Welder else how.main)
    kept = dict(run.files) | how.saved(controller)
    if hasattr(controller, "backup"):
        kept.update(controller.backup())
    out.mkdir(parents=True, exist_ok=True)
    for name, text in kept.items():
        (out / name).write_text(text, encoding="utf-8")
    return Ran(run, robot, out / how.results if how.results else out)


def planned_frame(plan: Any) -> Array:
    """Return where a plan says that the part stands."""
    return np.asarray(plan.T_base_part.matrix)
