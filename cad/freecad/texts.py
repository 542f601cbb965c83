# SPDX-License-Identifier: MIT
"""The texts of the workbench for translators, as Qt's tools read them (`WpCal.ts`).

A translator copies the file to `WpCal_de.ts`, fills it with Qt Linguist, and puts what `lrelease` writes beside it.
"""

from __future__ import annotations

import ast
from pathlib import Path
from typing import Iterator
from xml.sax.saxutils import escape

CONTEXT = "WpCal"
HEAD = '<?xml version="1.0" encoding="utf-8"?>\n<!DOCTYPE TS>\n<TS version="2.1" sourcelanguage="en">'
MESSAGE = '    <message><source>{}</source><translation type="unfinished"/></message>'
SHOWN = {"title", "HEADERS", "COLUMNS", "buttons", "labels", "FIRST_OPTIONS"}
"""Names whose texts are translated where they are shown."""
COMMAND = "PanelCommand"  #: Its second and third argument are texts.


def texts_of(tree: ast.AST) -> Iterator[str]:
    """Yield the texts of a module that the user sees."""
    for node in ast.walk(tree):
        if isinstance(node, ast.Call) and isinstance(node.func, ast.Name):
            if node.func.id == "translate":
                yield from _strings(node.args[:1])
            elif node.func.id == COMMAND:
                yield from _strings(node.args[1:3])
        elif isinstance(node, ast.Assign) and any(isinstance(t, ast.Name) and t.id in SHOWN for t in node.targets):
            yield from _strings([node.value])


def _strings(nodes: list[ast.expr]) -> Iterator[str]:
    for node in nodes:
        if isinstance(node, ast.Constant) and isinstance(node.value, str) and node.value.strip():
            yield node.value
        elif isinstance(node, (ast.Tuple, ast.List)):
            yield from _strings(node.elts)
        elif isinstance(node, ast.Dict):
            yield from _strings(node.values)


def translation_file(package: Path) -> str:
    """Return the file for translators of all modules in a folder."""
    sources = [path.read_text(encoding="utf-8") for path in package.rglob("*.py")]
    found = sorted({text for source in sources for text in texts_of(ast.parse(source))})
    messages = "\n".join(MESSAGE.format(escape(text)) for text in found)
    return f"{HEAD}\n  <context>\n    <name>{CONTEXT}</name>\n{messages}\n  </context>\n</TS>\n"
