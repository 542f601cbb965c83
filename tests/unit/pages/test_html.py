"""The HTML around a page: data cannot become markup, and the policy allows exactly the scripts and styles in it."""

import base64
import hashlib
import json
import re
import zlib
from html.parser import HTMLParser

import pytest

from wpcal.pages.html import build_page

HOSTILE = "</script><img src=x onerror=alert(1)>&amp;<!--<script>\u2028'\""


class Elements(HTMLParser):
    """Start tags, and the text of scripts and styles, as an HTML parser sees them."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.tags: list[tuple[str, dict[str, str | None]]] = []
        self.texts: list[tuple[str, str]] = []
        self.feed(text)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.tags.append((tag, dict(attrs)))

    def handle_data(self, data: str) -> None:
        if self.cdata_elem is not None:
            self.texts.append((self.cdata_elem, data))


def page(**changes: object) -> str:
    arguments: dict[str, object] = {"title": "t", "entry": "report", "body": "<main></main>", "data": {}}
    return build_page(**{**arguments, **changes})  # type: ignore[arg-type]


def test_hostile_names_stay_data() -> None:
    data = {"name": HOSTILE, "number": 0.1}
    found = Elements(page(title=HOSTILE, data=data))
    names = [tag for tag, _ in found.tags]
    assert names.count("script") == 3
    assert "img" not in names
    kept = next(text for tag, text in found.texts if tag == "script")
    assert json.loads(kept) == data


def test_the_policy_names_exactly_what_the_page_carries() -> None:
    found = Elements(page())
    (policy,) = [attrs["content"] for tag, attrs in found.tags if attrs.get("http-equiv") == "Content-Security-Policy"]
    assert policy.startswith("default-src 'none'; ")
    assert "unsafe" not in policy
    assert "connect-src" not in policy
    run = [text for tag, text in found.texts if tag == "style" or (tag == "script" and not text.startswith("{"))]
    hashes = {base64.b64encode(hashlib.sha256(text.encode()).digest()).decode() for text in run}
    assert set(re.findall(r"'sha256-([^']+)'", policy)) == hashes
    assert len(hashes) == 3


def test_only_a_live_page_may_connect() -> None:
    assert "connect-src 'self'" in page(connects=True)


def test_blobs_come_back() -> None:
    raw = bytes(range(256)) * 100
    found = re.search(
        r'<script type="text/plain" id="blob-part" data-kind="raw">([^<]*)</script>', page(blobs={"part": raw})
    )
    assert zlib.decompress(base64.b64decode(found[1])) == raw


def test_the_only_addresses_are_names_of_languages() -> None:
    addresses = set(re.findall(r"https?://[^\"'`\s)]+", page()))
    assert addresses == {"http://www.w3.org/2000/svg", "http://www.w3.org/1999/xhtml"}


def test_numbers_without_a_value_are_refused() -> None:
    with pytest.raises(ValueError, match="Out of range"):
        page(data={"a": float("nan")})
