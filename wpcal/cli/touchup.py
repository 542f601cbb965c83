"""`wpcal touchup`: points that were corrected on the pendant, read back and used for the whole part."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from wpcal.cli.option_groups import command, takes
from wpcal.cli.outputs import print_json
from wpcal.cli.shared_help import FORCE_HELP, JSON_HELP, path_argument, path_option
from wpcal.cli.torch_options import TorchOfProgramAsked

if TYPE_CHECKING:
    from wpcal.controllers.touchup.study import TouchUp, TouchUpOptions


@command()
@path_argument("program", metavar="CHANGED")
@path_option("--of", "result", metavar="DIR", required=True, help="Result: a folder.")
@path_option(
    "--written", metavar="PROGRAM", help="The program as wpcal wrote it: a folder or a file.  [default: DIR/FORMAT]"
)
@path_option("-o", "--out", help="Output: a folder.  [default: nothing is written]")
@path_option("--html", metavar="FILE", help="Write a page: what was corrected, seam by seam.")
@path_option(
    "--earlier",
    metavar="FOLDER",
    help="Touch-ups of earlier parts of this kind, in folders below: what is corrected alike on all is proposed.",
)
@takes("options", "wpcal.controllers.touchup.study:TouchUpOptions")
@takes("torch", TorchOfProgramAsked)
@click.option("--force", is_flag=True, help=f"{FORCE_HELP}: the files of this command in the folder.")
@click.option("--json", "as_json", is_flag=True, help=f"{JSON_HELP}: what was corrected, and what follows.")
@click.pass_context
def touchup(
    ctx: click.Context,
    *,
    program: Path,
    result: Path,
    written: Path | None,
    out: Path | None,
    html: Path | None,
    earlier: Path | None,
    options: TouchUpOptions,
    torch: TorchOfProgramAsked,
    force: bool,
    as_json: bool,
) -> int:
    """Read CHANGED, a program of wpcal as it came back from the robot with points corrected on the pendant.

    A corrected weld point says where its seam is. The error of every seam is computed anew, and with --out the program
    is written again: what was corrected by hand stays to the digit, the other points of seams go where the corrections
    have them. What is written is executed, and its torch is swept against the part where the corrections have it.

    Ends with code 1 if a correction contradicts the others, a seam is less sure than the calibration promised, or the
    program that is written is not free of the part.
    """
    from wpcal.cli.outputs import require_new, typed_options
    from wpcal.controllers.touchup.poses import read_program
    from wpcal.controllers.touchup.record import earlier_touch_ups, proposals, touch_up_record
    from wpcal.controllers.touchup.rewrite import moved_text, without_claim
    from wpcal.controllers.touchup.study import TouchUp
    from wpcal.controllers.touchup.swept import NOT_SEEN, faults_of
    from wpcal.core.records import check_writable, new_directory, to_json, write_file
    from wpcal.results.folder import read_finished

    if out is not None:
        check_writable(out, overwrite=force)
    if html is not None:
        require_new(html, overwrite=force)
    finished = read_finished(result)
    before = read_program(written or _written_of(program, result))
    found = TouchUp(finished, before, read_program(program, like=before), options)
    record = touch_up_record(found)
    record["proposals"] = [] if earlier is None else proposals([*earlier_touch_ups(earlier), record])
    texts = dict[str, bytes]()
    if out is not None:
        texts = moved_text(found.changed, found.shifts)
        around = torch.to_surroundings(finished.torch)
        record["not_free"] = faults_of(found, texts, around)
        texts = without_claim(texts) if record["not_free"] else texts
    if as_json:
        print_json(record)
    else:
        _show(found)
        for sentence in (*record["sentences"], *record["proposals"], *record["not_free"]):
            click.echo(sentence)
    if html is not None:
        from wpcal.pages.touchup import build_touch_up_page

        words = [str(program), *typed_options(ctx, without={"out", "html", "force", "as_json", "set_aside"})]
        seams = {seam.name: seam.frames.p for seam in found.part.seams}
        page = build_touch_up_page(record, seams, f"Touch-up of {program.name}", ["wpcal", "touchup", *words])
        write_file(html, page, overwrite=force)
        click.echo(f"wrote {html}", err=as_json)
    if out is not None:
        with new_directory(out, overwrite=force, head="touchup.json") as folder:
            for name, data in texts.items():
                (folder / name).write_bytes(data)
            (folder / "touchup.json").write_text(to_json(record), encoding="utf-8")
        said = (
            "NOT CHECKED: RUN IT DRY FIRST"
            if record["not_free"]
            else f"executed: out of the part as corrected, with {around.torch}; {NOT_SEEN}. RUN IT DRY FIRST"
        )
        click.echo(f"wrote {', '.join([*texts, 'touchup.json'])} to {out}; {said}", err=as_json)
    is_unsure = any("less sure" in each.says for each in found.seams)
    return 1 if found.exceptions or is_unsure or record["not_free"] else 0


def _written_of(program: Path, result: Path) -> Path:
    """Return where `wpcal export` puts programs of this language."""
    from wpcal.controllers.registry import controller_of_program
    from wpcal.core.errors import InputError

    if not program.exists():
        raise InputError(f"{program}: no such file or folder; expected the program as it came back from the robot")
    files = sorted(program.iterdir()) if program.is_dir() else [program]
    for path in files:
        controller = controller_of_program(path)
        if controller is not None and (result / controller.name).is_dir():
            return result / controller.name
    raise InputError(f"{result}: no program as written is in it for {program}; give it as --written")


def _show(found: TouchUp) -> None:

    from wpcal.cli.console import new_table, plain_console

    if not found.seams:
        click.echo("all corrections are set aside" if found.points else "no point of a seam was corrected")
        return
    table = new_table(
        f"{len(found.points)} corrected points", "<seam|corrected|was off mm|95 % before mm|95 % now mm|<"
    )
    for each in found.seams:
        before = "" if each.before_95_mm is None else f"{each.before_95_mm:.2f}"
        table.add_row(
            each.name, str(each.corrected or ""), f"{each.was_off_mm:.2f}", before, f"{each.after_95_mm:.2f}", each.says
        )
    plain_console().print(table)
