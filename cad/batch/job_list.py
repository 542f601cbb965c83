"""The list of the jobs of a batch: a table with the columns job, part and taught, and any option of a calibration."""

from __future__ import annotations

import unicodedata
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from difflib import get_close_matches
from pathlib import Path

from wpcal.core.cells import number_in_cell
from wpcal.core.errors import FormatError, InputError
from wpcal.core.numbers import NUMBER
from wpcal.core.result_files import SUMMARY_FILE, SUMMARY_TABLE
from wpcal.core.tables import read_table
from wpcal.core.wording import listed, shown

JOB, PART, TAUGHT, WHEN = "job", "part", "taught", "when"
"""Columns: the name of the job and of its folder, its files, and when its points were touched."""
REQUIRED = (JOB, PART, TAUGHT)
LONGEST_NAME = 200  #: Bytes of a job's name: file systems allow 255.
NO_NAMES = frozenset({"con", "prn", "aux", "nul", *(f"{port}{k}" for port in ("com", "lpt") for k in range(1, 10))})
"""Names that Windows keeps for devices: a folder of results is copied from one system to another."""
NOT_IN_NAMES = frozenset('/\\:*?"<>|')
OWN_NAMES = frozenset({SUMMARY_FILE, SUMMARY_TABLE})  #: Files that a batch writes beside the folders.
OF_THE_BATCH = {
    "out": "every job is written to OUT/JOB, and OUT is the option --out of wpcal batch",
    "force": "results are kept; --resume of wpcal batch replaces what has other inputs",
    "details": "a batch prints no tables of its jobs",
    "json": "it is an option of wpcal batch",
    "no_cache": "it is an option of wpcal batch",
}
"""Options of `wpcal calibrate` that are not those of a row, and why."""
YES, NO = frozenset({"yes", "true", "1", "x"}), frozenset({"no", "false", "0"})
BETWEEN = ";"  #: Between the values of an option that may be given more than once.


@dataclass(frozen=True, slots=True)
class OptionColumn:
    """An option that a column may hold."""

    flag: str  #: As it is typed: ``--sigma-mm``.
    is_flag: bool = False  #: It takes no value: the cell is yes or no.
    is_optional: bool = False  #: It may be given without its value: the cell may also be yes.
    is_multiple: bool = False  #: It may be given more than once: the cell may hold values between semicolons.
    is_number: bool = False  #: Its value is one number: the cell may hold it as people type numbers into a spreadsheet.
    #: It changes the seams of the part: jobs that differ in it do not share what is found in the part.
    shapes_part: bool = False


@dataclass(frozen=True, slots=True)
class Job:
    """One row of the list."""

    number: int  #: Counted from 0.
    line: int  #: Line in the list, counted from 1.
    name: str  #: Name of the job and of its folder.
    #: `part`, `taught`: Its files as the list names them.
    part: str
    taught: str
    when: str = ""  #: When its points were touched, as the list says; empty if it does not.
    #: Flags and cells of its options, in the order of the columns, without empty cells.
    cells: tuple[tuple[str, str], ...] = ()
    fault: str = ""  #: Why it cannot be run; empty if it can.

    def require_sound(self) -> None:
        """Refuse a row that cannot be run. Raises `InputError` with its fault."""
        if self.fault:
            raise InputError(self.fault)


def read_jobs(
    path: Path, options: Mapping[str, OptionColumn], usual: Mapping[str, str] | None = None
) -> tuple[Job, ...]:
    """Read the list of jobs.

    `usual`: Cells of options for rows that have none, by flag: what the shop says.
    `options`: What columns besides job, part, taught and when may be called: the long flags without the dashes in
    front, with underscores (``sigma_mm``).
    Raises `InputError` when the file cannot be opened.
    Raises `FormatError` when it is not a table, has no rows, lacks a column, or has one that is not an option of a
    calibration.
    """
    table = read_table(path)
    table.require(REQUIRED)
    columns = {name: _option_of(name, options, str(path)) for name in table.columns if name not in (*REQUIRED, WHEN)}
    decimal = table.decimal_sign([name for name, option in columns.items() if option.is_number])
    whens = table.columns.get(WHEN, [""] * len(table))
    first: dict[str, int] = {}
    jobs = []
    for row, line in enumerate(table.lines):
        name, part, taught = (table.columns[column][row] for column in REQUIRED)
        cells = tuple(
            (option.flag, _as_typed(table.columns[column][row], column, option, decimal))
            for column, option in columns.items()
        )
        fault = _fault_of(name, part, taught, first)
        first.setdefault(_folded(name), line)
        given = tuple({**(usual or {}), **{flag: cell for flag, cell in cells if cell}}.items())
        jobs.append(Job(row, line, name or f"(line {line})", part, taught, whens[row], given, fault))
    return tuple(jobs)


def words_of(cells: Sequence[tuple[str, str]], options: Mapping[str, OptionColumn]) -> tuple[str, ...]:
    """Return the options of a row as they are typed.

    Raises `InputError` when the cell of an option without a value is neither yes nor no.
    """
    by_flag = {option.flag: option for option in options.values()}
    words: list[str] = []
    for flag, cell in cells:
        option, low = by_flag[flag], cell.lower()
        if option.is_flag or (option.is_optional and low in YES | NO):
            if low not in YES | NO:
                raise InputError(f"{flag}: expected yes or no, got {shown(cell)}")
            words += [flag] if low in YES else []
        elif option.is_multiple:
            words += [f"{flag}={value.strip()}" for value in cell.split(BETWEEN) if value.strip()]
        else:
            words.append(f"{flag}={cell}")
    return tuple(words)


def _as_typed(cell: str, column: str, option: OptionColumn, decimal: str) -> str:
    """Return a cell as its option takes it: a number with a decimal point and without its unit."""
    if not option.is_number or NUMBER.fullmatch(cell):
        return cell
    try:
        return repr(number_in_cell(cell, column=column, decimal=decimal))
    except InputError:
        return cell  # the option says what is wrong when the job runs


def _option_of(name: str, options: Mapping[str, OptionColumn], path: str) -> OptionColumn:
    """Return the option that a column is about; its name may be typed as the flag is."""
    key = name.lstrip("-").replace("-", "_")
    if key in options:
        return options[key]
    if key in OF_THE_BATCH:
        raise FormatError(f"column {shown(name)}: {OF_THE_BATCH[key]}; delete the column", path=path, line=1)
    near = get_close_matches(key, [*REQUIRED, WHEN, *options], n=1, cutoff=0.6)
    hint = f"did you mean {near[0]}?" if near else f"expected job, part, taught, when or options: {listed(options)}"
    raise FormatError(
        f"column {shown(name)} is not an option of wpcal calibrate that a job can have; {hint}", path=path
    )


def _folded(name: str) -> str:
    """Return a name as file systems compare it that do not tell large from small letters."""
    return unicodedata.normalize("NFC", name).casefold()


def _fault_of(name: str, part: str, taught: str, first: Mapping[str, int]) -> str:
    unsafe = _unsafe(name)
    if unsafe:
        return f"the name of a job is the name of its folder: {unsafe}"
    if _folded(name) in first:
        return f"the name {shown(name)} appears twice, first in line {first[_folded(name)]}; every job needs its own"
    for column, cell in ((PART, part), (TAUGHT, taught)):
        if not cell:
            return f"the column {column} is empty; expected the name of a file"
        if cell == "-":
            return f"the column {column}: standard input cannot be used in a batch; expected the name of a file"
    return ""


def _unsafe(name: str) -> str:
    """Say why a name cannot be that of a folder; empty if it can."""
    if not name:
        return "it is empty"
    bad = sorted(letter for letter in set(name) if letter in NOT_IN_NAMES or not letter.isprintable())
    if bad:
        return f"{shown(name)} holds {', '.join(map(ascii, bad))}"
    if name[0] in ".-~" or name[-1] in ". ":
        return f"{shown(name)} begins with a point, a minus or ~, or ends with a point"
    size = len(name.encode("utf-8", errors="replace"))
    if size > LONGEST_NAME:
        return f"{shown(name)} has {size} bytes, expected at most {LONGEST_NAME}"
    is_device, is_own = name.casefold().partition(".")[0] in NO_NAMES, name.casefold() in OWN_NAMES
    if is_device or is_own:
        return f"{shown(name)} is the name of a {'device in Windows' if is_device else 'file that the batch writes'}"
    return ""
