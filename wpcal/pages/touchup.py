"""The page of `wpcal touchup`: what was corrected, where, and what it says of every seam.

Its script only writes a command: which seams are taken.
"""

from __future__ import annotations

import shlex
from collections.abc import Iterator, Sequence

import numpy as np

from wpcal.controllers.touchup.record import sentences, written_lines
from wpcal.controllers.touchup.study import TouchUp
from wpcal.core.arrays import FloatArray
from wpcal.pages.drift import STYLE as TABLES
from wpcal.pages.html import build_still_page, escaped

STYLE = (
    TABLES
    + """
.h{stroke:var(--limit);stroke-width:2.5;fill:none}.x{stroke:var(--bad);stroke-width:2.5;fill:none}
.f{stroke:var(--soft);stroke-width:1.2;fill:none}circle{fill:var(--limit)}.x+circle{fill:var(--bad)}
.p{break-inside:avoid}
"""
)
SEAM_HEADS = "<th>seam<th>corrected<th>was off, mm<th>95 % before, mm<th>95 % now, mm<th class=t>remark"
WIDTH, HEIGHT, MARGIN = 860.0, 460.0, 40.0
ARROW = 60.0  #: The largest correction is drawn as long as this, in pixels.
VIEW = np.array([[0.8, -0.6, 0.0], [-0.3, -0.4, 0.87]])
"""From base to the picture: right and up; from the side and above."""


def build_touch_up_page(found: TouchUp, title: str, command: Sequence[str]) -> str:
    """Return the page. A self-contained HTML file, the same for the same corrections.

    `command`: The words that made it; the page adds what is set aside in it.
    """
    body = [
        f"<h1>{escaped(title)}</h1>",
        *(f"<p>{escaped(each)}</p>" for each in sentences(found)),
        *_picture(found),
        "<h2>Seams</h2>",
        *_table("Seams", SEAM_HEADS, _seams(found)),
        "<p class=n>Corrections of a seam that is not taken are kept, but no conclusion is drawn from them. Keys: a "
        "takes a seam, r sets it aside.</p>",
        *(f"<p>{box}</p>" for box in _boxes(found)),
        "<p class=n>This command writes the program:</p>",
        f"<p><code id=command>{escaped(shlex.join([*command, '-o', 'NEW']))}</code></p>",
        "<h2>Line by line</h2>",
        *_table("Line by line", "<th>place<th class=t>seam<th class=t>what<th>mm", _lines(found)),
    ]
    return build_still_page(title=title, style=STYLE, body="\n".join(body), script="touchup.js")


def _table(name: str, heads: str, rows: Iterator[str]) -> Iterator[str]:
    yield f"<div class=w tabindex=0 role=region aria-label='{name}'><table><tr>{heads}</tr>"
    yield from rows
    yield "</table></div>"


def _seams(found: TouchUp) -> Iterator[str]:
    for each in found.seams:
        before = "" if each.before_95_mm is None else f"{each.before_95_mm:.2f}"
        numbers = f"<td>{each.corrected or ''}<td>{each.was_off_mm:.2f}<td>{before}<td>{each.after_95_mm:.2f}"
        yield f"<tr><td>{escaped(each.name)}{numbers}<td class=t>{escaped(each.says)}</tr>"


def _boxes(found: TouchUp) -> Iterator[str]:
    """Yield a box for each corrected seam, also for one that is set aside and is in no table."""
    for number in sorted({point.seam for point in found.points}):
        name = found.part.seams[number].name
        taken = " checked" * (name not in found.options.without)
        yield f'<label><input type=checkbox value="{escaped(name)}"{taken}> take {escaped(name)}</label>'


def _lines(found: TouchUp) -> Iterator[str]:
    for each in written_lines(found):
        where = f"<td>{escaped(each['place'])}<td class=t>{escaped(each['seam'])}"
        yield f"<tr>{where}<td class=t>{escaped(each['what'])}<td>{each['mm']:.2f}</tr>"


def _picture(found: TouchUp) -> Iterator[str]:
    """Yield the seams from the side and above, with an arrow at each corrected point, and a dot where it was."""
    seams = [seam.frames.p @ VIEW.T for seam in found.part.seams]
    every = np.concatenate(seams)
    low, size = every.min(axis=0), np.maximum(np.ptp(every, axis=0), 1.0)
    scale = float(min((WIDTH - 2 * MARGIN) / size[0], (HEIGHT - 2 * MARGIN) / size[1]))

    def at(p: FloatArray) -> FloatArray:
        x, y = ((p - low) * scale).T
        return np.stack([MARGIN + x, HEIGHT - MARGIN - y], axis=1)

    longest = max((float(np.linalg.norm(VIEW @ point.moved)) for point in found.points), default=1.0)
    larger = ARROW / max(longest * scale, 1e-9)
    yield f'<svg class=p viewBox="0 0 {WIDTH:g} {HEIGHT:g}" role=img aria-label="Seams and corrected points">'
    for seam, p in zip(found.part.seams, seams, strict=True):
        points = " ".join(f"{x:.1f},{y:.1f}" for x, y in at(p).tolist())
        x, y = at(p[len(p) // 2][None])[0].tolist()
        yield f'<polyline class=f points="{points}"/><text x="{x:.1f}" y="{y - 5:.1f}">{escaped(seam.name)}</text>'
    exceptions = {point.row for point in found.exceptions}
    for point in found.points:
        (x, y), (u, v) = at(np.stack([VIEW @ point.at, VIEW @ (point.at + larger * point.moved)])).tolist()
        kind = "x" if point.row in exceptions else "h"
        yield f'<path class={kind} d="M{x:.1f} {y:.1f}L{u:.1f} {v:.1f}"/>'
        yield f'<circle cx="{x:.1f}" cy="{y:.1f}" r="4"><title>{escaped(point.place)}</title></circle>'
    yield "</svg>"
    if found.points:
        yield f"<p class=n>Arrows from where the points were, {larger:.0f} times as long as they are.</p>"
