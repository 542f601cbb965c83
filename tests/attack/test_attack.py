"""The short form of `make attack`: a command without the kernel, so that many faults cost little."""

import random
import signal

import pytest

from tests.attack.__main__ import NEVER
from tests.attack.faults import Job, kill_at_random, write_twice
from tests.e2e.every_command import write_inputs
from tests.few import few


@pytest.fixture(scope="module")
def job(tmp_path_factory: pytest.TempPathFactory) -> Job:
    folder = tmp_path_factory.mktemp("attack")
    write_inputs(folder)
    rows = (folder / "touched.csv").read_text()
    (folder / "other.csv").write_text(rows.replace("700.0", "700.2"))
    return Job(
        folder,
        {"old": ["bases", "cell/two-mh6.json", "touched.csv"], "new": ["bases", "cell/two-mh6.json", "other.csv"]},
    )


@pytest.mark.parametrize("number", few([signal.SIGKILL, signal.SIGTERM], 1))
def test_killed_at_random_moments(job: Job, number: signal.Signals) -> None:
    assert not {*NEVER} & {*+kill_at_random(job, number, 3, random.Random(15))}


@pytest.mark.parametrize("force", few([True, False], 1))
def test_two_writers(job: Job, force: bool) -> None:
    found = write_twice(job, 1, force=force)
    assert not {*NEVER, "temporary folder left"} & {*+found}
