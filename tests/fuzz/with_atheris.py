"""One reader under atheris, which knows which lines of the code an input reaches. `tests.fuzz` starts this process.

    python -m tests.fuzz.with_atheris READER SECONDS INPUTS

atheris 3 (Apache-2.0) is in the extra `fuzz`. It ends the process itself, so findings are written at once.
"""

import random
import sys
import tempfile
from pathlib import Path

import atheris

with atheris.instrument_imports(include=["wpcal", "cad"]):
    from tests.fuzz.targets import targets

from tests.fuzz.findings import keep
from tests.fuzz.judge import judge
from tests.fuzz.mutate import LARGEST_BYTES, mutated

OWN_MUTATIONS = 0.5  #: Share of the mutations that know numbers, lines and JSON; the others are those of libFuzzer.


def main() -> None:
    """Run until the time or the number of inputs is reached."""
    name, seconds, inputs = sys.argv[1:4]
    target, known = targets()[name], set[str]()
    folder = Path(tempfile.mkdtemp(prefix="wpcal-fuzz-"))
    corpus = folder / "corpus"
    corpus.mkdir()
    for number, data in enumerate(target.seeds):
        (corpus / f"seed{number}").write_bytes(data)

    def one_input(data: bytes) -> None:
        fault = judge(target, data, folder).fault
        if fault and fault not in known:
            known.add(fault)
            print(f"    {fault}: kept as {keep(name, data)}", flush=True)

    def mutate(data: bytes, most: int, number: int) -> bytes:
        rng = random.Random(number)
        changed = mutated(data, target.seeds, rng) if rng.random() < OWN_MUTATIONS else atheris.Mutate(data, most)
        return bytes(changed[:most])

    limits = [f"-max_total_time={seconds}", f"-runs={inputs}", f"-max_len={LARGEST_BYTES}", "-rss_limit_mb=3000"]
    command = [sys.argv[0], *limits, "-verbosity=0", "-print_final_stats=1", str(corpus)]
    atheris.Setup(command, one_input, custom_mutator=mutate)
    atheris.Fuzz()


if __name__ == "__main__":
    main()
