"""Run every `bench_*.py` of this folder and print its table: `make bench`, or `-m tests.benchmarks annealing`.

`-m tests.benchmarks seams` has options of its own (`--help`).
"""

from __future__ import annotations

import importlib
import sys
from pathlib import Path

from rich.console import Console


def main() -> None:
    console = Console()
    for path in sorted(Path(__file__).parent.glob("bench_*.py")):
        names = sys.argv[1:2] if sys.argv[1:2] == ["seams"] else sys.argv[1:]
        if names and path.stem.removeprefix("bench_") not in names:
            continue
        module = importlib.import_module(f"tests.benchmarks.{path.stem}")
        table = module.main(sys.argv[2:]) if sys.argv[1:2] == ["seams"] else module.main()
        if table is not None:  # a module may print its own
            console.print(table)


main()
