"""The elements of an SVG as text: the same elements give the same text."""

from __future__ import annotations

from collections.abc import Iterable
from html import escape

from wpcal.core.arrays import FloatArray


def svg(width: float, height: float, elements: Iterable[str], *, ground: str = "white") -> str:
    """Return a picture on a ground of one colour; lengths in pixels."""
    head = f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width:g} {height:g}" font-family="sans-serif">'
    return "\n".join([head, rect(0, 0, width, height, fill=ground), *elements, "</svg>", ""])


def polyline(points: FloatArray, colour: str, width: float) -> str:
    """Return an open line through points, shape (k, 2)."""
    return f'<polyline points="{_listed(points)}" fill="none" stroke="{colour}" stroke-width="{width:g}"/>'


def polygon(points: FloatArray, fill: str, stroke: str, *, opacity: float = 1.0) -> str:
    """Return a filled outline through points, shape (k, 2)."""
    shown = "" if opacity == 1.0 else f' fill-opacity="{opacity:g}"'
    return f'<polygon points="{_listed(points)}" fill="{fill}"{shown} stroke="{stroke}"/>'


def rect(
    x: float, y: float, width: float, height: float, *, fill: str = "none", stroke: str = "", told: str = ""
) -> str:
    """Return a rectangle; `told` is shown where the pointer rests on it."""
    line = f' stroke="{stroke}"' if stroke else ""
    box = f'<rect x="{x:g}" y="{y:g}" width="{width:g}" height="{height:g}" fill="{fill}"{line}'
    return f"{box}><title>{escape(told)}</title></rect>" if told else f"{box}/>"


def circle(x: float, y: float, radius: float, stroke: str, width: float) -> str:
    """Return a circle that is not filled."""
    return f'<circle cx="{x:g}" cy="{y:g}" r="{radius:g}" fill="none" stroke="{stroke}" stroke-width="{width:g}"/>'


def text(x: float, y: float, words: str, size: float, colour: str = "#000") -> str:
    """Return a line of words that starts at (x, y)."""
    return f'<text x="{x:g}" y="{y:g}" font-size="{size:g}" fill="{colour}">{escape(words)}</text>'


def _listed(points: FloatArray) -> str:
    return " ".join(f"{x:.1f},{y:.1f}" for x, y in points.tolist())
