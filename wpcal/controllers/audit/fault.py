"""What an audit finds: faults with their places, per file."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from wpcal.core.errors import ErrorCode, FormatError, WpcalError, whole_text

AUDIT_SCHEMA = "wpcal/audit/1"


@dataclass(frozen=True, slots=True)
class Fault:
    """One fault of a file."""

    message: str  #: What is wrong and what was expected.
    line: int | None = None  #: Line in the file, counted from 1.
    column: str | int | None = None  #: Name of the column, or its place counted from 1.
    field: str | None = None  #: Place in a record, for example ``seam W1: point 3: p_mm[1]``, or a point of a program.
    code: str = ErrorCode.FORMAT  #: The cause, for programs: an `ErrorCode`.
    repair: str | None = None  #: What a repair writes instead; None if a person must decide.

    def __post_init__(self) -> None:
        for name in ("message", "field", "column"):
            text = getattr(self, name)
            if isinstance(text, str):  # it may quote a file that holds what cannot be written
                object.__setattr__(self, name, whole_text(text))

    @classmethod
    def of(cls, error: WpcalError, path: str) -> Fault:
        """Take the place and the cause from an error of a reader."""
        if isinstance(error, FormatError):
            of = f"{error.path}: " if error.path and error.path != path else ""  # a file beside it
            return cls(f"{of}{error.what}", error.line, error.column, code=error.code)
        return cls(str(error).removeprefix(f"{path}: "), code=error.code)

    @property
    def place(self) -> str:
        """The place in words; empty for a fault of the whole file."""
        line = None if self.line is None else f"line {self.line}"
        column = None if self.column is None else f"column {self.column}"
        return ", ".join(part for part in (line, column, self.field) if part)

    def to_record(self) -> dict[str, Any]:
        """Return the fault as an entry of the record of an audit."""
        return {
            "line": self.line,
            "column": self.column,
            "field": self.field,
            "message": self.message,
            "code": str(self.code),
            "repair": self.repair,
        }


@dataclass(frozen=True, slots=True)
class FileAudit:
    """What an audit says of one file."""

    path: str  #: As the user named it, or in the folder that the user named.
    kind: str  #: What the file is, in words.
    faults: tuple[Fault, ...] = ()
    checked: str = ""  #: What was checked, where that is not clear from the kind.

    def to_record(self) -> dict[str, Any]:
        """Return the entry of the record of an audit."""
        faults = [fault.to_record() for fault in self.faults]
        return {"path": self.path, "kind": self.kind, "checked": self.checked, "faults": faults}


@dataclass(frozen=True, slots=True)
class AuditReport:
    """The audit of a file or of a folder."""

    files: tuple[FileAudit, ...]  #: The files of known kinds.
    not_audited: tuple[str, ...] = ()  #: Files of other kinds.

    @property
    def fault_count(self) -> int:
        """Number of faults of all files."""
        return sum(len(file.faults) for file in self.files)

    def to_record(self) -> dict[str, Any]:
        """Return the record ``wpcal/audit/1``."""
        return {
            "schema": AUDIT_SCHEMA,
            "faults": self.fault_count,
            "files": [file.to_record() for file in self.files],
            "not_audited": list(self.not_audited),
        }
