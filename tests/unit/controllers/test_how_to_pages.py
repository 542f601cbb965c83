"""The programs and excerpts of the how-to pages are, line by line, what `wpcal export` and `wpcal plan` write."""

import shlex
from pathlib import Path

import pytest

from tests.few import few
from tests.shown_programs import lines_shown, shown_programs
from wpcal.cli.main import run

ROOT = Path(__file__).parents[3]
WHOLE = {
    "abb.md": ["WPCAL.mod", "WPCAL.mod"],
    "fanuc.md": ["W1.ls", "WPCAL.ls", "W2.ls"],
    "kawasaki.md": ["WPCAL.as", "WPCAL.as"],
    "kuka.md": ["WPCAL.dat", "WPCAL.src", "WPCAL.src"],
    "touch-programs.md": [
        *("WPCAL_touch.mod", "WPCAL_touch_res.mod", "WPCAL_touch.dat", "WPCAL_touch.src", "WPCAL_TOUCH.ls"),
        *("WPCAL_TOUCH.jbi", "WPCAL_touch.script", "WPCAL_touch.as"),
    ],
    "two-robots.md": [
        *("WPCAL_W2.jbi", "WPCAL_W2_R1.dat", "WPCAL_W2_R1.mod", "WPCAL_W2_R1.src"),
        *("WPCAL_W2_R2.dat", "WPCAL_W2_R2.mod", "WPCAL_W2_R2.src", "wpcal_w2.ls"),
    ],
    "universal-robots-and-staubli.md": [
        *("WPCAL.script", "WPCAL.dtx", "WPCAL.pjx", "start.pgx", "stop.pgx"),
        *("WPCAL.script", "start.pgx"),
    ],
    "yaskawa.md": ["W1.jbi", "WPCAL.jbi", "W2.jbi"],
}


@pytest.mark.parametrize("page", few(sorted(WHOLE, key="two-robots.md".__eq__), len(WHOLE) - 1))
def test_the_page_shows_what_is_written(page, tmp_path, monkeypatch):
    monkeypatch.chdir(ROOT)
    found = list(shown_programs(page))
    assert [one.file for one in found] == WHOLE[page]
    assert lines_shown(page) <= {line for one in found for line in one.text.splitlines()}
    commands = list(dict.fromkeys(one.command for one in found))
    if any(command.startswith("plan") for command in commands):
        pytest.importorskip("fcl", reason="python-fcl is not installed")
    for one in found:
        out = tmp_path / str(commands.index(one.command))
        if not out.exists():  # a command is run once for all its files
            with pytest.raises(SystemExit) as ended:
                run([*shlex.split(one.command), "-o", str(out)])
            assert ended.value.code == 0
        (path,) = out.rglob(one.file)
        written = path.read_bytes().decode().replace("\r\n", "\n").rstrip("\n")
        assert one.text.rstrip("\n") == written, f"{page}: run python docs/make_controller_files.py"
