"""What is fuzzed: a reader as a function of bytes, with inputs that it accepts."""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

HERE = Path(__file__).parent
FIXTURES = HERE.parents[1] / "fixtures"


@dataclass(frozen=True, slots=True)
class Target:
    """A reader."""

    read: Callable[[bytes, Path], object]  #: Takes the bytes and a path to which it may write them.
    seeds: tuple[bytes, ...]  #: Inputs that it accepts.
    file: str = "input"  #: Name of the file; its end tells some readers what it is.


def seed(name: str) -> bytes:
    return (HERE / "seeds" / name).read_bytes()


def of_path(read: Callable[[Path], object]) -> Callable[[bytes, Path], object]:
    """Return a reader of files as a function of bytes."""

    def from_bytes(data: bytes, path: Path) -> object:
        path.write_bytes(data)
        return read(path)

    return from_bytes
