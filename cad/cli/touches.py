"""`wpcal touches`: which searches of the torch locate the part."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from cad.cli.bodies_options import ContactBodiesFlags
from cad.cli.options import MESH, PART, SeamChoiceFlags, SeamFlags, no_cache_option, read_pose
from wpcal.cli.option_groups import option, takes
from wpcal.cli.shared_help import FORCE_HELP, JSON_HELP, ONLY_HELP, TOOL_HELP, TOOL_METAVAR

if TYPE_CHECKING:
    from rich.table import Table

    from cad.workpiece.touches import DrawnTouches
    from wpcal.planning.cell.one_robot import OneRobotCell
    from wpcal.robot.torch.shape import TorchShape
    from wpcal.touch.plan import TouchOptions
    from wpcal.touch.searches import SeamPrediction, Search, TouchPlan

PATTERNS = ("best", "3-2-1", "three-point")
"""`wpcal.touch.plan.Pattern`; written out so that the help needs no NumPy."""


@dataclass(frozen=True, slots=True, kw_only=True)
class TouchFlags:
    """How many touches, and what is known before them."""

    touches: int | None = option(
        "--touches",
        "--count",
        type=int,
        help=(
            "Number of touches: searches, without that on a post.  [default: 8; 6 with a pattern; with --bodies 2 more "
            "per further body]"
        ),
    )
    tolerance_mm: float | None = option(
        "--tolerance-mm",
        type=float,
        help="Allowed error: as many searches, at most 60, as keep all seams within it, with 95 % confidence.",
    )
    pattern: str = option(
        "--pattern",
        type=click.Choice(PATTERNS),
        default="best",
        show_default=True,
        help="Pattern of the touches: any, three on one side with two and one on two others, or two sides at each of "
        "three places.",
    )
    uncertainty_mm: float = option(
        "--uncertainty-mm",
        type=float,
        default=1.0,
        show_default=True,
        help="Standard deviation per axis of where the part stands: strokes are as long as 99 % of the parts need.",
    )
    uncertainty_deg: float = option(
        "--uncertainty-deg",
        type=float,
        default=0.3,
        show_default=True,
        help="Standard deviation per axis of how the part is turned.",
    )
    wire_diameter_mm: float = option(
        "--wire-diameter-mm", type=float, default=1.2, show_default=True, help="Diameter of the wire."
    )
    post: str | None = option(
        "--post",
        metavar="X,Y,Z",
        help="Top of a post at a known place in the base, mm: it is touched first and solves the stick-out.",
    )
    setup: Path | None = option(
        "--setup",
        metavar="FILE",
        type=click.Path(path_type=Path),
        help="For a plan of touches: repeatability, stick-out, latency and speed of the cell (TOML).  [default: usual "
        "values]",
    )
    nominal: str | None = option(
        "--nominal",
        metavar="POSE",
        help="Place of the part in the cell's model: x,y,z,a,b,c in mm and degrees with R = Rz(c) Ry(b) Rx(a), or a "
        "JSON file with a 4×4 matrix; here in the base of the robot.  [default: that of --cell, else the base itself]",
    )

    def to_options(self, torch: TorchShape) -> TouchOptions:
        """Check the numbers and return them as the plan takes them."""
        import math

        from wpcal.touch.plan import NominalError, Pattern, TouchOptions
        from wpcal.touch.searches import TouchSetup
        from wpcal.touch.searches.setup import read_touch_setup

        return TouchOptions(
            touches=self.touches,
            tolerance_mm=self.tolerance_mm,
            pattern=Pattern(self.pattern),
            wire_mm=self.wire_diameter_mm,
            torch=torch,
            nominal=NominalError(self.uncertainty_mm, math.radians(self.uncertainty_deg)),
            setup=TouchSetup() if self.setup is None else read_touch_setup(self.setup),
            post_base=None if self.post is None else _point(self.post),
        )


def _point(text: str) -> tuple[float, float, float]:
    from wpcal.core.errors import InputError
    from wpcal.core.numbers import parse_numbers

    try:
        x, y, z = parse_numbers(text)
    except ValueError:
        raise InputError(f"--post: expected X,Y,Z in mm, got {text!r}") from None
    return x, y, z


@dataclass(frozen=True, slots=True, kw_only=True)
class ArmFlags:
    """The arm that makes the searches, and what is around it."""

    cell: Path | None = option(
        "--cell",
        metavar="CELL.json",
        type=click.Path(path_type=Path),
        help="The cell: of one robot (`wpcal cell new`); its arm makes the searches and keeps away from its bodies.",
    )
    arm: str | None = option(
        "--arm",
        metavar="ARM",
        help="Arm without a cell: the name of a shipped arm, an arm file or a URDF file; with --tool and --nominal.",
    )
    tool: str | None = option("--tool", metavar=TOOL_METAVAR, help=TOOL_HELP)

    def to_cell(self, torch: TorchShape, *, is_placed: bool) -> OneRobotCell | None:
        """Read the cell, or make that of an arm alone."""
        from wpcal.core.errors import InputError

        if self.cell is not None:
            from wpcal.planning.cell.one_robot_file import read_one_robot

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

        return bare_cell(self.arm, parse_tool(self.tool)[0], torch)


@click.command()
@click.argument("part_step", metavar="PART.step", type=click.Path(path_type=Path))
@takes("touching", TouchFlags)
@takes("moving", ArmFlags)
@takes("weldment", ContactBodiesFlags)
@click.option("--only", metavar="W1,W5-W8", help=f"{ONLY_HELP} The error counts there.  [default: all accepted seams]")
@takes("seams", SeamFlags)
@takes("choice", SeamChoiceFlags)
@click.option(
    "-o", "--out", "output", metavar="DIR", type=click.Path(path_type=Path), required=True, help="Output: a folder."
)
@click.option("--force", is_flag=True, help=f"{FORCE_HELP}: touches.json, touches.csv, touches.html.")
@no_cache_option
@click.option("--json", "as_json", is_flag=True, help=f"{JSON_HELP}: the plan.")
def touches(
    *,
    part_step: Path,
    touching: TouchFlags,
    moving: ArmFlags,
    weldment: ContactBodiesFlags,
    only: str | None,
    seams: SeamFlags,
    choice: SeamChoiceFlags,
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
    """
    from cad.cli.kernel_work import run_on_part
    from wpcal.core.records import check_writable, new_directory, to_json
    from wpcal.pages.touches import build_touches_page
    from wpcal.seam.names import split_names
    from wpcal.touch.searches import touches_csv, touches_record
    from wpcal.touch.searches.record import TOUCHES_FILE

    seam_options = seams.to_options()
    options = touching.to_options(seam_options.reach.torch)
    check_writable(output, overwrite=force)
    place = None if touching.nominal is None else read_pose(touching.nominal)
    arguments: dict[str, Any] = {
        "options": options,
        "seam_options": seam_options,
        "choice": choice.to_choice(),
        "seams": split_names(only or ""),
        "T_base_part": None if place is None else place.relabelled(target="base", source="part"),
        "cell": moving.to_cell(options.torch, is_placed=place is not None),
        "bodies": weldment.to_options(),
    }
    drawn: DrawnTouches = run_on_part(
        "cad.workpiece.touches:draw_touches",
        part_step,
        arguments,
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
        click.echo(to_json(record), nl=False)
    else:
        _show(plan, output)
    return 1 if plan.predicted is not None and plan.predicted.why_not else 0


def _show(plan: TouchPlan, output: Path) -> None:
    from wpcal.cli.console import plain_console

    console = plain_console()
    console.print(_searches_table(plan))
    if plan.predicted is not None:
        for line in _predicted_lines(plan, plan.predicted):
            console.print(line, highlight=False)
    for note in plan.notes:
        console.print(f"note: {note}", highlight=False)
    console.print(f"wrote {output}: touches.json, touches.csv, touches.html", highlight=False)


def _predicted_lines(plan: TouchPlan, predicted: SeamPrediction) -> list[str]:
    unseen = f", of which {predicted.unseen_mm:.2f} mm from motions that no touch sees" if plan.bodies else ""
    lines = [
        f"largest predicted 95 % error of the seams: {predicted.error_95_mm:.2f} mm at {predicted.seam}{unseen}",
        f"all seams together: within {predicted.joint_95_mm:.2f} mm with 95 % confidence",
    ]
    return [*lines, predicted.why_not] if predicted.why_not else lines


def _searches_table(plan: TouchPlan) -> Table:
    from rich.table import Table

    table = Table(title=f"Touches of {plan.part}, in their order (part frame)")
    served = ("body", "for seam", "95 % mm after") if plan.bodies else ()
    for heading in ("search", "touches", "with", "at mm", "direction", "stroke mm", *served):
        table.add_column(heading, no_wrap=heading not in ("touches", *served))
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
