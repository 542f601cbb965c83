"""The files that a shell has of wpcal: completion of commands and options, and the page that ``man wpcal`` shows."""

from __future__ import annotations

import os
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import click

from wpcal.core.version import __version__

STARTS: Mapping[str, str] = {"bash": ".bashrc", "zsh": ".zshrc", "fish": ""}
"""Each shell with the file in the home folder that it reads at its start; fish finds completions by their place."""
PARAGRAPH = "\n.PP\n"


def install(ctx: click.Context) -> None:
    """Write the files of the user's shell, say where they are, and end the command."""
    from wpcal.core.errors import InputError
    from wpcal.core.records import write_file

    shell = Path(os.environ.get("SHELL", "")).name
    if shell not in STARTS:
        known = ", ".join(STARTS)
        raise InputError(f"completion is known for {known}; the variable SHELL says {shell or 'nothing'!r}")
    home = Path.home()
    data = Path(os.environ.get("XDG_DATA_HOME") or home / ".local" / "share")
    script = data / "wpcal" / f"completion.{shell}"
    if shell == "fish":
        script = Path(os.environ.get("XDG_CONFIG_HOME") or home / ".config") / "fish" / "completions" / "wpcal.fish"
    page = data / "man" / "man1" / "wpcal.1"
    for path, text in ((script, _script(ctx.command, shell)), (page, _page(ctx))):
        path.parent.mkdir(parents=True, exist_ok=True)
        write_file(path, text, overwrite=True)
        click.echo(f"wrote {path}")
    if start := STARTS[shell]:
        _add_line(home / start, f'[ -r "{script}" ] && source "{script}"')
    click.echo(f"a new {shell} completes wpcal; `man wpcal` lists its commands")
    ctx.exit()


def _add_line(start: Path, line: str) -> None:
    """Add a line to the file that a shell reads at its start, once; what the file has stays byte for byte."""
    have = start.read_bytes() if start.exists() else b""
    if line.encode() in have.splitlines():
        return
    begin = b"" if not have or have.endswith(b"\n") else b"\n"
    with start.open("ab") as file:
        file.write(begin + line.encode() + b"\n")
    click.echo(f"added a line to {start}")


def _script(command: click.Command, shell: str) -> str:
    from click.shell_completion import get_completion_class

    kind = get_completion_class(shell)
    assert kind is not None  # `install` refuses other shells
    return kind(command, {}, "wpcal", "_WPCAL_COMPLETE").source()


def _page(ctx: click.Context) -> str:
    """Return the page of the manual: what wpcal does, its commands, and its exit codes."""
    group: Any = ctx.command
    about = PARAGRAPH.join(" ".join(part.split()) for part in (group.help or "").split("\n\n"))
    head = f'.TH WPCAL 1 "" "wpcal {__version__}"'
    name = "wpcal \\- put a workpiece and its CAD model in one place"
    lines = [head, ".SH NAME", name, ".SH SYNOPSIS", ".B wpcal", ".I COMMAND", "[options] [files]"]
    lines += [".SH DESCRIPTION", about]
    for title, names in group.by_section().items():
        lines.append(f'.SH "{title.upper()}"')
        for name in names:
            command = group.get_command(ctx, name)
            lines += [".TP", f".B {name}", "" if command is None else command.get_short_help_str(1000)]
    lines += [".SH EXIT STATUS", "0 done, 1 done but outside of a tolerance or with faults, 2 wrong use or input, 70 a "
              "fault of wpcal, 130 interrupted.", ".SH SEE ALSO", ".B wpcal help COMMAND"]  # fmt: skip
    return (
        "\n".join(line.replace("-", "\\-") if line[:1] != "." and "\\-" not in line else line for line in lines) + "\n"
    )
