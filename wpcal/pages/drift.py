"""The page of `wpcal drift`: charts of the jobs of each part. It has no script, so it also opens where none may run."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path

import numpy as np

from wpcal.core.arrays import FloatArray
from wpcal.pages.html import build_still_page, escaped
from wpcal.study.drift.control import CUSUM_H, CUSUM_K, LIMIT_SIGMAS, Charts
from wpcal.study.drift.jobs import FailedJob
from wpcal.study.drift.record import RULES, UNORDERED, shift_sentence
from wpcal.study.drift.watch import POSE_CHANNELS, PartDrift

STYLE = "\n" + Path(__file__).with_name("drift.css").read_text(encoding="utf-8")
LEFT, WIDTH, RIGHT = 62, 860, 8
COLUMNS = 430  #: More jobs than this are drawn as the range of their values in each column.
TITLE, TALL, LOW = 22.0, 128, 46  #: Height of a title; of a chart with its title; of its CUSUM.
ROOM = 190  #: Between the names of two jobs below a chart: a date and a time have 130.
MOST_CHARTED = 12  #: Parts with charts, those with shifts first: 5000 jobs make less than 2 MB, on however many parts.
MOST_POINTS = 12  #: Charts of points; the table has all.
MOST_FAILED = 50


def build_drift_page(
    parts: Sequence[PartDrift],
    failed: Sequence[FailedJob],
    left_out: Sequence[str],
    corrected: Sequence[Sequence[str]] | None = None,
) -> str:
    """Return the page. A self-contained HTML file, the same for the same jobs.

    `corrected`: Of each part, what was corrected alike on the pendant.
    """
    alike = corrected or [()] * len(parts)
    order = sorted(range(len(parts)), key=lambda k: (not parts[k].shifts, -len(parts[k].jobs.names)))
    charted = set(order[:MOST_CHARTED])
    body = [
        "<h1>Drift</h1>",
        *(text for k, part in enumerate(parts) for text in _part(part, alike[k], has_charts=k in charted)),
    ]
    if left_out or failed:
        body.append("<h2>Left out</h2><ul>")
        body += [f"<li>{escaped(line)}</li>" for line in left_out]
        body += [f"<li>{escaped(f'{job.job} failed: {job.error}')}</li>" for job in failed[:MOST_FAILED]]
        if len(failed) > MOST_FAILED:
            body.append(f"<li>{len(failed) - MOST_FAILED} more jobs failed; drift.json lists them</li>")
        body.append("</ul>")
    rows = [f"<tr><td>{rule['name']}<td class=t>{rule['rule']}<td class=t>{rule['false_alarm']}</tr>" for rule in RULES]
    head = "<tr><th>rule<th class=t>alarm<th class=t>false alarms</tr>"
    body += ["<h2>Rules</h2>", *_wide("Rules", ["<table>", head, *rows, "</table>"])]
    return build_still_page(title="Drift", style=STYLE, body="\n".join(body))


def _wide(label: str, lines: Iterable[str]) -> Iterator[str]:
    """Yield lines in a box that scrolls sideways, also with the keyboard, where the window is narrow."""
    yield f'<div class=w tabindex=0 role=region aria-label="{escaped(label)}">'
    yield from lines
    yield "</div>"


def _part(part: PartDrift, corrected: Sequence[str], *, has_charts: bool) -> Iterator[str]:
    jobs = part.jobs
    order = "in the order of their times" if jobs.by_time else f"in the order of the lists: {UNORDERED}"
    yield f"<h2>{escaped(jobs.file)}</h2>"
    yield f"<p>{len(jobs.names)} jobs {order}, from {_job(part, 0)} to {_job(part, len(jobs.names) - 1)}.</p>"
    yield "<h3>Sudden shifts</h3>"
    yield from _wide("Sudden shifts", _shift_table(part)) if part.shifts else ("<p>None.</p>",)
    if corrected:
        yield "<h3>Corrected alike on the pendant</h3>"
        yield from (f"<p>{escaped(line)}</p>" for line in corrected)
    if not has_charts:
        yield f"<p>{_most_wrong(part)}Charts: wpcal drift --on-part {escaped(jobs.file)}.</p>"
        return
    yield "<h3>Pose</h3>"
    yield (
        f"<p class=n>Of the middle of the touched points, from the median pose, along the axes of base. Broken lines: "
        f"{LIMIT_SIGMAS:g} sigma around the mean of the first {part.first} jobs. Below each chart: CUSUM with "
        f"k = {CUSUM_K:g} and h = {CUSUM_H:g} sigma. Vertical lines: sudden shifts.</p>"
    )
    charts = [
        _chart(part, part.pose, k, f"{name}, {unit}", has_cusum=True) for k, (name, unit) in enumerate(POSE_CHANNELS)
    ]
    yield from _wide("Pose", [*charts, _jobs_below(part)])
    yield from _points(part)
    if part.seam is not None:
        yield "<h3>Largest predicted error of a seam</h3>"
        chart = _chart(part, part.seam, 0, "95 % error, mm", has_cusum=False)
        yield from _wide("Seam error", [chart, _jobs_below(part)])


def _job(part: PartDrift, row: int) -> str:
    when = part.jobs.when[row]
    return escaped(f"{part.jobs.names[row]} ({when})" if when else part.jobs.names[row])


def _shift_table(part: PartDrift) -> Iterator[str]:
    heads = "".join(f"<th>{name}, {unit}" for name, unit in POSE_CHANNELS)
    yield f"<table><tr><th>first job after it<th class=t>likely cause{heads}</tr>"
    for shift in part.shifts:
        moves = "".join(f"<td>{value:+.3f}" for value in shift.move)
        yield f"<tr><td class=d>{_job(part, shift.at)}<td class=t>{escaped(shift_sentence(part, shift))}{moves}</tr>"
    yield "</table>"


def _most_wrong(part: PartDrift) -> str:
    worst = part.most_wrong
    return "" if worst is None else f"Taught wrong most: {escaped(part.jobs.points[worst])}. "


def _points(part: PartDrift) -> Iterator[str]:
    yield "<h3>Residuals by point</h3>"
    yield f"<p>{_most_wrong(part)}</p>"
    if part.jobs.left_out:
        yield f"<p class=n>Not in all jobs, so not shown: {escaped(', '.join(part.jobs.left_out))}.</p>"
    values = part.distance.values
    rms = np.sqrt((values**2).mean(axis=0))
    order = np.argsort(-rms, kind="stable")
    heads = ("point", "rms, mm", "largest, mm", "jobs with the largest residual here", "jobs that name it as wrong")
    rows = [
        f"<tr><td>{escaped(part.jobs.points[column])}<td>{rms[column]:.3f}<td>{values[:, column].max():.3f}"
        f"<td>{part.largest[column]:.0f}<td>{part.jobs.suspected[column]:.0f}</tr>"
        for column in order
    ]
    head = f"<tr>{''.join(f'<th>{head}' for head in heads)}</tr>"
    yield from _wide("Residuals by point", ["<table>", head, *rows, "</table>"])
    shown = order[:MOST_POINTS].tolist()
    charts = [_chart(part, part.distance, k, f"{part.jobs.points[k]}, mm", has_cusum=False) for k in shown]
    yield from _wide("Charts of points", [*charts, _jobs_below(part)])


def _chart(part: PartDrift, charts: Charts, column: int, title: str, *, has_cusum: bool) -> str:
    n = len(part.jobs.names)
    values = charts.values[:, column]
    centre, reach = charts.centre[column], LIMIT_SIGMAS * charts.sigma[column]
    low, high = min(values.min(), centre - reach), max(values.max(), centre + reach)
    scale = _Scale(low, high, TITLE, TALL - 4.0)
    height = TALL + (LOW if has_cusum else 0) + 4
    lines = [f'<path class="v" d="{_path(values, scale)}"/>', _level("c", scale(centre))]
    lines += [_level("l", scale(centre + side * reach)) for side in (-1, 1)]
    outside = np.flatnonzero(charts.outside[:, column])
    dots = outside[np.unique(outside * 2 * COLUMNS // n, return_index=True)[1]].tolist()  # at most two per column
    lines.append(
        f'<path class="o" d="{"".join(f"M{_across(row, n):.0f} {scale(values[row]):.1f}h0" for row in dots)}"/>'
    )
    lines += [f'<text x="2" y="{scale(value) + 4:.0f}">{value:.3g}</text>' for value in (high, low)]
    if has_cusum:
        most = max(CUSUM_H, charts.cusum_up[:, column].max(), charts.cusum_down[:, column].max()) * 1.05
        sums = _Scale(-most, most, TALL, TALL + LOW)
        lines += [f'<path class="v" d="{_path(charts.cusum_up[:, column], sums)}"/>']
        lines += [f'<path class="v" d="{_path(-charts.cusum_down[:, column], sums)}"/>']
        lines += [_level("l", sums(side * CUSUM_H)) for side in (-1, 1)]
        lines.append(f'<text x="2" y="{sums(0) + 4:.0f}">CUSUM</text>')
    for shift in part.shifts:
        lines.append(f'<path class="s" d="M{_across(shift.at - 0.5, n):.1f} 0V{height}"/>')
    label = escaped(title)
    lines.append(f'<text x="{LEFT + 4}" y="13">{label}</text>')
    box = f"0 0 {LEFT + WIDTH + RIGHT} {height}"
    return f'<svg viewBox="{box}" role="img" aria-label="{label}">{"".join(lines)}</svg>'


def _jobs_below(part: PartDrift) -> str:
    """Return the line below charts: the first and the last job, and those after shifts where there is room."""
    n = len(part.jobs.names)
    places = [(0, "start"), (n - 1, "end"), *((shift.at, "middle") for shift in part.shifts)]
    lines, taken = [], list[float]()
    for row, anchor in places:
        label = part.jobs.when[row] or part.jobs.names[row]
        x = {"start": LEFT, "end": LEFT + WIDTH}.get(anchor, _across(row - 0.5, n))
        if all(abs(x - other) > ROOM for other in taken):
            lines.append(f'<text x="{x:.0f}" y="14" text-anchor="{anchor}">{escaped(label)}</text>')
            taken.append(x)
    return f'<svg viewBox="0 0 {LEFT + WIDTH + RIGHT} 20" aria-hidden="true">{"".join(lines)}</svg>'


class _Scale:
    """Values to heights: the largest is at the top."""

    def __init__(self, low: float, high: float, top: float, bottom: float) -> None:
        self._high, self._top = high, top
        self._per = (bottom - top) / (high - low) if high > low else 0.0

    def __call__(self, value: float | FloatArray) -> FloatArray:
        return np.asarray(self._top + (self._high - value) * self._per)


def _across(row: float, n: int) -> float:
    return LEFT + WIDTH * (row + 0.5) / n


def _level(kind: str, y: FloatArray) -> str:
    return f'<path class="{kind}" d="M{LEFT} {y:.1f}h{WIDTH}"/>'


def _path(values: FloatArray, scale: _Scale) -> str:
    """Return the line through values; of many, a line through the least and the largest of each column."""
    n = len(values)
    if n > 2 * COLUMNS:
        starts = np.arange(COLUMNS) * n // COLUMNS
        both = [np.minimum.reduceat(values, starts), np.maximum.reduceat(values, starts)]
        x = np.repeat(LEFT + WIDTH * (np.arange(COLUMNS) + 0.5) / COLUMNS, 2)
        y = scale(np.stack(both, axis=1).ravel())
    else:
        x, y = LEFT + WIDTH * (np.arange(n) + 0.5) / n, scale(values)
    return "M" + " ".join(f"{a:.1f} {b:.1f}" for a, b in zip(x.tolist(), y.tolist(), strict=True))
