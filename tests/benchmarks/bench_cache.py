"""The commands of a working day on one part: processor time without the cache, with it for the first time, and again.

The first time, the commands run one after the other, so that each finds what those before it kept.
"""

import tempfile
from pathlib import Path

from rich.table import Table

from tests.benchmarks.timing import run_python

FRAME = Path(__file__).parents[2] / "fixtures" / "frame"
LINES = (
    "features PART",
    "seams PART",
    "advise PART -o advised.csv --force",
    "sheet PART advised.csv -o sheet.svg --force",
    "calibrate PART TAUGHT -o out --force --accept-unsure",
)
REPEATS = 3  #: The least of so many runs counts: other work on the machine only ever adds.
ASKED_S = 1.5


def main() -> Table:
    """Measure and return the table."""
    table = Table(title=f"Processor time on frame.step, s (asked for the last column: ≤ {ASKED_S})")
    for heading in ("command", "without", "first", "again", "again / without"):
        table.add_column(heading, justify="right" if heading != "command" else "left")
    with tempfile.TemporaryDirectory() as folder:
        without = [least(line, Path(folder), "off") for line in LINES]
        once = [Path(folder, f"answers{k}") for k in range(REPEATS)]
        first = [min(seconds(line, Path(folder), str(answers)) for answers in once) for line in LINES]
        again = [least(line, Path(folder), str(once[0])) for line in LINES]
    for line, *row in zip(LINES, without, first, again, strict=True):
        table.add_row(line.split()[0], *(f"{s:.2f}" for s in row), f"{row[2] / row[0]:.2f}")
    return table


def least(line: str, folder: Path, answers: str) -> float:
    return min(seconds(line, folder, answers) for _ in range(REPEATS))


def seconds(line: str, folder: Path, answers: str) -> float:
    """Run a command; return the processor time of it and its children, s."""
    places = {"PART": str(FRAME / "frame.step"), "TAUGHT": str(FRAME / "taught.csv")}
    words = [places.get(word, word) for word in line.split()]
    return run_python("-m", "wpcal", *words, environment={"WPCAL_CACHE": answers}, folder=str(folder)).processor_s
