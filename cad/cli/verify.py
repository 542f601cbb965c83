"""`wpcal verify`: whether results are still what they say."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import asdict, dataclass, field
from enum import Enum
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from cad.cli.batch import MOST_AT_ONCE
from cad.cli.options import MESH, PART, no_cache_option
from wpcal.cli.outputs import print_json
from wpcal.cli.shared_help import JSON_HELP, path_argument, path_option
from wpcal.core.result_files import CALIBRATION_FILE, JOB_FILE, SUMMARY_FILE

if TYPE_CHECKING:
    from cad.batch.inputs_now import InputsNow
    from cad.batch.recorded import Claim
    from cad.batch.run import Task
    from wpcal.core.errors import WpcalError

DIGITS = "all digits"  #: How results are compared that the same versions wrote.
MOST_SHOWN = 10  #: Differences of one folder that the terminal lists; --json lists all that were found.
MAY_DIFFER = (
    "summary.jsonl and summary.csv: seconds, when, line, and the error of a job that failed",
    "files that wpcal calibrate and wpcal batch do not write",
)
"""What is not checked: it cannot be computed from the inputs."""


class State(Enum):
    """What became of a check."""

    AS_CLAIMED = "as claimed"
    DIFFERENT = "different"
    NOT_CHECKED = "cannot be checked"


CODES = {State.AS_CLAIMED: 0, State.DIFFERENT: 1, State.NOT_CHECKED: 2}


@dataclass(slots=True)
class Checked:
    """One folder, or the summary of a batch."""

    name: str
    state: State = State.AS_CLAIMED
    version: str | None = None
    differences: list[dict[str, str]] = field(default_factory=list)
    error: str | None = None
    unchecked: list[str] = field(default_factory=list)
    #: How it was compared: all digits, or numbers, if other versions of some programs wrote it; None if it was not.
    compared: str | None = None

    def differs(self, differences: list[dict[str, str]]) -> None:
        """Note what differs; nothing if the list is empty."""
        self.differences += differences
        self.state = State.DIFFERENT if self.differences else self.state

    def takes(self, found: dict[str, list[Any]]) -> None:
        """Note what `cad.batch.recorded.check_claim` found."""
        self.differs(found["differences"])
        if "versions" in found:
            theirs, ours = (", ".join(f"{each[0]} {each[at]}" for each in found["versions"]) for at in (1, 2))
            within = f"numbers, to 1e-5 mm: written by {theirs}, this is {ours}"
            self.compared = within if theirs else DIGITS
        self.unchecked += [
            f"{name} (other bytes; only numbers of the records are compared)" for name in found["unchecked"]
        ]

    def fails(self, error: str) -> None:
        """Note why it cannot be checked."""
        self.state, self.error = State.NOT_CHECKED, error

    def sentences(self) -> Iterator[str]:
        """Yield what a person is told of it, one line each."""
        if self.compared not in (None, DIGITS):
            yield f"note: {self.name}: compared are {self.compared}"
        if self.error is not None:
            yield f"{self.name}: cannot be checked: {self.error}"
        for one in self.differences[:MOST_SHOWN]:
            off = f" ({one['off_by']})" if one["off_by"] else ""
            yield f"{self.name}: {one['where']} is {one['found']}, expected {one['expected']}{off}"
        if len(self.differences) > MOST_SHOWN:
            yield f"{self.name}: and {len(self.differences) - MOST_SHOWN} more"
        if self.unchecked:
            yield f"note: {self.name}: not checked: {', '.join(self.unchecked)}"

    def to_record(self) -> dict[str, Any]:
        """Return it as an entry of the record."""
        return {**asdict(self), "state": self.state.value}


@click.command()
@path_argument("out", metavar="OUT")
@path_option(
    "--inputs",
    "given",
    metavar="PATH",
    multiple=True,
    help="Where inputs are now: a file, or a folder with files. May be given more than once.",
)
@click.option(
    "-j",
    "--jobs",
    "at_once",
    type=click.IntRange(min=1, max=MOST_AT_ONCE),
    help="Processes at the same time (of a batch).  [default: one per processor]",
)
@click.option("--json", "as_json", is_flag=True, help=f"{JSON_HELP}: what differs.")
@no_cache_option
def verify(*, out: Path, given: tuple[Path, ...], at_once: int | None, as_json: bool, no_cache: bool) -> int:
    """Check that OUT is still what its inputs give.

    OUT is a folder of `wpcal calibrate` or of `wpcal batch`. The request in job.json is done once more with the same
    inputs, into a temporary folder, and all bytes are compared: pose, residuals, bound, seam frames, the moved STEP
    file, the triangles and the page. If another version of wpcal wrote OUT, its hashes are checked, and its poses,
    residuals, bound and seam frames are compared to 1e-5 mm. If another version of NumPy or SciPy did, so are all
    numbers of the records. It is said which.

    Inputs are looked for in the current folder and in those around OUT. They are accepted by their SHA-256. Results
    of a script have no job.json: they are compared with what the usual options give, and with one another.

    Ends with code 0 if OUT is as claimed, 1 if anything differs, and 2 if it cannot be checked.
    """
    import tempfile

    from cad.batch.inputs_now import OPTION, InputsNow
    from wpcal.core.errors import InputError
    from wpcal.core.input_file import require_folder

    require_folder(out, "the results of wpcal calibrate or wpcal batch")
    if not any((out / name).exists() for name in (SUMMARY_FILE, JOB_FILE, CALIBRATION_FILE)):
        raise InputError(f"{out}: holds no results of wpcal calibrate or wpcal batch")
    for path in given:
        if not path.exists():
            raise InputError(f"{OPTION} {path}: no such file or folder")
    whole = out.resolve()
    with tempfile.TemporaryDirectory() as temporary:
        folders = (Path.cwd(), whole.parent, whole, whole.parent.parent)
        inputs = InputsNow(given, folders, Path(temporary, "inputs"))
        if (out / SUMMARY_FILE).exists():
            found = _check_batch(whole, inputs, Path(temporary), at_once, use_cache=not no_cache)
        else:
            found = [_check_one(whole, inputs, use_cache=not no_cache)]
    _show(out, found, as_json=as_json)
    states = {each.state for each in found}
    worst = next(s for s in (State.DIFFERENT, State.NOT_CHECKED, State.AS_CLAIMED) if s in states)
    return CODES[worst]


def _check_one(folder: Path, inputs: InputsNow, *, use_cache: bool) -> Checked:
    import os

    from cad.cli.kernel_work import run_on_part
    from wpcal.core.errors import WpcalError

    checked = Checked(folder.name)
    has_request = os.path.lexists(folder / JOB_FILE)
    claim = _claim_of(folder, inputs, checked) if has_request else _guessed(folder, inputs)
    found: dict[str, list[Any]] = {"differences": [], "unchecked": []}
    if claim is not None:
        try:
            found = run_on_part(
                "cad.batch.recorded:check_claim",
                claim.now.part,
                {"claim": claim},
                what=f"checking {folder}",
                use_cache=use_cache,
                needs=(PART, MESH),
            )
        except WpcalError as error:
            checked.fails(str(error))
    if has_request:
        checked.takes(found)
    elif claim is None or found["differences"] or checked.error is not None:
        _check_agreement(folder, checked, found["differences"])
    return checked


def _guessed(folder: Path, inputs: InputsNow) -> Claim | None:
    """Return the claim of a folder without a request that nothing unusual was asked for; None without its inputs."""
    from cad.batch.agreement import usual_inputs
    from cad.batch.recorded import Claim
    from cad.cli.kernel_work import FROM_STDIN
    from wpcal.core.errors import InputError
    from wpcal.core.version import __version__

    asked = usual_inputs(folder)
    if asked is None:
        return None
    try:
        now = inputs.find(asked, name_of_stdin=FROM_STDIN)
    except InputError:
        return None
    record = {"wpcal": __version__, "inputs": asked.to_record(), "files": {}}
    return Claim(folder, record, now, is_asked=False)


def _check_agreement(folder: Path, checked: Checked, unusual: list[dict[str, str]]) -> None:
    """Check the files of a folder without a request against one another, and say what that leaves open."""
    from cad.batch.agreement import disagreements

    differences = [each.to_record() for each in disagreements(folder)]
    if differences:
        checked.error = None
        checked.differs(differences)
        return
    if unusual:
        first = unusual[0]
        other = f"the usual options give others (for {first['where']} {first['expected']} instead of {first['found']})"
    else:
        other = f"nothing says from what they were made ({checked.error or 'the part or the points are not found'})"
    checked.fails(f"holds no {JOB_FILE}, as results of a script. Its files agree with one another; {other}")


def _claim_of(folder: Path, inputs: InputsNow, checked: Checked) -> Claim | None:
    """Return what a folder claims; None if that is known to be wrong or cannot be checked, which is noted."""
    from cad.batch.job_record import JobInputs, read_job_record
    from cad.batch.recorded import Claim
    from cad.cli.kernel_work import FROM_STDIN
    from wpcal.core.errors import InputError

    if not folder.is_dir():
        checked.differs([_difference(folder.name, "missing", "a folder")])
        return None
    record = read_job_record(folder)
    if record is None:
        if (folder / JOB_FILE).exists():
            checked.differs([_difference(JOB_FILE, "not a record of wpcal/job/1", "as it was written")])
        else:
            checked.differs([_difference(JOB_FILE, "missing", "there")])
        return None
    checked.version = str(record["wpcal"])
    known = {JOB_FILE, *record["files"]}
    checked.unchecked = sorted(path.name for path in folder.iterdir() if path.name not in known)
    asked = JobInputs.from_record(record["inputs"])
    try:
        return Claim(folder, record, inputs.find(asked, name_of_stdin=FROM_STDIN))
    except InputError as error:
        _not_found(folder, asked, error, checked)
        return None


def _not_found(folder: Path, asked: Any, error: WpcalError, checked: Checked) -> None:
    """Note that an input is not found by its hash: either it was changed, or the hash in job.json was."""
    from wpcal.core.errors import InputError
    from wpcal.results.folder import read_record

    try:
        stated = read_record(folder, CALIBRATION_FILE)["inputs"]["part"]["sha256"]
    except (InputError, KeyError, TypeError):
        stated = None
    if stated is not None and stated != asked.part[1]:
        checked.differs([_difference("job.json inputs part sha256", asked.part[1], stated)])
        return
    checked.fails(str(error))


def _difference(where: str, found: str, expected: str) -> dict[str, str]:
    from wpcal.results.differences import Difference

    return Difference(where, found, expected).to_record()


def _check_batch(out: Path, inputs: InputsNow, work: Path, at_once: int | None, *, use_cache: bool) -> list[Checked]:
    from cad.batch.summary import FAILED
    from cad.batch.summary_check import check_summary, read_summary
    from wpcal.cli.progress import counted_progress
    from wpcal.core.errors import FormatError

    summary = Checked(SUMMARY_FILE)
    try:
        lines = read_summary(out)
    except FormatError as error:
        summary.differs([_difference(SUMMARY_FILE, str(error), "as it was written")])
        return [summary]
    found = {line["job"]: Checked(line["job"]) for line in lines if line["verdict"] != FAILED}
    with counted_progress("reading the summary") as progress:
        tasks: list[Task] = []
        requests: dict[Any, Any] = {}
        for number, checked in enumerate(found.values()):
            progress("looking for the inputs of jobs", number, len(found))
            claim = _claim_of(out / checked.name, inputs, checked)
            if claim is not None:
                _add_task(number, claim, tasks, requests, work, use_cache=use_cache)
        _run(tasks, requests, list(found.values()), work, at_once, progress)
    summary.differs([each.to_record() for each in check_summary(out, lines)])
    return [summary, *found.values()]


def _add_task(
    number: int, claim: Claim, tasks: list[Task], requests: dict[Any, Any], work: Path, *, use_cache: bool
) -> None:
    from cad.batch.jobs import option_columns
    from cad.batch.run import Task
    from cad.work.child import DEFAULT_MEMORY_GB, DEFAULT_TIMEOUT_S
    from cad.work.group import GroupRequest

    of_part = {column.flag for column in option_columns().values() if column.shapes_part}
    shaping = tuple(word for word in claim.now.words if word.partition("=")[0] in of_part)
    group = (claim.now.part.name, claim.record["inputs"]["part"]["sha256"], shaping)
    if group not in requests:
        requests[group] = GroupRequest(
            "cad.batch.jobs:open_part",
            "cad.batch.recorded:check_job",
            {"part": str(claim.now.part.resolve()), "words": shaping, "use_cache": use_cache},
            Path.cwd(),
            work / "out",
            DEFAULT_TIMEOUT_S,
            DEFAULT_MEMORY_GB,
        )
    tasks.append(Task(number, group, {"claim": claim}))


def _run(
    tasks: list[Task], requests: dict[Any, Any], checked: list[Checked], work: Path, at_once: int | None, progress: Any
) -> None:
    import os
    from dataclasses import replace

    from cad.batch.jobs import PRELOADED
    from cad.batch.run import locked_output, run_tasks
    from cad.work.host import Failure, Host

    if not tasks:
        return
    done = 0

    def take(task: Task, value: Any) -> None:
        nonlocal done
        done += 1
        progress("checking jobs", done, len(tasks))
        if isinstance(value, Failure):
            checked[task.number].fails(value.message)
        else:
            checked[task.number].takes(value)

    progress("starting the CAD kernel", 0, len(tasks))
    with locked_output(work / "out", overwrite=False) as (lock, unfinished):
        mine = {group: replace(request, work=unfinished) for group, request in requests.items()}
        host = Host(unfinished, lock, (*PRELOADED, "cad.batch.recorded"))
        try:
            run_tasks(tasks, mine, host, at_once=at_once or os.cpu_count() or 1, done=take)
        finally:
            host.end()


def _show(out: Path, found: list[Checked], *, as_json: bool) -> None:
    from wpcal.cli.console import plain_console
    from wpcal.core.version import __version__

    if as_json:
        record = {
            "schema": "wpcal/verify/1",
            "wpcal": __version__,
            "checked": [each.to_record() for each in found],
            "not_checked": list(MAY_DIFFER),
        }
        print_json(record)
        return
    say = partial(plain_console().print, soft_wrap=True)
    for each in found:
        for sentence in each.sentences():
            say(sentence)
    counts = {state: sum(each.state is state for each in found) for state in State}
    if len(found) == 1:
        say(f"{out}: {found[0].state.value}")
    else:
        say(f"{out}: {', '.join(f'{count} {state.value}' for state, count in counts.items() if count)}")
