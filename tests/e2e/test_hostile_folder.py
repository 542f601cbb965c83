"""Nothing that lies beside a customer's file is run; one command lets a shell complete wpcal, once."""

import json
import os
import shutil
import signal
import subprocess
import sys
from importlib.metadata import entry_points, packages_distributions
from pathlib import Path

import pytest

from tests.e2e.every_command import COMMANDS, NEEDS_ROBOT, write_inputs
from tests.few import few
from tests.running import FINISHED, TIMEOUT_S, run_command, run_here
from wpcal.cli.main import EXIT_INTERRUPTED

WPCAL = Path(sys.executable).with_name("wpcal")  #: The command as a user calls it.
MARK = "RUN"
TRAP = f"open({MARK!r}, 'a').write(__name__ + ' ' + __file__ + chr(10))\nraise SystemExit(99)\n"
ALSO = ("sitecustomize", "usercustomize", "conftest", "setup", "resource", "_wpcal")
PACKAGES = ("wpcal", "cad")
SERVES = "pick"
QUICK = ("calibrate", "audit", "diff", "export", "features", "fit", "match", "report", "seams", "welds")
"""They read the part, tables, records and programs, and draw with matplotlib; all other commands are deep tests."""

DRIVER = """
import json, os, sys
from wpcal.cli.main import run
import cad.work.child
from importlib import import_module

def here(target, arguments=None, *, progress=None, **_):
    module, _, function = target.partition(":")
    more = {} if progress is None else {"progress": progress}
    return getattr(import_module(module), function)(**(arguments or {}), **more)

cad.work.child.run_in_child = here
os.environ["WPCAL_CACHE"] = os.path.dirname(__file__) + "/answers"  # who finds seams once more imports nothing new
places, ended = list(sys.path), {}
for name, line in json.loads(sys.argv[1]).items():
    try:
        run([name, *line.split()])
    except SystemExit as end:
        ended[name] = [end.code, open("RUN").read() if os.path.exists("RUN") else "", sys.path == places]
with open("ended.json", "w") as file:
    json.dump(ended, file)
"""
"""What the command's own script does, once for each command; it is called `wpcal` like that script."""


def set_traps(folder: Path) -> None:
    """Write a module that leaves a mark for every name that Python or an installed package imports."""
    names = {*sys.stdlib_module_names, *packages_distributions(), *ALSO} - set(PACKAGES)
    for name in names:
        if name.isidentifier():
            (folder / f"{name}.py").write_text(TRAP)
    for name in PACKAGES:
        (folder / name).mkdir()
        (folder / name / "__init__.py").write_text(TRAP)


@pytest.fixture(scope="module", params=few([(QUICK,), (tuple(COMMANDS),)], 1), ids=["quick", "all"])
def commands(request: pytest.FixtureRequest) -> tuple[str, ...]:
    return tuple(name for name in request.param if name != SERVES)


@pytest.fixture(scope="module")
def hostile(commands: tuple[str, ...], tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with inputs for every command and traps beside them."""
    folder = tmp_path_factory.mktemp("hostile")
    write_inputs(folder)
    (folder / "matplotlibrc").write_text("text.usetex: True\nbackend: module://evil\n")
    (folder / "evil.py").write_text(TRAP)
    set_traps(folder)
    return folder


@pytest.fixture(scope="module")
def ended(
    commands: tuple[str, ...], hostile: Path, tmp_path_factory: pytest.TempPathFactory
) -> dict[str, list[object]]:
    """For each command: its exit code, what was run, and whether modules are still looked for in the same places."""
    driver = tmp_path_factory.mktemp("bin") / "wpcal"
    driver.write_text(DRIVER)
    lines = {name: COMMANDS[name].replace("-o new", f"-o new-{name}") for name in commands}
    command = [sys.executable, driver, json.dumps(lines)]
    done = subprocess.run(command, cwd=hostile, capture_output=True, text=True, check=False, timeout=TIMEOUT_S)
    assert done.returncode == 0, done.stderr
    found: dict[str, list[object]] = json.loads((hostile / "ended.json").read_text())
    return found


def test_every_command_is_tried() -> None:
    assert set(COMMANDS) | NEEDS_ROBOT == {entry.name for entry in entry_points(group="wpcal.commands")}


def test_no_module_beside_the_files_is_run(ended: dict[str, list[object]], commands: tuple[str, ...]) -> None:
    assert tuple(ended) == commands
    for command, (code, run, same_places) in ended.items():
        assert (run, same_places) == ("", True), command
        assert code in FINISHED, command


def test_the_picker_and_the_kernels_process_run_no_module_beside_the_files(hostile: Path) -> None:
    (hostile / MARK).unlink(missing_ok=True)
    process = subprocess.Popen(
        [WPCAL, SERVES, *COMMANDS[SERVES].split()],
        cwd=hostile,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )
    assert "is at http" in process.stdout.readline()
    process.send_signal(signal.SIGINT)
    _, errors = process.communicate(timeout=TIMEOUT_S)
    assert not (hostile / MARK).exists(), (hostile / MARK).read_text()
    assert process.returncode in (*FINISHED, EXIT_INTERRUPTED), errors  # the picker ends by Ctrl-C


def test_an_empty_entry_of_pythonpath_is_not_the_current_folder(hostile: Path) -> None:
    """A trailing colon is common in what shells of robot software set. Python itself reads such an entry early."""
    for file in hostile.glob("*.py"):
        if file.stem not in ("numpy", "scipy", "OCP", "build123d"):
            file.unlink()
    for name in PACKAGES:
        shutil.rmtree(hostile / name)
    (hostile / MARK).unlink(missing_ok=True)
    environment = {**os.environ, "PYTHONPATH": "/nowhere" + os.pathsep}
    done = subprocess.run([WPCAL, "features", "tee.step"], cwd=hostile, env=environment, check=False)
    assert not (hostile / MARK).exists()
    assert done.returncode == 0


HAVE = b"alias ll='ls -l'"


def installed(shell: str, home: Path, monkeypatch: pytest.MonkeyPatch) -> str:
    for name in ("XDG_DATA_HOME", "XDG_CONFIG_HOME"):
        monkeypatch.delenv(name, raising=False)
    monkeypatch.setenv("HOME", str(home))
    monkeypatch.setenv("SHELL", f"/bin/{shell}")
    done = run_here("--install-completion")
    assert done.returncode == 0, done.stderr
    return done.stdout


@pytest.mark.parametrize("shell", ["bash", "zsh"])
def test_a_line_is_added_once_and_nothing_else_changes(
    shell: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    start = tmp_path / f".{shell}rc"
    start.write_bytes(HAVE)
    assert f"added a line to {start}" in installed(shell, tmp_path, monkeypatch)
    assert "added a line" not in installed(shell, tmp_path, monkeypatch)
    have, line = start.read_bytes().splitlines()
    assert have == HAVE
    assert str(tmp_path / ".local" / "share" / "wpcal" / f"completion.{shell}") in line.decode()


def test_fish_finds_its_file_by_its_place(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    installed("fish", tmp_path, monkeypatch)
    assert "complete" in (tmp_path / ".config" / "fish" / "completions" / "wpcal.fish").read_text()


@pytest.mark.skipif(shutil.which("bash") is None, reason="bash is not installed")
def test_bash_completes_with_it(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    installed("bash", tmp_path, monkeypatch)
    words = "source ~/.bashrc; complete -p wpcal"
    done = run_command("bash", "-c", words, HOME=str(tmp_path))
    assert "wpcal" in done.stdout, done.stderr


def test_the_page_of_the_manual_has_every_command(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    installed("bash", tmp_path, monkeypatch)
    lines = (tmp_path / ".local" / "share" / "man" / "man1" / "wpcal.1").read_text().splitlines()
    assert {".B calibrate", ".B shop", ".B rpc", ".SH NAME"} <= set(lines)
    known = (".TH", ".SH", ".TP", ".B", ".I", ".PP")
    assert all(line.startswith(known) for line in lines if line.startswith("."))


def test_another_shell_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("SHELL", "/bin/csh")
    done = run_here("--install-completion")
    assert (done.returncode, done.stdout) == (2, "")
    assert "known for bash, zsh, fish; the variable SHELL says 'csh'" in done.stderr
