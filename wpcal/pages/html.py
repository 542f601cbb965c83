"""One HTML file with everything in it: markup, styles, scripts, data.

The content security policy of the page allows only the scripts and styles that it was built with, by their hashes. The
contents of files are data: JSON in a block that no browser runs, read by scripts that only set text. A name like
``</script><img onerror=…>`` stays a name.
"""

from __future__ import annotations

import base64
import hashlib
import html
import json
import zlib
from collections.abc import Mapping
from functools import cache, lru_cache
from importlib.resources import files
from typing import Any

from wpcal.core.records import to_compact_json
from wpcal.core.wording import printable
from wpcal.pages.packing import pack_glb

COMPRESSION = 6  #: Level of zlib: level 9 saves 2 % of a mesh and takes three times as long.


def build_page(
    *,
    title: str,
    entry: str,
    body: str,
    data: Mapping[str, Any],
    blobs: Mapping[str, bytes] | None = None,
    connects: bool = False,
) -> str:
    """Return a page with its data, scripts and styles. HTML, the same for the same arguments.

    `blobs`: Larger data, which the page stores deflated (GLB files are packed first). The script gets them from
    ``readBlob(name)`` or ``readJsonBlob(name)``.
    """
    held = [
        body.strip(),
        f'<script type="application/json" id="data">{_json_in_html(data)}</script>',
        *(_blob(name, raw) for name, raw in (blobs or {}).items()),
    ]
    scripts = [_bundle("viewer.js"), _bundle(f"{entry}.js")]
    return _page(title, _bundle(f"{entry}.css"), held, scripts, connects=connects)


def build_still_page(*, title: str, style: str, body: str, script: str | None = None) -> str:
    """Return a page without a view of the part. HTML, the same for the same arguments.

    `script`: The name of a bundle; None: the page has no script.
    """
    scripts = [] if script is None else [_bundle(script)]
    return _page(title, style, ["<main>", body.strip(), "</main>"], scripts, connects=False)


def _page(title: str, style: str, held: list[str], scripts: list[str], *, connects: bool) -> str:
    lines = [
        "<!DOCTYPE html>",
        '<html lang="en">',
        "<head>",
        '<meta charset="utf-8">',
        f'<meta http-equiv="Content-Security-Policy" content="{_policy(scripts, style, connects=connects)}">',
        '<meta name="viewport" content="width=device-width, initial-scale=1">',
        '<link rel="icon" href="data:,">',
        f"<title>{escaped(title)}</title>",
        f"<style>{style}</style>",
        "</head>",
        "<body>",
        *held,
        *(f"<script>{text}</script>" for text in scripts),
        "</body>",
        "</html>",
    ]
    return "\n".join(lines) + "\n"


def escaped(text: str) -> str:
    """Return a text of a file as markup that shows it."""
    return html.escape(printable(text))


def json_blob(value: Any) -> bytes:
    """Return JSON values as one of the page's blobs, which its script reads with ``readJsonBlob(name)``."""
    return to_compact_json(value).encode("ascii")


@cache
def _bundle(name: str) -> str:
    text = (files("wpcal.pages") / "bundles" / name).read_text(encoding="utf-8")
    if "</script" in text.lower() or "</style" in text.lower():
        raise AssertionError(f"bundle {name} would end its own element")
    return text


def _policy(scripts: list[str], style: str, *, connects: bool) -> str:
    """Return a policy that allows exactly these texts, and images only inside the page."""
    parts = [
        "default-src 'none'",
        *([f"script-src {' '.join(map(_hash_source, scripts))}"] if scripts else ()),
        f"style-src {_hash_source(style)}",
        "img-src data:",
        "base-uri 'none'",
        "form-action 'none'",
    ]
    if connects:
        parts.append("connect-src 'self'")
    return "; ".join(parts)


@lru_cache(maxsize=16)
def _hash_source(text: str) -> str:
    return f"'sha256-{base64.b64encode(hashlib.sha256(text.encode('utf-8')).digest()).decode('ascii')}'"


def _json_in_html(data: Mapping[str, Any]) -> str:
    """Return JSON without the characters that begin or end markup."""
    text = json.dumps(data, ensure_ascii=True, allow_nan=False, separators=(",", ":"))
    return text.replace("<", "\\u003c").replace(">", "\\u003e").replace("&", "\\u0026")


def _blob(name: str, raw: bytes) -> str:
    kind, text = ("glb", _packed_glb(raw)) if raw.startswith(b"glTF") else ("raw", _deflated(raw))
    return f'<script type="text/plain" id="blob-{html.escape(name)}" data-kind="{kind}">{text}</script>'


@lru_cache(maxsize=1)
def _packed_glb(raw: bytes) -> str:
    """Return a GLB file as a page holds it: many pages of one part hold the same."""
    return _deflated(pack_glb(raw))


def _deflated(raw: bytes) -> str:
    return base64.b64encode(zlib.compress(raw, COMPRESSION)).decode("ascii")
