"""Kawasaki AS as text: poses, expressions, and programs as steps with their blocks."""

from __future__ import annotations

import operator
import re
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

from wpcal.controllers.run.expressions import COMPARE, PRODUCT, SIGNS, SUM, Syntax, tokens_of
from wpcal.controllers.run.machine import inverted, rigid
from wpcal.controllers.run.program import ProgramError

TOKEN = re.compile(
    r'"[^"]*"|\d+(?:\.\d+)?(?:[eE][-+]?\d+)?|\.\d+|\$?#?[A-Za-z][\w.]*|==|<>|<=|>=|=<|[-+*/=<>()\[\],:^]'
)
MOST_NAME = 15  #: Characters of a name.


@dataclass(frozen=True)
class Pose:
    """A transformation: X Y Z, and O about z, A about the new y, T about the new z."""

    T: Any

    @classmethod
    def of(cls, values: Any) -> Pose:
        return cls(rigid(Rotation.from_euler("ZYZ", values[3:6], degrees=True), values[:3]))

    def values(self) -> list[float]:
        rotation = self.T[:3, :3]
        if abs(rotation[2, 2]) > 1.0 - 1e-12:  # A is 0 or 180: only the sum or difference of O and T counts
            a = 0.0 if rotation[2, 2] > 0 else 180.0
            o = float(
                np.degrees(
                    np.arctan2(rotation[1, 0], rotation[1, 1])
                    if a == 0
                    else np.arctan2(-rotation[1, 0], rotation[1, 1])
                )
            )
            angles = [o, a, 0.0]
        else:
            angles = [float(v) for v in Rotation.from_matrix(rotation).as_euler("ZYZ", degrees=True)]
        return [*(float(v) for v in self.T[:3, 3]), *angles]

    def __add__(self, other: Pose) -> Pose:
        return Pose(self.T @ other.T)

    def __neg__(self) -> Pose:
        return Pose(inverted(self.T))

    def __sub__(self, other: Pose) -> Pose:
        return Pose(self.T @ inverted(other.T))


GRAMMAR = Syntax(
    TOKEN,
    (
        {"OR": lambda a, b: -1 if a or b else 0},
        {"AND": lambda a, b: -1 if a and b else 0},
        {"==": operator.eq, **COMPARE, "=<": operator.le},
        SUM,
        {**PRODUCT, "MOD": operator.mod},
    ),
    {**SIGNS, "NOT": lambda a: 0 if a else -1},
    {"TRUE": -1, "FALSE": 0, "ON": -1, "OFF": 0},
    index=("[", "]"),
)


@dataclass
class Step:
    label: str
    tokens: list[str]
    blocks: list[list[Step]] = field(default_factory=list)


def steps_of(rows: list[str]) -> list[Step]:
    tokens = []
    for row in rows:
        bare = re.sub(r'^((?:[^";]|"[^"]*")*);.*', r"\1", row).strip()
        if bare:
            label = re.match(r"(\d+)\s+(?=\S)", bare)
            rest = bare[label.end() :] if label else bare
            tokens.append((label[1] if label else "", tokens_of(rest, GRAMMAR)))
    found, at = _block(tokens, 0, set())
    if at != len(tokens):
        raise ProgramError(f"too much: {tokens[at]}")
    return found


def _block(rows: list[Any], at: int, ends: set[str]) -> tuple[list[Step], int]:
    found: list[Step] = []
    while at < len(rows) and rows[at][1][0].upper() not in ends:
        label, tokens = rows[at]
        words = [token.upper() for token in tokens]
        step = Step(label, tokens)
        opens = (words[0] == "IF" and words[-1] == "THEN") or words[0] in {"FOR", "WHILE"}
        if opens:
            body, at = _block(rows, at + 1, {"END", "ELSE"})
            step.blocks.append(body)
            if at < len(rows) and rows[at][1][0].upper() == "ELSE":
                body, at = _block(rows, at + 1, {"END"})
                step.blocks.append(body)
            if at >= len(rows):
                raise ProgramError(f"no END: {' '.join(tokens)}")
        found.append(step)
        at += 1
    return found, at
