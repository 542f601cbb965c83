"""Give one input to a reader, and say what is wrong with what the reader does."""

import signal
import time
import traceback
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from types import FrameType

from tests.fuzz.target import Target
from wpcal.core.errors import LONGEST_MESSAGE, InputError

MOST_SECONDS = 10.0  #: Processor time for one input. The inputs are at most 0.4 MB.
MOST_CHARACTERS = LONGEST_MESSAGE + 1000  #: Of a message: the longest, and the name of a file before it.


class TooSlowError(BaseException):
    """A reader took longer than `MOST_SECONDS`. Not an `Exception`, so that no reader catches it."""


@dataclass(frozen=True, slots=True)
class Judged:
    """What a reader did."""

    fault: str  #: What is wrong with it; empty if nothing is.
    was_read: bool  #: The reader accepted the input.
    seconds: float


def judge(target: Target, data: bytes, folder: Path) -> Judged:
    """Let a reader read an input. It may return, or raise an `InputError`.

    `folder`: For the file that the reader opens.
    """
    fault, was_read = "", False
    start = time.process_time()
    try:
        with warnings.catch_warnings(), _limited():
            warnings.simplefilter("error")
            target.read(data, folder / target.file)
            was_read = True
    except InputError as error:
        what = _fault_of_message(str(error))
        fault = what and f"{what} in {_place(error)}"
    except (Exception, TooSlowError) as error:  # what this searches for
        fault = f"{type(error).__name__} in {_place(error)}"
    return Judged(fault, was_read, time.process_time() - start)


def _place(error: BaseException) -> str:
    """Return the last function of wpcal on the way to an error, and the last of all."""
    ways = traceback.extract_tb(error.__traceback__)
    ours = [step for step in ways if "/wpcal/" in step.filename or "/cad/" in step.filename] or ways
    return " < ".join(dict.fromkeys(f"{Path(step.filename).name}:{step.name}" for step in (ways[-1], ours[-1])))


def _fault_of_message(message: str) -> str:
    if len(message) > MOST_CHARACTERS:
        return "a very long message"
    try:
        message.encode("utf-8")
    except UnicodeEncodeError:
        return "a message with half of a surrogate pair"
    return ""


@contextmanager
def _limited() -> Iterator[None]:
    def stop(_signal: int, _frame: FrameType | None) -> None:
        raise TooSlowError(f"more than {MOST_SECONDS:g} s")

    before = signal.signal(signal.SIGVTALRM, stop)
    signal.setitimer(signal.ITIMER_VIRTUAL, MOST_SECONDS)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_VIRTUAL, 0)
        signal.signal(signal.SIGVTALRM, before)
