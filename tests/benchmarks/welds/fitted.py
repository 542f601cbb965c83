"""Would fitted factors judge better than those set by hand? `python -m tests.benchmarks.welds.fitted FOLDER`.

FOLDER holds ``NAME.json`` of `wpcal seams NAME.step --json` for parts with lists. Every part is judged with factors
that were fitted to the other parts (logistic regression on the findings, every part with the same weight). Candidates
that no torch reaches or that are in material are left out: their rules are not a matter of degree.
"""

from __future__ import annotations

import json
import sys
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from scipy.optimize import minimize

from tests.benchmarks.welds.lists import read_record, welds_of
from tests.benchmarks.welds.score import score
from wpcal.core.arrays import BoolArray, FloatArray
from wpcal.seam.rules import GAP_SHARE_LOST, Rule

LISTS = Path("fixtures/welds/lists")
RIDGE = 0.02  #: Keeps the factor of a rule that was seen on few parts near 1.
NOT_A_DEGREE = {Rule.IN_MATERIAL.key, Rule.NOT_REACHED.key}
KEYS = [rule.key for rule in Rule]


@dataclass(frozen=True, slots=True, eq=False)
class Candidates:
    """n candidates: part, findings (n, rules), on a weld, length, and whether the rules by hand take them."""

    part: FloatArray
    findings: FloatArray
    is_weld: BoolArray
    length_mm: FloatArray
    by_hand: BoolArray


def read_candidates(folder: Path) -> Candidates:
    """Read the candidates of all parts of a folder that have a list."""
    rows = []
    for file in sorted(folder.glob("*.json")):
        listed = LISTS / file.name
        if not listed.exists():
            continue
        seams = [seam for seam in json.loads(file.read_text(encoding="utf-8"))["seams"] if len(seam["frames"]) > 1]
        judged = score(file.stem, welds_of(read_record(listed)), [{**seam, "accepted": True} for seam in seams])
        wrong = {seam["name"] for seam in judged.wrong_seams}
        for seam in seams:
            found = {one["rule"]: one["factor"] for one in seam["findings"]}
            if not NOT_A_DEGREE & set(found):
                x = [float(key in found) for key in KEYS]
                x[KEYS.index(Rule.GAP.key)] = (1.0 - found.get(Rule.GAP.key, 1.0)) / GAP_SHARE_LOST
                rows.append((file.stem, x, seam["name"] not in wrong, seam["length_mm"], seam["accepted"]))
    columns = [np.array(column) for column in zip(*rows, strict=True)]
    return Candidates(*columns)


def fit(candidates: Candidates, own: BoolArray) -> FloatArray:
    """Return the constant and the logarithm of the odds of every rule, fitted to some of the candidates."""
    x, y, part = candidates.findings[own], candidates.is_weld[own], candidates.part[own]
    weight = 1.0 / np.array([(part == name).sum() for name in part])

    def loss(b: FloatArray) -> float:
        z = b[0] + x @ b[1:]
        return float(weight @ (np.logaddexp(0.0, z) - y * z) + RIDGE * b[1:] @ b[1:])

    return np.asarray(minimize(loss, np.zeros(len(KEYS) + 1), method="L-BFGS-B").x)


def told(name: str, candidates: Candidates, taken: BoolArray) -> str:
    """Return one row of the table."""
    weld, length = candidates.is_weld, candidates.length_mm
    right, wrong = taken & weld, taken & ~weld
    shares = f"{length[right].sum() / length[weld].sum():.1%} | {length[right].sum() / length[taken].sum():.1%}"
    return f"| {name} | {right.sum()} of {weld.sum()} | {wrong.sum()}, {length[wrong].sum():.0f} mm | {shares} |"


def main(folder: Path) -> None:
    """Print the comparison."""
    candidates = read_candidates(folder)
    left_out = np.zeros(len(candidates.part), dtype=bool)
    for name in np.unique(candidates.part):
        b = fit(candidates, candidates.part != name)
        own = candidates.part == name
        left_out[own] = b[0] + candidates.findings[own] @ b[1:] > 0
    b = fit(candidates, np.ones(len(left_out), dtype=bool))
    print(f"{len(np.unique(candidates.part))} parts, {len(left_out)} candidates")
    print("| factors | candidates on welds taken | wrong ones | found by length | right by length |")
    print(told("set by hand", candidates, candidates.by_hand))
    print(told("fitted, each part judged by the others", candidates, left_out))
    print(told("fitted to all, the same parts", candidates, b[0] + candidates.findings @ b[1:] > 0))


if __name__ == "__main__":
    main(Path(sys.argv[1]))
