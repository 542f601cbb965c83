"""`wpcal touches`: which searches of the torch locate the part."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING

import click

from cad.cli.options import BODIES, CHOICE, FINDING, MESH, PART, no_cache_option
from wpcal.cli.option_groups import command, takes
from wpcal.cli.outputs import print_json
from wpcal.cli.shared_help import FORCE_HELP, JSON_HELP, ONLY_HELP, TOOL_HELP, TOOL_METAVAR, path_argument, path_option
from wpcal.core.options import opt

NO_RESULTS = "-"  #: In place of the results of a first stage: both stages shall be one program.

if TYPE_CHECKING:
    from rich.table import Table

    from cad.batch.bodies_asked import BodiesAsked
    from cad.batch.seams_asked import SeamsAsked
    from cad.workpiece.touches import DrawnTouches
    from wpcal.core.transform import RigidTransform
    from wpcal.planning.cell.cell import Cell
    from wpcal.robot.torch.shape import TorchShape
    from wpcal.seam import SeamOptions
    from wpcal.touch.plan import TouchOptions
    from wpcal.touch.searches import SeamPrediction, Search, TouchPlan


@dataclass(frozen=True, slots=True, kw_only=True)
class ArmAsked:
    """The arm that makes the searches, and what is around it."""

    cell: Path | None = opt(
        None,
        "The cell: of one robot (`wpcal cell new`); its arm makes the searches and keeps away from its bodies. Its "
        "tool is the tip of the wire; programs move a point --standoff-mm behind it.",
        metavar="CELL.json",
    )
    arm: str | None = opt(
        None,
        "Arm without a cell: the name of a shipped arm, an arm file or a URDF file; with --tool and --nominal.",
        metavar="ARM",
    )
    tool: str | None = opt(None, TOOL_HELP, metavar=TOOL_METAVAR)

    def to_cell(self, torch: TorchShape, *, is_placed: bool, standoff_mm: float) -> Cell | None:
        """Read the cell, or make that of an arm alone: the tool of a cell is the tip of the wire."""
        from wpcal.core.errors import InputError

        if self.cell is not None:
            from wpcal.planning.cell.cell_file import read_one_robot

            if self.arm is not None or self.tool is not None:
                raise InputError("--cell has an arm and its tool: leave --arm and --tool away")
            cell = read_one_robot(self.cell)
            return cell if is_placed or cell.T_part else None
        if self.arm is None:
            if self.tool is not None:
                raise InputError("--tool needs --arm")
            return None
        if self.tool is None or not is_placed:
            raise InputError(
                "--arm needs --tool (the tool centre point) and --nominal (the part in the base of the arm)"
            )
        from wpcal.planning.cell.new_cell import bare_cell
        from wpcal.robot.identify.poses_file import parse_tool

        tool = parse_tool(self.tool)[0]
        return bare_cell(self.arm, replace(tool, t_mm=tool.t_mm + standoff_mm * tool.R[:, 2]), torch)


@command()
@path_argument("part_step", metavar="PART.step")
@takes("options", "wpcal.touch.plan:TouchOptions")
@click.option(
    "--nominal",
    metavar="POSE",
    help="Place of the part in the cell's model: x,y,z,a,b,c in mm and degrees with R = Rz(c) Ry(b) Rx(a), or a JSON "
    "file with a 4×4 matrix; here in the base of the robot.  [default: that of --cell, else the base itself]",
)
@path_option(
    "--after",
    nargs=2,
    metavar="PLAN RESULTS",
    help="The second of two stages: the plan of the first, and what its program stored. The part stands there. `-` for "
    "the results: both stages shall be one program (wpcal export --touches FIRST --touches SECOND).",
)
@takes("moving", ArmAsked)
@takes("weldment", BODIES, without=["bending_mm"])
@click.option("--only", metavar="W1,W5-W8", help=f"{ONLY_HELP} The error counts there.  [default: all accepted seams]")
@takes("finding", FINDING)
@takes("choice", CHOICE)
@path_option("-o", "--out", "output", metavar="DIR", required=True, help="Output: a folder.")
@click.option("--force", is_flag=True, help=f"{FORCE_HELP}: touches.json, touches.csv, touches.html.")
@no_cache_option
@click.option("--json", "as_json", is_flag=True, help=f"{JSON_HELP}: the plan.")
def touches(
    *,
    part_step: Path,
    options: TouchOptions,
    nominal: str | None,
    after: tuple[Path, Path] | None,
    moving: ArmAsked,
    weldment: BodiesAsked,
    only: str | None,
    finding: SeamOptions,
    choice: SeamsAsked,
    output: Path,
    force: bool,
    as_json: bool,
    no_cache: bool,
) -> int:
    """Plan the touches of the wire that locate PART.step, so that the largest predicted error of the seams is smallest.

    Each touch is a search: the robot moves the wire straight towards a face until contact. The plan has start, end and
    direction of each search, the way of the torch between them, and the predicted 95 % error of each seam. `wpcal
    export` writes the program of a controller from it, and `wpcal calibrate --touches` fits what the robot found.

    With --bodies the touches are chosen for plates that moved (`wpcal calibrate --touches --bodies`): strokes and ways
    allow for the motion of each body, and the plan says which body each touch lies on and which seam it serves.

    If faces are too small for the displacement of the part, touches are made in two stages: this plan then finds the
    large faces, and with what its program stored, `--after` plans the touches that locate the part.
    """
    from cad.batch.request import read_pose
    from cad.cli.kernel_work import run_on_part
    from cad.workpiece.touches import TouchesWanted
    from wpcal.core.errors import InputError
    from wpcal.core.records import check_writable, new_directory, to_json
    from wpcal.pages.touches import build_touches_page
    from wpcal.seam.names import split_names
    from wpcal.touch.searches import touches_csv, touches_record
    from wpcal.touch.searches.record import TOUCHES_FILE

    options = replace(options, torch=finding.reach.torch)
    check_writable(output, overwrite=force)
    place = None if nominal is None else read_pose(nominal)
    if after is not None:
        if place is not None:
            raise InputError("--after says where the part stands: leave --nominal away")
        place, options = _after_first(*after, options)
    T_base_part = None if place is None else place.relabelled(target="base", source="part")
    cell = moving.to_cell(options.torch, is_placed=place is not None, standoff_mm=options.standoff_mm)
    names, bodies = split_names(only or ""), weldment.to_options()
    asked = TouchesWanted(options, finding, choice.to_choice(), names, T_base_part, cell, bodies)
    drawn: DrawnTouches = run_on_part(
        "cad.workpiece.touches:draw_touches",
        part_step,
        {"asked": asked},
        what=f"planning the touches of {part_step}",
        use_cache=not no_cache,
        needs=(PART, MESH),
    )
    plan = drawn.plan
    record = touches_record(plan)
    page = build_touches_page(
        plan, part_glb=drawn.part_glb, seams=drawn.seams, border_mm=drawn.border_mm, setup=options.setup
    )
    with new_directory(output, overwrite=force, head=TOUCHES_FILE) as folder:
        (folder / TOUCHES_FILE).write_text(to_json(record), encoding="utf-8")
        (folder / "touches.csv").write_text(touches_csv(plan), encoding="utf-8")
        (folder / "touches.html").write_text(page, encoding="utf-8")
    if as_json:
        print_json(record)
    else:
        _show(plan, output)
    return 1 if plan.predicted is not None and plan.predicted.why_not else 0


def _after_first(file: Path, results: Path, options: TouchOptions) -> tuple[RigidTransform, TouchOptions]:
    """Return where a first stage found the part, and options with its tool and what it left unknown."""
    from wpcal.cli.outputs import require_as_planned
    from wpcal.controllers.touch_run import read_touch_results
    from wpcal.touch.plan.stages import found_place
    from wpcal.touch.searches import read_touch_plan
    from wpcal.touch.touch_results import pair_results

    plan = read_touch_plan(file)
    require_as_planned({"standoff_mm": plan.standoff_mm})
    taught = None
    if str(results) != NO_RESULTS:
        taught = pair_results(plan, read_touch_results(results, plan, options.setup), options.setup).taught
    T, left = found_place(plan, taught)
    return T, replace(options, nominal=replace(options.nominal, left=left), standoff_mm=plan.standoff_mm)


def _show(plan: TouchPlan, output: Path) -> None:
    from wpcal.cli.console import plain_console

    console = plain_console()
    console.print(_searches_table(plan))
    if plan.predicted is not None:
        for line in _predicted_lines(plan, plan.predicted):
            console.print(line)
    for note in plan.notes:
        console.print(f"note: {note}")
    console.print(f"wrote {output}: touches.json, touches.csv, touches.html")
    if plan.first_stage is not None:
        then = f"wpcal touches {plan.part} --after {output} RESULTS -o second"
        console.print(f"next: wpcal export {output} -f FORMAT, run the program, then {then}")
        console.print(f"or `{NO_RESULTS}` for RESULTS, and wpcal export RESULT --touches {output} --touches second")


def _predicted_lines(plan: TouchPlan, predicted: SeamPrediction) -> list[str]:
    unseen = f", of which {predicted.unseen_mm:.2f} mm from motions that no touch sees" if plan.bodies else ""
    lines = [
        f"largest predicted 95 % error of the seams: {predicted.error_95_mm:.2f} mm at {predicted.seam}{unseen}",
        f"all seams together: within {predicted.joint_95_mm:.2f} mm with 95 % confidence",
    ]
    return [*lines, predicted.why_not] if predicted.why_not else lines


def _searches_table(plan: TouchPlan) -> Table:
    from wpcal.cli.console import new_table

    served = "|<body|<for seam|<95 % mm after" if plan.bodies else ""
    headings = f"<=search|<touches|<=with|<=at mm|<=direction|<=stroke mm{served}"
    table = new_table(f"Touches of {plan.part}, in their order (part frame)", headings)
    for search in plan.searches:
        at = " ".join(f"{round(v, 1) + 0.0:g}" for v in search.contact_part.tolist())
        way = " ".join(f"{round(v, 2) + 0.0:g}" for v in search.direction.tolist())
        what = f"{search.target} {search.feature}".strip() if search.kind.value == "part" else "post"
        cells = [search.name, what, f"{search.contact.value} of the wire", at, way, f"{search.stroke_mm:.1f}"]
        table.add_row(*cells, *(_served(search) if plan.bodies else ()))
    return table


def _served(search: Search) -> tuple[str, str, str]:
    served = search.serves
    if served is None:
        return search.body, "", ""
    before, after = ("not held" if mm is None else f"{mm:.2f}" for mm in (served.before_mm, served.after_mm))
    return search.body, served.seam, after if before == after else f"{before} → {after}"
