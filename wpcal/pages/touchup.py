"""The page of `wpcal touchup`: what was corrected, where, and what it says of every seam.

Its script only writes a command: which seams are taken.
"""

from __future__ import annotations

import shlex
from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import Any

import numpy as np

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


def build_touch_up_page(
    record: Mapping[str, Any], seams: Mapping[str, FloatArray], title: str, command: Sequence[str]
) -> str:
    """Return the page of a ``touchup.json``. A self-contained HTML file, the same for the same corrections.

    `seams`: shape (n, 3). Points along every seam of the part, in `base`, mm.
    `command`: The words that made it; the page adds what is set aside in it.
    """
    body = [
        f"<h1>{escaped(title)}</h1>",
        *(f"<p>{escaped(each)}</p>" for each in record["sentences"]),
        *_picture(record["points"], seams),
        "<h2>Seams</h2>",
        *_table("Seams", SEAM_HEADS, _seams(record)),
        "<p class=n>Corrections of a seam that is not taken are kept, but no conclusion is drawn from them. Keys: a "
        "takes a seam, r sets it aside.</p>",
        *(f"<p>{box}</p>" for box in _boxes(record, seams)),
        "<p class=n>This command writes the program:</p>",
        f"<p><code id=command>{escaped(shlex.join([*command, '-o', 'NEW']))}</code></p>",
        "<h2>Line by line</h2>",
        *_table("Line by line", "<th>place<th class=t>seam<th class=t>what<th>mm", _lines(record)),
    ]
    return build_still_page(title=title, style=STYLE, body="\n".join(body), script="touchup.js")


def _table(name: str, heads: str, rows: Iterator[str]) -> Iterator[str]:
    yield f"<div class=w tabindex=0 role=region aria-label='{name}'><table><tr>{heads}</tr>"
    yield from rows
    yield "</table></div>"


def _seams(record: Mapping[str, Any]) -> Iterator[str]:
    for each in record["seams"]:
        lengths = (each[key] for key in ("was_off_mm", "error_95_before_mm", "error_95_mm"))
        numbers = "".join("<td>" if mm is None else f"<td>{mm:.2f}" for mm in lengths)
        seam = f"<td>{escaped(each['seam'])}<td>{each['corrected'] or ''}"
        yield f"<tr>{seam}{numbers}<td class=t>{escaped(each['says'])}</tr>"


def _boxes(record: Mapping[str, Any], seams: Iterable[str]) -> Iterator[str]:
    """Yield a box for each corrected seam, also for one that is set aside and is in no table."""
    is_taken = {point["seam"]: point["is_used"] for point in record["points"]}
    for name in (each for each in seams if each in is_taken):
        taken = " checked" * is_taken[name]
        yield f'<label><input type=checkbox value="{escaped(name)}"{taken}> take {escaped(name)}</label>'


def _lines(record: Mapping[str, Any]) -> Iterator[str]:
    for each in record["lines"]:
        where = f"<td>{escaped(each['place'])}<td class=t>{escaped(each['seam'])}"
        yield f"<tr>{where}<td class=t>{escaped(each['what'])}<td>{each['mm']:.2f}</tr>"


def _picture(points: Sequence[Mapping[str, Any]], seams: Mapping[str, FloatArray]) -> Iterator[str]:
    """Yield the seams from the side and above, with an arrow at each corrected point, and a dot where it was."""
    drawn = {name: p @ VIEW.T for name, p in seams.items()}
    every = np.concatenate([*drawn.values()])
    low, size = every.min(axis=0), np.maximum(np.ptp(every, axis=0), 1.0)
    scale = float(min((WIDTH - 2 * MARGIN) / size[0], (HEIGHT - 2 * MARGIN) / size[1]))

    def at(p: FloatArray) -> FloatArray:
        x, y = ((p - low) * scale).T
        return np.stack([MARGIN + x, HEIGHT - MARGIN - y], axis=1)

    starts, ways = (np.reshape([point[key] for point in points], (-1, 3)) @ VIEW.T for key in ("p_base_mm", "moved_mm"))
    longest = max(np.linalg.norm(ways, axis=1).tolist(), default=1.0)
    larger = ARROW / max(longest * scale, 1e-9)
    yield f'<svg class=p viewBox="0 0 {WIDTH:g} {HEIGHT:g}" role=img aria-label="Seams and corrected points">'
    for name, p in drawn.items():
        line = " ".join(f"{x:.1f},{y:.1f}" for x, y in at(p).tolist())
        x, y = at(p[len(p) // 2][None])[0].tolist()
        yield f'<polyline class=f points="{line}"/><text x="{x:.1f}" y="{y - 5:.1f}">{escaped(name)}</text>'
    for point, (x, y), (u, v) in zip(points, at(starts).tolist(), at(starts + larger * ways).tolist(), strict=True):
        kind = "x" if point["is_exception"] else "h"
        yield f'<path class={kind} d="M{x:.1f} {y:.1f}L{u:.1f} {v:.1f}"/>'
        yield f'<circle cx="{x:.1f}" cy="{y:.1f}" r="4"><title>{escaped(point["place"])}</title></circle>'
    yield "</svg>"
    if points:
        yield f"<p class=n>Arrows from where the points were, {larger:.0f} times as long as they are.</p>"
