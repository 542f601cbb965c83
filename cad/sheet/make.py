"""`make_sheet`: the main function of this package, from a STEP file to the bytes of a teach sheet."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from cad.draw.reproducible import reproducible
from cad.sheet.paper import A3, Paper, SheetLayout, lay_out, scale_words
from cad.sheet.touches import DrawnTouch, SheetTouch, drawn_touches, face_at
from cad.sheet.welds import ListedWeld
from cad.workpiece.answer_cache import NO_CACHE, AnswerCache
from cad.workpiece.workpiece import Openable, Workpiece, open_workpiece
from wpcal.core.errors import ErrorCode, GeometryError, InputError
from wpcal.core.progress import Progress, no_progress
from wpcal.core.version import __version__
from wpcal.core.wording import counted
from wpcal.taught.features import ReferenceFeature, feature_named

SHEET_SUFFIXES = (".pdf", ".svg", ".dxf", ".png")
SHEET_SCHEMA = "wpcal/sheet/1"


@dataclass(frozen=True, slots=True)
class SheetOptions:
    """What is on a sheet."""

    suffix: str  #: One of `SHEET_SUFFIXES`.
    paper: Paper = A3
    names: tuple[str, ...] = ()  #: Features to touch, in this order. If empty, `cad.workpiece.advise` chooses them.
    count: int = 4  #: How many features to choose if `names` is empty.
    touches: tuple[SheetTouch, ...] = ()  #: Touches on faces and edges, in place of features.
    welds: tuple[ListedWeld, ...] = ()  #: Welds to list, in place of points to touch.


@dataclass(frozen=True, slots=True, eq=False)
class Sheet:
    """A finished sheet."""

    data: bytes  #: The file.
    #: What is on the sheet: part, paper, scale, and points or welds; and what is odd in the part's file.
    record: dict[str, Any]


def make_sheet(
    step: Openable, *, options: SheetOptions, cache: AnswerCache = NO_CACHE, progress: Progress = no_progress
) -> Sheet:
    """Draw a part in four views with the reference points to touch, or its welds, and a table to fill in.

    A list of welds has as many pages as it needs; a sheet of points has one.

    Raises `InputError` when the part cannot be read, has no feature of a given name, or the rows are too many for the
    paper.
    Raises `GeometryError` when no points are named and none can be advised.
    Raises `KernelError` when the kernel fails.
    """
    from cad.sheet.fonts import require_font
    from cad.sheet.render import render
    from cad.sheet.views import part_lines, project_views

    require_font()
    paper = options.paper
    workpiece = open_workpiece(step, cache=cache, progress=progress)
    rows, points = _asked(workpiece, options, progress)
    most, what = paper.most_points, "weld" if options.welds else "point"
    _require_room(options, len(rows), what)
    progress(f"projecting the views: {workpiece.size}")
    places = np.array([point["p_mm"] for point in points])
    lines = part_lines(workpiece)
    progress(f"drawing the sheet: {counted(len(rows), what)}")
    title = _title(workpiece)
    documents = []
    with reproducible():
        for first in range(0, len(rows), most):
            views = project_views(workpiece.graph, lines, places[first : first + most])
            shown = rows[first : first + most]
            layout = lay_out(paper, views, len(shown))
            documents.append(_drawn(layout, shown, title, is_of_welds=bool(options.welds)))
        data = render(documents, paper, options.suffix)
    record = {
        "schema": SHEET_SCHEMA,
        "part": {"file": title.file, "sha256": title.sha256},
        "paper": paper.name,
        "scale": scale_words(layout.places[0].scale),
        "points": [] if options.welds else points,
        **({"welds": points} if options.welds else {}),
        "issues": [issue.to_record() for issue in workpiece.issues],
    }
    return Sheet(data, record)


def _require_room(options: SheetOptions, rows: int, what: str) -> None:
    """Refuse more rows than the paper has; a list of welds as PDF has pages."""
    most = options.paper.most_points
    if rows > most and not (options.welds and options.suffix == ".pdf"):
        pages = "; .pdf has pages" if options.welds else ""
        raise InputError(f"{options.paper.name} has room for {most} {what}s, got {rows}{pages}")


def _drawn(layout: SheetLayout, rows: list[Any], title: Any, *, is_of_welds: bool) -> Any:
    from cad.sheet.draw import Pen, draw_views
    from cad.sheet.table import POINTS, WELDS, draw_table, draw_title

    document = _new_document()
    pen = Pen(document.modelspace(), layout.paper)
    pen.box(layout.paper.frame, "BORDER")
    draw_views(pen, layout, rows)
    draw_table(pen, layout.table, WELDS if is_of_welds else POINTS, rows)
    draw_title(pen, layout, title)
    return document


def _asked(workpiece: Workpiece, options: SheetOptions, progress: Progress) -> tuple[list[Any], list[dict[str, Any]]]:
    """Return what is drawn: the rows of the table, and the same points or welds as the record holds them."""
    if options.welds:
        for one in options.welds:
            face_at(workpiece, one.place.middle_mm, None, what=f"weld {one.name}")
        welds = [{"number": k, **one.to_record()} for k, one in enumerate(options.welds, 1)]
        return [one.row(k) for k, one in enumerate(options.welds, 1)], welds
    if options.touches:
        touches = drawn_touches(options.touches, workpiece)
        return _touch_rows(touches), [{"number": k, **one.to_record()} for k, one in enumerate(touches, 1)]
    features = _features(workpiece, options, progress)
    return _rows(features), [{"number": k, **one.to_record()} for k, one in enumerate(features, 1)]


def _features(workpiece: Workpiece, options: SheetOptions, progress: Progress) -> tuple[ReferenceFeature, ...]:
    if options.names:
        return tuple(feature_named(workpiece.features, name) for name in options.names)
    from cad.workpiece.advise import AdviseOptions, advise_points
    from wpcal.seam import SeamOptions

    chosen = AdviseOptions(points=options.count)
    try:
        advice = advise_points(workpiece, options=chosen, seam_options=SeamOptions(), progress=progress)
    except GeometryError as error:
        raise GeometryError(f"{error}; or name the features", code=ErrorCode.FEATURES_NOT_CHOSEN) from None
    return advice.chosen.features


def _rows(features: Sequence[ReferenceFeature]) -> list[Any]:
    from cad.sheet.draw import SheetRow
    from wpcal.touch.advice import what_it_is

    return [
        SheetRow(str(number), feature.name, (" ".join(what_it_is(feature).split()), *_place(feature.p_mm)))
        for number, feature in enumerate(features, 1)
    ]


def _touch_rows(touches: Sequence[DrawnTouch]) -> list[Any]:
    from cad.sheet.draw import SheetRow

    return [
        SheetRow(str(number), touch.name, (touch.where, *_place(touch.p_part)), touch.way_part)
        for number, touch in enumerate(touches, 1)
    ]


def _place(p_mm: ArrayLike) -> tuple[str, str, str]:
    x, y, z = (f"{v + 0.0:.3f}" for v in np.round(np.asarray(p_mm, dtype=np.float64), 3))
    return x, y, z


def _title(workpiece: Workpiece) -> Any:
    from cad.sheet.table import TitleBlock

    source = workpiece.source
    made_by = f"wpcal {__version__}"
    if source is None:
        return TitleBlock("shapes from a script", "none", "", "mm", made_by)
    return TitleBlock(Path(source.file_name).stem, source.file_name, source.sha256, source.unit, made_by)


def _new_document() -> Any:
    import ezdxf

    from cad.sheet.draw import LAYERS, MILLIMETRES
    from cad.sheet.fonts import FONT

    document = ezdxf.new("R2018")
    document.header["$INSUNITS"] = MILLIMETRES
    document.styles.add("SHEET", font=FONT)
    for name, (color, pen) in LAYERS.items():
        document.layers.add(name, color=color, lineweight=pen)
    return document
