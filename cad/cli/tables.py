"""Features and seams as tables on stdout."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING, Any

from rich.table import Table

from wpcal.cli.console import new_table

if TYPE_CHECKING:
    from wpcal.core.arrays import FloatArray
    from wpcal.seam import Seam
    from wpcal.seam.member.note import MemberNotes
    from wpcal.taught.features import ReferenceFeature


def features_table(features: Sequence[ReferenceFeature], file_name: str, ease: Mapping[str, str]) -> Table:
    """Return one row per feature; `ease` gives for each name how well it can be touched."""
    table = new_table(
        f"What can be taught on {file_name} (part frame)", "<=feature|<=kind|<=x y z mm|<size mm|<touch|<ease|<solid"
    )
    for feature in features:
        place = " ".join(f"{round(float(v), 3) + 0.0:.9g}" for v in feature.p_mm)
        table.add_row(
            feature.name,
            feature.kind.word.replace("_", " "),
            place,
            size_words(feature),
            feature.kind.touch.value,
            ease[feature.name],
            feature.solid,
        )
    return table


def size_words(feature: ReferenceFeature) -> str:
    """Say a feature's size: ``18.000 / 10.000 x 20.000 through, counterbore``; diameters, then depth or length, mm."""
    diameters = _millimetres([step.diameter_mm for step in feature.steps] or [feature.diameter_mm])
    across = " / ".join(dict.fromkeys(diameters))
    lengths = _millimetres([feature.length_mm, feature.depth_mm])
    words = [" x ".join([across, *lengths] if across else lengths)]
    if feature.area_mm2 is not None:
        words.append(f"{feature.area_mm2:.1f} mm2")
    if feature.is_through is not None:
        words.append("through" if feature.is_through else "blind")
    if feature.form is not None and feature.form.value != "plain":
        words.append(feature.form.value)
    return " ".join(word for word in words if word)


def _millimetres(values: Sequence[float | None]) -> list[str]:
    return [f"{value:.3f}" for value in values if value is not None]


CELLS: Mapping[str, Callable[[Seam], str]] = {
    "seam": lambda seam: seam.name,
    "joint": lambda seam: seam.joint.value,
    "weld": lambda seam: seam.weld.value,
    "joins": lambda seam: " + ".join(seam.solids),
    # where it is on the part, to find it there and on the page
    "middle in part, mm": lambda seam: (
        "" if seam.candidate is None else ", ".join(f"{value + 0.0:.1f}" for value in seam.candidate.middle_mm)
    ),
    "length mm": lambda seam: f"{seam.length_mm:.3f}{' closed' if seam.closed else ''}",
    "points": lambda seam: str(len(seam.frames)),
    "gap mm": lambda seam: f"{seam.gap_mm[2]:.3f}",
    "sure": lambda seam: "by hand" if seam.edit and seam.edit.accept == seam.accepted else f"{seam.confidence:.0%}",
}
"""Columns about seams."""
WORDS = ("seam", "joint", "weld", "joins", "why")  #: Columns of words; numbers are on the right.
WRAPPED = ("joins", "middle in part, mm", "length mm", "why")


def _table(title: str, seams: Sequence[Seam], columns: Mapping[str, Callable[[Seam], str]]) -> Table:
    """Return one row per seam."""
    table = Table(title=title)
    for heading in columns:
        table.add_column(heading, justify="left" if heading in WORDS else "right", no_wrap=heading not in WRAPPED)
    for seam in seams:
        table.add_row(*(cell(seam) for cell in columns.values()))
    return table


def seams_table(
    seams: Sequence[Seam], title: str, u95_mm: Sequence[FloatArray] | None = None, *, with_gaps: bool = True
) -> Table:
    """Return one row per accepted seam.

    `u95_mm`: shape (frames,). The predicted 95 % error at every frame of each seam, mm; its largest value is shown.
    """
    columns = {heading: cell for heading, cell in CELLS.items() if with_gaps or heading != "gap mm"}
    if u95_mm is not None:
        largest = {id(seam): u95 for seam, u95 in zip(seams, u95_mm, strict=True)}
        columns["95 % mm"] = lambda seam: f"{largest[id(seam)].max():.3f}"
    accepted, captions = [seam for seam in seams if seam.accepted], list[str]()
    table = _table(title, accepted, columns)
    if u95_mm is not None and len(accepted) > 1:
        captions.append(
            "95 % mm is of each seam alone; the verdict holds for all seams at once, so its figure is larger"
        )
    if wraps := sum(seam.wrap_of is not None and not seam.accepted for seam in seams):
        ends = "a short end is" if wraps == 1 else f"{wraps} short ends are"
        captions.append(f"{ends} left open; --wrap welds them in one run with the seams beside them")
    if longer := [f"{seam.name} +{seam.more_wire_mm:g} mm" for seam in accepted if seam.more_wire_mm]:
        captions.append(f"These need more wire than usual, the torch stays back by it: {', '.join(longer)}")
    table.caption = "\n".join(captions) or None
    return table


def rest_words(seams: Sequence[Seam]) -> str:
    """Say in a line how many candidates are not taken and how to see why."""
    from wpcal.core.wording import counted
    from wpcal.seam.judge.doubted import would_be_taken
    from wpcal.seam.judge.hiding import gained_words

    rest = sum(not seam.accepted for seam in seams)
    if not rest:
        return f"{'every candidate is taken' if seams else 'no candidate'}; --all lists what the solids are taken for"
    doubted = len(would_be_taken(seams))
    more = f" ({doubted} of them only doubted: --generous takes them)" if doubted else ""
    gained = "".join(f"\n{told}" for told in gained_words([seam for seam in seams if not seam.accepted]))
    return (
        f"{counted(rest, 'candidate')} not taken{more}; --all says why, --explain W1 says everything about one{gained}"
    )


def refused_table(seams: Sequence[Seam]) -> Table:
    """Return one row per candidate that is not accepted as a weld, with the reasons.

    Below the table are once: which torch was assumed, what would change a verdict about reach, and what `--generous`
    would take.
    """
    from wpcal.core.wording import listed
    from wpcal.seam.judge.doubted import would_be_taken
    from wpcal.seam.judge.hiding import gained_words

    refused = [seam for seam in seams if not seam.accepted]
    shown = ("seam", "joint", "joins", "middle in part, mm", "length mm", "sure")
    columns = {**{heading: CELLS[heading] for heading in shown}, "why": lambda seam: _why(seam)[0]}
    table = _table("Not taken as welds", refused, columns)
    captions = [assumed for _, assumed in map(_why, refused) if assumed][-1:] + list(gained_words(refused))
    if more := would_be_taken(seams):
        captions.append(f"only doubted, taken with --generous: {listed(seam.name for seam in more)}")
    table.caption = "; ".join(captions) or None
    return table


def _why(seam: Seam) -> tuple[str, str]:
    """Return why a candidate is not taken, and which torch was assumed for that."""
    from wpcal.seam.judge.evidence import ASSUMED_MARK

    by_hand = ("rejected by hand",) if seam.edit is not None and seam.edit.accept is False else ()
    why = "; ".join((*by_hand, *seam.against))
    before, mark, rest = why.partition(ASSUMED_MARK)
    assumed, _, after = rest.partition(")")
    return before + after, f"{mark.strip(' (')} {assumed}".strip()


def members_table(notes: MemberNotes, seams: Sequence[Seam] = ()) -> Table:
    """Return one row per solid and member: what it is, its size and weight, what is welded on it, and why."""
    numbers = {"length mm": ("length_mm", ".0f"), "kg": ("mass_kg", ".2f"), "weld mm": ("weld_mm", ".0f")}
    headings = f"<member|<is|{'|'.join(numbers)}|<taken for|<why|<welded"
    table = new_table("Members, and what the solids are taken for", headings)
    for one in notes.to_record(seams)["members"]:
        is_welded = one["said"] if one["said"] is not None else one["factor"] == 1.0
        welded = "yes" if is_welded else "no" if one["factor"] < notes.judging.level.value else "perhaps"
        words = (one["taken_as"], "; ".join(one["why"]), welded)
        for row in one.get("listed", [{"name": one["solid"], "kind": ""}]):
            shown = [format(row[key], form) if key in row else "" for key, form in numbers.values()]
            table.add_row(row["name"], row["kind"], *shown, *words)
            words = ("", "", "")
    return table


def explained_table(record: Mapping[str, Any]) -> Table:
    """Return what decided about one seam: the chain of decisions, the findings with their factors, the members."""
    state = "accepted" if record["accepted"] else "not taken as a weld"
    table = new_table(f"{record['seam']}: {state}, sure {record['confidence']:.0%}", "<what|=factor|=sure")
    start = (f"{record['start_score']:g}", f"{record['start_confidence']:.0%}")
    for number, text in enumerate(record["chain"][:-1]):
        table.add_row(text, *(("", "") if number else start))
    for one in record["findings"]:
        because = f" ({one['why']} Found by: {one['found_by']})" if one["why"] else ""
        table.add_row(f"{one['text']}{because}", f"{one['factor']:g}", f"{one['confidence_after']:.1%}")
    for one in record["members"]:
        table.add_row(f"{one['solid']}: taken for {one['taken_as']}; {'; '.join(one['why'])}", "", "")
    table.add_row(record["chain"][-1], f"{record['score']:.3g}", f"{record['confidence']:.0%}")
    return table
