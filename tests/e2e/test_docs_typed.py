"""README, tour and the page of the first part, typed as they are into a new folder.

A block of shell commands is marked ``sh``; every line of it is run. The first line of the README that is run, `wpcal
pick` and the commands of others run in a shell, each in a process of its own; the other lines are given to the command
line of wpcal in this process, which loads the kernel once. Three things are not literal:

* ``<!-- save as NAME -->`` before a block: a person writes the block into that file.
* ``<!-- not run: why -->`` before a block: the block is not run.
* ``wpcal pick`` gets ``--no-browser``, and Ctrl-C when the page can be opened.

`brought` is what a reader has and wpcal cannot know: a part, a program from the controller, pairs of points, measured
poses.
"""

import os
import re
import shlex
import shutil
import signal
import subprocess
import sys
from pathlib import Path

import pytest

from tests.e2e.every_command import pose_rows
from tests.few import few
from tests.running import FINISHED, TIMEOUT_S, run_here
from wpcal.cli.main import EXIT_INTERRUPTED

ROOT = Path(__file__).parents[2]
MOVED = "docs/how-to/parts-that-moved.md"
PAGES = ("docs/how-to/first-part.md", "README.md", "docs/tour.md", MOVED)
BLOCK = re.compile(
    r"(?:<!-- (?P<mark>[^\n]*) -->\n)?```(?P<language>\w*)\n(?P<text>.*?)^```$", re.MULTILINE | re.DOTALL
)
SIGNS = set("|<>;&$*`")  #: A line with one needs a shell.
FEWEST_COMMANDS = {"README.md": 13, "docs/tour.md": 8, "docs/how-to/first-part.md": 6, MOVED: 5}
"""What the pages hold today: a block that is no longer recognised would otherwise pass unseen."""


def brought(folder: Path) -> None:
    """Write the files that a reader brings."""
    shutil.copy(ROOT / "fixtures" / "tee" / "tee.step", folder / "part.step")
    shutil.copy(ROOT / "fixtures" / "yin2003" / "table1.csv", folder / "pairs.csv")
    (folder / "poses.csv").write_text(pose_rows())
    lines = ["MODULE TOUCHED"]
    rows = [row.split(",") for row in (ROOT / "fixtures" / "tee" / "taught.csv").read_text().splitlines()[1:]]
    for name, x, y, z, *_ in rows:
        place = f"[[{x},{y},{z}],[1,0,0,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]]"
        lines.append(f"  CONST robtarget {name}:={place};")
    moves = (f"    MoveL {row[0]},v100,fine,tTorch\\WObj:=wobj0;" for row in rows)
    (folder / "TOUCHED.mod").write_text("\n".join([*lines, "  PROC main()", *moves, "  ENDPROC", "ENDMODULE", ""]))


def brought_to(page: str, folder: Path) -> None:
    """Write the files that a reader of this page brings."""
    if page != MOVED:
        return brought(folder)
    for name in ("uprights.step", "taught.csv", "taught_six.csv", "bodies.json"):
        shutil.copy(ROOT / "fixtures" / "uprights" / name, folder / name)
    return None


def type_line(line: str, folder: Path) -> None:
    """Run one line in a shell; it must end with a result."""
    picks = line.startswith("wpcal pick")
    environment = {**os.environ, "PATH": f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}"}
    process = subprocess.Popen(
        ["bash", "-c", "exec " + line.replace("wpcal pick", "wpcal pick --no-browser")],
        cwd=folder,
        env=environment,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )
    if picks and process.stdout is not None and "is at http" in process.stdout.readline():
        process.send_signal(signal.SIGINT)
    _, errors = process.communicate(timeout=TIMEOUT_S)
    allowed = (0, EXIT_INTERRUPTED) if picks else FINISHED
    assert process.returncode in allowed, f"{line}\n{errors}"


def give_line(line: str) -> None:
    """Give one line to wpcal in this process, in the folder where it stands; it must end with a result."""
    ended = run_here(*shlex.split(line, comments=True)[1:])
    assert ended.returncode in FINISHED, f"{line}\n{ended.stderr}"


@pytest.mark.usefixtures("kernel_here")
@pytest.mark.parametrize("page", few(PAGES, 1))
def test_every_command_works_in_a_new_folder(page: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    brought_to(page, tmp_path)
    typed = 0
    for block in BLOCK.finditer((ROOT / page).read_text(encoding="utf-8")):
        mark, text = block["mark"] or "", block["text"]
        if mark.startswith("save as "):
            (tmp_path / mark.removeprefix("save as ")).write_text(text, encoding="utf-8")
        elif block["language"] == "sh" and not mark.startswith("not run: "):
            for line in text.splitlines():
                is_plain = line.startswith("wpcal ") and not line.startswith("wpcal pick") and not SIGNS & set(line)
                if not is_plain or (page == "README.md" and typed == 0):
                    type_line(line, tmp_path)
                else:
                    give_line(line)
                typed += 1
    assert typed >= FEWEST_COMMANDS[page]


@pytest.mark.parametrize("page", PAGES)
def test_every_block_with_commands_is_marked_as_such(page: str) -> None:
    for block in BLOCK.finditer((ROOT / page).read_text(encoding="utf-8")):
        commands = [line for line in block["text"].splitlines() if line.startswith(("wpcal ", "make ", "pip ", "cp "))]
        assert bool(commands) == (block["language"] == "sh"), block[0]
