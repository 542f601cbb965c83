"""Run every `bench_*.py` of this folder and print its table: `make bench`, or `-m tests.benchmarks annealing`."""

from __future__ import annotations

import importlib
import sys
from pathlib import Path

from rich.console import Console


def main() -> None:
    console = Console()
    for path in sorted(Path(__file__).parent.glob("bench_*.py")):
        if sys.argv[1:] and path.stem.removeprefix("bench_") not in sys.argv[1:]:
            continue
        table = importlib.import_module(f"tests.benchmarks.{path.stem}").main()
        if table is not None:  # a module may print its own
            console.print(table)


main()
