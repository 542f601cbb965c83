# SPDX-License-Identifier: MIT
"""The objects of this workbench in a document, and how they come back when a document is opened.

All data are properties with plain text: a document that is opened without the workbench keeps them. Such a FreeCAD may
save the document without the Python objects behind them; `attach_proxies` puts them back.
"""

from __future__ import annotations

import json
from contextlib import contextmanager
from enum import Enum
from functools import lru_cache
from typing import Any, Iterator, Tuple

import FreeCAD

from ..words import translate

KIND = "WpCalKind"  #: The property that says which kind of object it is.
GROUP = "wpcal"  #: The group of the properties in the property editor.
HIDDEN = 2  #: Property mode: not shown. Records of thousands of characters are no use in the property editor.
READ_ONLY = 1  #: Property mode: shown, not edited there.

_Property = Tuple[str, str, str, int]  #: Type, name, description, mode.
_COMMON: tuple[_Property, ...] = (("App::PropertyString", KIND, "What this object is", HIDDEN),)


class Kind(Enum):
    """The kinds of objects: seams with features, taught points, a calibration."""

    SEAMS = "seams"
    TAUGHT = "taught"
    CALIBRATION = "calibration"


PROPERTIES: dict[Kind, tuple[_Property, ...]] = {
    Kind.SEAMS: (
        ("App::PropertyLinkListHidden", "Objects", "The objects that are welded; empty: the whole document", 0),
        ("App::PropertyPlacement", "PartFrame", "Where the coordinates of the part lie in the document", READ_ONLY),
        ("App::PropertyString", "PartHash", "Hash of the STEP data that the seams were found on", READ_ONLY),
        ("App::PropertyString", "Features", "Reference features (wpcal/features/1, JSON)", HIDDEN),
        ("App::PropertyString", "Seams", "Weld seams (wpcal/seams/1, JSON)", HIDDEN),
        ("App::PropertyString", "Edits", "Decisions about the seams (JSON)", HIDDEN),
        ("App::PropertyString", "SeamOptions", "Options of the search for seams (JSON)", HIDDEN),
    ),
    Kind.TAUGHT: (
        ("App::PropertyString", "Table", "Taught points, as the file that wpcal calibrate reads (JSON)", HIDDEN),
        ("App::PropertyString", "FitOptions", "Options of the fit (JSON)", HIDDEN),
    ),
    Kind.CALIBRATION: (
        ("App::PropertyString", "Verdict", "Verdict of the calibration", READ_ONLY),
        ("App::PropertyPlacement", "Pose", "Pose of the part in the robot's base (T_base_part)", READ_ONLY),
        ("App::PropertyPlacement", "PartFrame", "Where the coordinates of the part lie in the document", READ_ONLY),
        ("App::PropertyString", "ResultFolder", "The result folder", READ_ONLY),
        ("App::PropertyString", "Calibration", "The answer of calibrate, with the seams in the base (JSON)", HIDDEN),
        ("App::PropertyString", "Shown", "What is drawn of it (JSON)", HIDDEN),
    ),
}
NAMES = {Kind.SEAMS: "WpCalSeams", Kind.TAUGHT: "WpCalTaught", Kind.CALIBRATION: "WpCalCalibration"}


def _label(kind: Kind) -> str:
    labels = {Kind.SEAMS: "Weld seams", Kind.TAUGHT: "Taught points", Kind.CALIBRATION: "Calibration"}
    return translate(labels[kind])


class Record:
    """The Python object behind an object of a document. It has no data of its own."""

    def __init__(self, obj: Any) -> None:
        obj.Proxy = self

    def execute(self, obj: Any) -> None:
        """Compute nothing: what wpcal finds comes from its process, not from a recompute."""

    def onDocumentRestored(self, obj: Any) -> None:
        """Add the properties that an older version of the workbench did not have."""
        add_properties(obj, Kind(getattr(obj, KIND)))

    def dumps(self) -> None:
        """Save nothing (FreeCAD 1.0 and later)."""

    def loads(self, state: object) -> None:
        """Restore nothing (FreeCAD 1.0 and later)."""

    def __getstate__(self) -> None:
        """Save nothing (FreeCAD 0.20)."""

    def __setstate__(self, state: object) -> None:
        """Restore nothing (FreeCAD 0.20)."""


def add_properties(obj: Any, kind: Kind) -> None:
    """Add the properties of a kind that the object does not have yet."""
    for type_name, name, text, mode in (*_COMMON, *PROPERTIES[kind]):
        if name not in obj.PropertiesList:
            obj.addProperty(type_name, name, GROUP, text)
        obj.setEditorMode(name, mode)


def kind_of(obj: Any) -> Kind | None:
    """Return the kind of an object; None for any that is not of this workbench."""
    text = getattr(obj, KIND, None)
    return Kind(text) if text in [kind.value for kind in Kind] else None


def is_ours(obj: Any) -> bool:
    """Tell whether this workbench made an object: it is no part of the user's model."""
    return bool(getattr(obj, KIND, ""))


def objects_of(document: Any, kind: Kind) -> list[Any]:
    """Return the objects of a kind, in the order in which they were made."""
    return [obj for obj in document.Objects if kind_of(obj) is kind]


def object_of(document: Any, kind: Kind) -> Any | None:
    """Return the first object of a kind; None if the document has none."""
    return next(iter(objects_of(document, kind)), None)


def make_object(document: Any, kind: Kind) -> Any:
    """Add an object of a kind. Call it inside a `transaction`."""
    obj = document.addObject("App::FeaturePython", NAMES[kind])
    add_properties(obj, kind)
    setattr(obj, KIND, kind.value)
    obj.Label = _label(kind)
    attach_proxy(obj)
    return obj


def ensure_object(document: Any, kind: Kind) -> Any:
    """Return the object of a kind; make it if the document has none."""
    return object_of(document, kind) or make_object(document, kind)


def attach_proxy(obj: Any) -> None:
    """Give an object of this workbench its Python object, and with a window what draws it."""
    if not isinstance(getattr(obj, "Proxy", None), Record):
        Record(obj)
    if FreeCAD.GuiUp:
        from ..view.providers import attach_view

        attach_view(obj)


def attach_proxies(document: Any) -> None:
    """Give every object of this workbench in a document what a FreeCAD without the workbench may have dropped."""
    for obj in document.Objects:
        kind = kind_of(obj)
        if kind is not None:
            add_properties(obj, kind)
            attach_proxy(obj)


@lru_cache(maxsize=32)
def _parsed(text: str) -> Any:
    return json.loads(text)


def data_of(obj: Any, name: str) -> Any:
    """Return the JSON value of a property; None if it is empty or was damaged outside FreeCAD.

    The value is shared between all who ask: copy what is to be changed.
    """
    text = getattr(obj, name, "")
    try:
        return _parsed(text) if text else None
    except ValueError:
        FreeCAD.Console.PrintWarning(f"wpcal: {obj.Label}.{name} is not JSON; it is taken as empty\n")
        return None


def set_data(obj: Any, name: str, value: Any) -> None:
    """Set a property to a JSON value. Nothing is changed, and nothing has to be undone, if it says the same already."""
    text = "" if value is None else json.dumps(value, ensure_ascii=False, separators=(",", ":"))
    if getattr(obj, name) != text:
        setattr(obj, name, text)


@contextmanager
def transaction(document: Any, text: str) -> Iterator[None]:
    """Make all changes inside one step of Undo; a failure leaves the document as it was."""
    document.openTransaction(text)
    try:
        yield
    except BaseException:
        document.abortTransaction()
        raise
    document.commitTransaction()
