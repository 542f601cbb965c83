"""How often candidates of a stated confidence are welds: `python -m tests.benchmarks.welds.reliability [FOLDER]`.

Every part of the benchmark that is at hand is searched, as it is and with its welded bodies fused. A candidate that a
torch reaches is a weld if at least 90 % of it runs along a weld of the list, of whatever class.
"""

import json
import sys
from collections.abc import Iterator
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np

from tests.benchmarks.bench_seams import fused_part, part_of, seams_of
from tests.benchmarks.welds.lists import FOLDER, read_record, welds_of
from tests.benchmarks.welds.score import COVERED, SLACK_MM, along, sampled, seam_samples
from wpcal.core.arrays import FloatArray

BINS = (0.0, 0.1, 0.3, 0.5, 0.7, 0.9, 1.0)  #: Confidences from one to the next are counted together.


def read_candidates(folder: Path) -> Iterator[dict[str, Any]]:
    """Yield the part, source, confidence, length and truth of every candidate that a torch reaches."""
    for path in sorted((FOLDER / "lists").glob("*.json")):
        record = read_record(path)
        step = part_of(record, path.parent, folder)
        fused = None if step is None else fused_part(step, record)
        for name, file in ((path.stem, step), (f"{path.stem}, fused", fused)):
            if file is not None:
                yield from _candidates(name, file, record)


def _candidates(name: str, step: Path, record: dict[str, Any]) -> Iterator[dict[str, Any]]:
    welds = [(weld, sampled(weld.points)) for weld in welds_of(record)]
    for seam in seams_of(step):
        if seam["reachable"] and seam["frames"]:
            run = seam_samples(seam)
            hit = np.zeros(len(run.p), dtype=bool)
            for weld, samples in welds:
                hit |= along(run, samples, np.full(len(samples.p), weld.tol_mm + SLACK_MM))
            is_weld = bool(run.length[hit].sum() >= COVERED * run.total_mm)
            facts = {key: seam[key] for key in ("source", "confidence", "length_mm") if key in seam}
            rules = [finding["rule"] for finding in seam.get("findings", ())]
            yield {"part": name, **facts, "rules": rules, "is_weld": is_weld}


def table(confidence: FloatArray, is_weld: FloatArray) -> str:
    """Return the reliability diagram as a table, and the Brier score."""
    lines = ["| stated | candidates | mean stated | are welds |", "|-|-|-|-|"]
    for low, high in pairwise(BINS):
        own = (confidence >= low) & ((confidence < high) | (high == BINS[-1]))
        if own.any():
            share = f"{confidence[own].mean():.0%} | {is_weld[own].mean():.0%}"
            lines.append(f"| {low:.0%} to {high:.0%} | {own.sum()} | {share} |")
    return "\n".join([*lines, "", f"Brier score {np.mean((confidence - is_weld) ** 2):.3f}"])


def main() -> None:
    """Print the table; with a second argument, keep the candidates in that file."""
    found = list(read_candidates(Path(sys.argv[1]) if len(sys.argv) > 1 else FOLDER))
    if len(sys.argv) > 2:
        Path(sys.argv[2]).write_text(json.dumps(found), encoding="utf-8")
    confidence, is_weld = (np.array([float(one[key]) for one in found]) for key in ("confidence", "is_weld"))
    print(table(confidence, is_weld))


if __name__ == "__main__":
    main()
