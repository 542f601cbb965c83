"""Run every `bench_*.py` of this folder and print its table: `make bench`, or `-m tests.benchmarks annealing`.

`-m tests.benchmarks seams` and `-m tests.benchmarks assemblies` have options of their own (`--help`).
"""

import importlib
import sys
from pathlib import Path

from rich.console import Console


def main() -> None:
    console = Console()
    has_options = sys.argv[1:2] in (["assemblies"], ["seams"])
    names = sys.argv[1:2] if has_options else sys.argv[1:]
    for path in sorted(Path(__file__).parent.glob("bench_*.py")):
        if names and path.stem.removeprefix("bench_") not in names:
            continue
        module = importlib.import_module(f"tests.benchmarks.{path.stem}")
        table = module.main(sys.argv[2:]) if has_options else module.main()
        if table is not None:  # a module may print its own
            console.print(table)


main()
