"""Would fitted probabilities judge better than factors set by hand? `python -m tests.benchmarks.welds.fitted FOLDER`.

FOLDER holds ``NAME.json`` of `wpcal seams NAME.step --json` for parts with lists. The log-odds of a candidate are those
of its source plus one term for each finding, which is never positive. They are fitted to the parts of all authors but
one (logistic regression, every author and every part with a limited weight, towards the values set by hand), and judge
the parts of that one. Candidates that no torch reaches or that are in material are left out.
"""

from __future__ import annotations

import json
import sys
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from scipy.optimize import minimize

from tests.benchmarks.welds.lists import FOLDER, read_record, welds_of
from tests.benchmarks.welds.score import score
from wpcal.core.arrays import BoolArray, FloatArray
from wpcal.seam.rules import GAP_SHARE_LOST, PRIOR, Rule
from wpcal.seam.seam import SeamSource

SPREADS = (0.5, 1.0, 2.0)  #: How far the log-odds may go from those set by hand: standard deviations of their prior.
OF_PART, OF_AUTHOR = 20.0, 200.0  #: A part counts as so many candidates at most, and an author.
NOT_A_DEGREE = {Rule.IN_MATERIAL.key, Rule.NOT_REACHED.key}
SOURCES = [source for source in SeamSource if not source.is_chosen]
KEYS = [rule.key for rule in Rule]


@dataclass(frozen=True, slots=True, eq=False)
class Candidates:
    """n candidates: part, author, sources and findings (n, k), on a weld, length, and the confidence by hand."""

    part: FloatArray
    author: FloatArray
    x: FloatArray
    is_weld: BoolArray
    length_mm: FloatArray
    by_hand: FloatArray


def read_candidates(folder: Path) -> Candidates:
    """Read the candidates of all parts of a folder that have a list."""
    rows = []
    for file in sorted(folder.glob("*.json")):
        listed = FOLDER / "lists" / file.name
        if not listed.exists():
            continue
        record = read_record(listed)
        author = record["part"].get("address", record["part"]["source"]).replace("github:", "").replace(" ", "/")
        seams = [seam for seam in json.loads(file.read_text(encoding="utf-8"))["seams"] if len(seam["frames"]) > 1]
        judged = score(file.stem, welds_of(record), [{**seam, "accepted": True} for seam in seams])
        wrong = {seam["name"] for seam in judged.wrong_seams}
        for seam in seams:
            found = {one["rule"]: one["factor"] for one in seam["findings"]}
            if not NOT_A_DEGREE & set(found):
                x = [float(seam["source"] == source.value) for source in SOURCES] + [
                    float(key in found) for key in KEYS
                ]
                x[len(SOURCES) + KEYS.index(Rule.GAP.key)] = (1.0 - found.get(Rule.GAP.key, 1.0)) / GAP_SHARE_LOST
                facts = (seam["name"] not in wrong, seam["length_mm"], seam["confidence"])
                rows.append((file.stem, author.split("/")[0], x, *facts))
    return Candidates(*(np.array(column) for column in zip(*rows, strict=True)))


def by_hand() -> FloatArray:
    """Return the log-odds of the sources, and what a finding takes from those of a contact, as they are set by hand."""
    start = PRIOR[SeamSource.CONTACT]
    odds = [_odds(PRIOR[source]) for source in SOURCES]
    return np.array(odds + [_odds(start * rule.factor) - _odds(start) for rule in Rule])


def _odds(p: float) -> float:
    return float(np.log(p / (1.0 - p)))


def fit(candidates: Candidates, own: BoolArray, spread: float) -> FloatArray:
    """Return log-odds fitted to some of the candidates."""
    x, y, prior = candidates.x[own], candidates.is_weld[own], by_hand()
    weight = np.ones(len(y))
    for of, most in ((candidates.part[own], OF_PART), (candidates.author[own], OF_AUTHOR)):
        for name in np.unique(of):
            rows = of == name
            weight[rows] *= min(1.0, most / weight[rows].sum())

    def loss(b: FloatArray) -> float:
        z = x @ b
        return float(weight @ (np.logaddexp(0.0, z) - y * z) + 0.5 * ((b - prior) ** 2).sum() / spread**2)

    bounds = [(None, None)] * len(SOURCES) + [(None, 0.0)] * len(KEYS)
    return np.asarray(minimize(loss, prior, method="L-BFGS-B", bounds=bounds).x)


def told(name: str, candidates: Candidates, p: FloatArray) -> str:
    """Return one row of the table."""
    weld, length, taken = candidates.is_weld, candidates.length_mm, p >= 0.5
    right, wrong = taken & weld, taken & ~weld
    shares = f"{length[right].sum() / length[weld].sum():.1%} | {length[right].sum() / length[taken].sum():.1%}"
    brier = f"{np.mean((p - weld) ** 2):.3f}"
    counts = f"{right.sum()} of {weld.sum()} | {wrong.sum()}, {length[wrong].sum():.0f} mm"
    return f"| {name} | {counts} | {shares} | {brier} |"


def main(folder: Path) -> None:
    """Print the comparison."""
    candidates = read_candidates(folder)
    authors = np.unique(candidates.author)
    print(f"{len(np.unique(candidates.part))} parts of {len(authors)} authors, {len(candidates.part)} candidates")
    print("| factors | candidates on welds taken | wrong ones | found by length | right by length | Brier |")
    print(told("set by hand", candidates, candidates.by_hand))
    for spread in SPREADS:
        p = np.zeros(len(candidates.part))
        for name in authors:
            own = candidates.author == name
            p[own] = 1.0 / (1.0 + np.exp(-candidates.x[own] @ fit(candidates, ~own, spread)))
        print(told(f"fitted to other authors, spread {spread:g}", candidates, p))
    b = fit(candidates, np.ones(len(candidates.part), dtype=bool), SPREADS[1])
    print(told("fitted to all, the same parts", candidates, 1.0 / (1.0 + np.exp(-candidates.x @ b))))


if __name__ == "__main__":
    main(Path(sys.argv[1]))
