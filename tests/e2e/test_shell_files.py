"""One command lets a shell complete wpcal, and twice is the same as once."""

import os
import shutil
import subprocess
from pathlib import Path

import pytest

from tests.running import run_here

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
    done = subprocess.run(
        ["bash", "-c", words], env={**os.environ, "HOME": str(tmp_path)}, capture_output=True, text=True, check=False
    )
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
