"""The methods that are commands of `wpcal`: a request becomes the line that a person would type, with ``--json``."""

from __future__ import annotations

import io
import json
from collections.abc import Callable, Mapping, Sequence
from contextlib import redirect_stdout
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import click

from cad.rpc.options import command_named, describe_options, name_of, usage_told, words_of
from cad.rpc.protocol import method_names
from cad.session.decisions import read_decisions
from wpcal.core.errors import InputError
from wpcal.core.records import to_json
from wpcal.core.result_files import PAGE_FILE, SEAMS_FILE
from wpcal.core.wording import shown
from wpcal.seam.record import SEAMS_SCHEMA

GIVEN_BY_PARAMS = frozenset({"out", "json", "format", "write_templates", "write_setup", "check", "no_cache"})
"""Options that a request states by its params, and those that print or only prepare something."""
COMMANDS = ("export", "touches", "plan")  #: Methods with the options of the command of the same name.

CommandMethod = Callable[[Mapping[str, Any]], dict[str, Any]]


def options_of(method: str) -> list[dict[str, Any]]:
    """Return the options of a method; none if it takes none. Raises `InputError` if there is no such method."""
    if method not in method_names():
        raise InputError(f"{shown(method)}: no such method; known: {', '.join(method_names())}")
    if method in COMMANDS:
        return describe_options(_options(method))
    from cad.rpc.part_methods import PART_OPTIONS

    takes_options = ("seams", "read_taught", "calibrate", "suggest", "save")
    return describe_options(PART_OPTIONS.options) if method in takes_options else []


def _options(command: str) -> list[click.Option]:
    found = [each for each in command_named(command).params if isinstance(each, click.Option)]
    return [each for each in found if name_of(each) not in GIVEN_BY_PARAMS]


def _run(command: str, arguments: Sequence[str], params: Mapping[str, Any]) -> dict[str, Any]:
    """Run a command in this process and return the record that it prints."""
    words = [*arguments, *words_of(_options(command), params.get("options", {})), "--json"]
    printed = io.StringIO()
    with redirect_stdout(printed), usage_told():
        command_named(command).main(words, f"wpcal {command}", standalone_mode=False)
    record: dict[str, Any] = json.loads(printed.getvalue())
    return record


def _path(params: Mapping[str, Any], name: str) -> str:
    """Return a path that click takes for no option."""
    text: str = params[name]
    if not text:
        raise InputError(f"{name}: expected a path, got an empty text")
    return f"./{text}" if text.startswith("-") else text


def _out(params: Mapping[str, Any]) -> list[str]:
    return ["-o", _path(params, "out")] if "out" in params else []


def formats(_: Mapping[str, Any]) -> dict[str, Any]:
    """Return the formats of `export`."""
    from wpcal.controllers.registry import exporter_named, exporter_names

    exporters = [exporter_named(name) for name in exporter_names()]
    listed = [
        {"name": each.name, "title": each.title, "brands": list(getattr(each, "brands", ()))} for each in exporters
    ]
    return {"formats": listed, "options": options_of("export")}


def export(params: Mapping[str, Any]) -> dict[str, Any]:
    """Write a result folder in the languages of controllers."""
    if "list" in params["formats"]:
        raise InputError("formats: list is none; the method formats lists them")
    names = [word for name in params["formats"] for word in ("-f", name)]
    return _run("export", [_path(params, "folder"), *names, *_out(params)], params)


def touches(params: Mapping[str, Any]) -> dict[str, Any]:
    """Plan the touches of a part, and write the plan."""
    decisions = params.get("decisions")
    if not decisions:
        return _run("touches", [_path(params, "path"), *_out(params)], params)
    read_decisions(decisions, path="decisions")
    seams = [{**decision, "name": decision["candidate"]["name"]} for decision in decisions]
    with TemporaryDirectory() as folder:
        file = Path(folder, SEAMS_FILE)
        file.write_text(to_json({"schema": SEAMS_SCHEMA, "seams": seams}), encoding="utf-8")
        return _run("touches", [_path(params, "path"), "--seams", str(file), *_out(params)], params)


def plan(params: Mapping[str, Any]) -> dict[str, Any]:
    """Plan the welds of a result folder in a cell, and write the plan."""
    return _run("plan", [_path(params, "cell"), _path(params, "folder"), *_out(params)], params)


def page(params: Mapping[str, Any]) -> dict[str, Any]:
    """Return the page of a result folder; it is made if it is not there."""
    folder = Path(params["folder"])
    target = folder / PAGE_FILE
    if not target.is_file():
        _run("report", [_path(params, "folder")], {})
    return {"path": str(target.absolute())}


def options(params: Mapping[str, Any]) -> dict[str, Any]:
    """Return the options of a method."""
    return {"options": options_of(params["method"])}


METHODS: Mapping[str, CommandMethod] = {
    "options": options,
    "formats": formats,
    "export": export,
    "touches": touches,
    "plan": plan,
    "page": page,
}
