"""Features and seams as tables on stdout."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

from rich.table import Table

if TYPE_CHECKING:
    from wpcal.core.arrays import FloatArray
    from wpcal.seam import Seam
    from wpcal.seam.member.note import MemberNotes
    from wpcal.taught.features import ReferenceFeature


def features_table(features: Sequence[ReferenceFeature], file_name: str, ease: Mapping[str, str]) -> Table:
    """Return one row per feature; `ease` gives for each name how well it can be touched."""
    table = Table(title=f"What can be taught on {file_name} (part frame)")
    for heading in ("feature", "kind", "x y z mm"):
        table.add_column(heading, no_wrap=True)
    for heading in ("size mm", "touch", "ease", "solid"):
        table.add_column(heading)
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
    diameters = list(dict.fromkeys(f"{step.diameter_mm:.3f}" for step in feature.steps))
    if not diameters and feature.diameter_mm is not None:
        diameters = [f"{feature.diameter_mm:.3f}"]
    lengths = [f"{value:.3f}" for value in (feature.length_mm, feature.depth_mm) if value is not None]
    words = [" x ".join([" / ".join(diameters), *lengths] if diameters else lengths)]
    if feature.area_mm2 is not None:
        words.append(f"{feature.area_mm2:.1f} mm2")
    if feature.is_through is not None:
        words.append("through" if feature.is_through else "blind")
    if feature.form is not None and feature.form.value != "plain":
        words.append(feature.form.value)
    return " ".join(word for word in words if word)


def seams_table(
    seams: Sequence[Seam], title: str, u95_mm: Sequence[FloatArray] | None = None, *, with_gaps: bool = True
) -> Table:
    """Return one row per accepted seam.

    `u95_mm`: shape (frames,). The predicted 95 % error at every frame of each seam, mm; its largest value is shown.
    """
    table = Table(title=title)
    for heading in ("seam", "joint", "weld"):
        table.add_column(heading, no_wrap=True)
    table.add_column("joins")
    table.add_column("middle in part, mm", justify="right")
    for heading in ("length mm", "points", *(["gap mm"] if with_gaps else [])):
        table.add_column(heading, justify="right", no_wrap=heading != "length mm")
    table.add_column("sure", justify="right", no_wrap=True)
    if u95_mm is not None:
        table.add_column("95 % mm", justify="right", no_wrap=True)
    for row, seam in enumerate(seams):
        if not seam.accepted:
            continue
        cells = [seam.name, seam.joint.value, seam.weld.value, " + ".join(seam.solids), _middle(seam), _length(seam)]
        cells += [str(len(seam.frames)), *([f"{seam.gap_mm[2]:.3f}"] if with_gaps else []), _sure(seam)]
        if u95_mm is not None:
            cells.append(f"{u95_mm[row].max():.3f}")
        table.add_row(*cells)
    captions = []
    wraps = sum(seam.wrap_of is not None and not seam.accepted for seam in seams)
    if wraps:
        ends = "a short end is" if wraps == 1 else f"{wraps} short ends are"
        captions.append(f"{ends} left open; --wrap welds them in one run with the seams beside them")
    longer = [f"{seam.name} +{seam.more_wire_mm:g} mm" for seam in seams if seam.accepted and seam.more_wire_mm]
    if longer:
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
    from wpcal.seam.judge.evidence import ASSUMED_MARK
    from wpcal.seam.judge.hiding import gained_words

    table = Table(title="Not taken as welds")
    for heading in ("seam", "joint", "joins"):
        table.add_column(heading, no_wrap=heading != "joins")
    table.add_column("middle in part, mm", justify="right")
    table.add_column("length mm", justify="right")
    table.add_column("sure", justify="right", no_wrap=True)
    table.add_column("why")
    for seam in seams:
        if not seam.accepted:
            cells = [seam.name, seam.joint.value, " + ".join(seam.solids), _middle(seam), _length(seam)]
            by_hand = ("rejected by hand",) if seam.edit is not None and seam.edit.accept is False else ()
            why = "; ".join((*by_hand, *seam.against))
            if ASSUMED_MARK in why:
                before, _, rest = why.partition(ASSUMED_MARK)
                assumed, _, after = rest.partition(")")
                why, table.caption = before + after, f"{ASSUMED_MARK.strip(' (')} {assumed}"
            table.add_row(*cells, _sure(seam), why)
    for told in gained_words([seam for seam in seams if not seam.accepted]):
        table.caption = told if table.caption is None else f"{table.caption}; {told}"
    more = would_be_taken(seams)
    if more:
        told = f"only doubted, taken with --generous: {listed(seam.name for seam in more)}"
        table.caption = told if table.caption is None else f"{table.caption}; {told}"
    return table


def _middle(seam: Seam) -> str:
    """Return where a seam is on the part, to find it there and on the page."""
    return "" if seam.candidate is None else ", ".join(f"{value + 0.0:.1f}" for value in seam.candidate.middle_mm)


def _sure(seam: Seam) -> str:
    """Return how sure the rules are of what was decided, or that a person decided it."""
    decided = seam.edit is not None and seam.edit.accept == seam.accepted
    return "by hand" if decided else f"{seam.confidence:.0%}"


def members_table(notes: MemberNotes, seams: Sequence[Seam] = ()) -> Table:
    """Return one row per solid and member: what it is, its size and weight, what is welded on it, and why."""
    table = Table(title="Members, and what the solids are taken for")
    numbers = {"length mm": ("length_mm", ".0f"), "kg": ("mass_kg", ".2f"), "weld mm": ("weld_mm", ".0f")}
    for heading in ("member", "is", *numbers, "taken for", "why", "welded"):
        table.add_column(heading, justify="right" if heading in numbers else "left")
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
    table = Table(title=f"{record['seam']}: {state}, sure {record['confidence']:.0%}")
    table.add_column("what")
    table.add_column("factor", justify="right", no_wrap=True)
    table.add_column("sure", justify="right", no_wrap=True)
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


def _length(seam: Seam) -> str:
    return f"{seam.length_mm:.3f}{' closed' if seam.closed else ''}"
