"""Open a STEP file as text, and refuse what can be refused without the kernel, in one line."""

from codecs import BOM_UTF8
from dataclasses import replace
from pathlib import Path

from cad.step.part21 import Part21File, index_part21
from wpcal.core.errors import FormatError, InputError
from wpcal.core.input_file import MOST_STEP_MB, read_bytes

SIGNATURES = (
    (b"version https://git-lfs", "a Git LFS pointer, not the file itself: fetch it with git lfs pull"),
    (b"%PDF", "a PDF"),
    (b"PK\x03\x04", "a zip archive: unpack it first"),
    (b"\x1f\x8b", "a gzip archive: unpack it first"),
    (b"7z\xbc\xaf\x27\x1c", "a 7-Zip archive: unpack it first"),
    (b"\x89PNG", "a PNG picture"),
    (b"\xff\xd8\xff", "a JPEG picture"),
    (b"\x89HDF", "an HDF5 file; STEP is read as text (ISO 10303-21)"),
    (b"\xd0\xcf\x11\xe0", "an OLE file, as native CAD formats and old office documents are"),
    (b"glTF", "a glTF mesh"),
    (b"solid ", "an STL mesh"),
    (b"<?xml", "XML; STEP is read as text (ISO 10303-21)"),
    (b"<!DOCTYPE html", "an HTML page"),
    (b"<html", "an HTML page"),
)
"""Files that people pass by mistake, by their first bytes."""

IGES_MARK, IGES_MARK_COLUMN = b"S      1", 72
"""The first line of an IGES file ends with the mark of its start section."""
START_MARK = b"ISO-10303-21"
START_SEARCH_BYTES = 1024  #: The mark is the first word. Only a byte order mark, blanks or a comment may precede it.


def require_step_file(path: Path) -> None:
    """Refuse by its first bytes what cannot be a STEP file. Costs no more than opening the file.

    Raises `InputError` if there is no such file, or it is a folder, empty or not readable.
    Raises `FormatError` if it is not ISO 10303-21 text.
    """
    _require_step_start(_read(path, first=START_SEARCH_BYTES), path)


def read_step_text(path: Path, *, data: bytes | None = None) -> Part21File:
    """Read and index the text of a STEP file.

    Raises `InputError` if there is no such file, or it is a folder, empty or not readable.
    Raises `FormatError` if it is not ISO 10303-21 text, or is cut off.
    """
    text = _read(path) if data is None else data
    _require_step_start(text, path)
    mark = BOM_UTF8 if text.startswith(BOM_UTF8) else b""
    file = index_part21(text.removeprefix(mark), name=str(path))
    if not len(file.ids):
        raise FormatError("the data section is empty", path=str(path))
    # messages about it go into results, which must not depend on the folder
    return replace(file, name=path.name, byte_order_mark=mark)


def _read(path: Path, *, first: int | None = None) -> bytes:
    return read_bytes(path, most_mb=MOST_STEP_MB, first=first, expected="a STEP file")


def _require_step_start(text: bytes, path: Path) -> None:
    """Check the first bytes of a file, or all of them."""
    if not text.strip():
        raise InputError(f"{path}: is empty, expected a STEP file")
    what = _other_kind(text)
    if what is None and START_MARK not in text[:START_SEARCH_BYTES]:
        what = "not STEP text"
    if what is not None:
        how = "" if ":" in what else "; save the part as STEP in the CAD program"
        raise FormatError(f"is {what}; expected a STEP file (ISO-10303-21){how}", path=str(path))


def _other_kind(text: bytes) -> str | None:
    """Say what a file is that is no STEP file by its first bytes; an archive may contain the mark of STEP files."""
    if text[IGES_MARK_COLUMN : IGES_MARK_COLUMN + len(IGES_MARK)] == IGES_MARK:
        return "an IGES file"
    for signature, what in SIGNATURES:
        if text[: len(signature)].lower() == signature.lower():
            return what
    return None
