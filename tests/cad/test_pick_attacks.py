"""Attacks on the picker's server, one row each: what comes back, and that the table stays as it is.

`{path}` is the secret path of the page, `{host}` its address and port.
"""

import json
import re
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import pytest
from picker_attacks import BODIES, CLOSED, HEADS, HOSTS, KINDS, METHODS, NAMES, ORIGINS, OWN, PATHS, PLACES, READABLE
from picker_server import PAGE, Running, serving

from cad.session.part import PickPart
from cad.session.rows import NEW_COLUMNS

EMPTY = {"columns": list(NEW_COLUMNS), "rows": []}
ACTIONS = (
    "fit",
    "suggest",
    "read",
    "table",
    "keep",
    "save",
    "open",
    "seams",
    "decide",
    "solid",
    "outline",
    "promise",
    "touch",
)
ROW = ["V2", "812.29", "-240.62", "165.80", "V2", "yes"]
KEYED = {"columns": list(NEW_COLUMNS), "rows": [ROW], "keys": ["a"]}
LONGEST_ANSWER = 20_000


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("pick")


@pytest.fixture(scope="module")
def running(tee_for_the_picker: PickPart, folder: Path) -> Iterator[Running]:
    with serving(tee_for_the_picker, folder / "taught.csv") as found:
        yield found


def filled(text: str, running: Running) -> bytes:
    """Put the secret path and the address into a request; it is Latin-1 on the wire."""
    return text.replace("{path}", running.path).replace("{host}", running.host).encode("latin-1", "replace")


def statuses(answer: bytes) -> list[int]:
    return [int(found) for found in re.findall(rb"HTTP/1\.1 (\d{3})", answer)] or [CLOSED]


@pytest.fixture(autouse=True)
def harmless(running: Running, folder: Path) -> Iterator[None]:
    """After every attack the table is as before, no file was made, and the page's own request is answered."""
    before = running.table.changes_since(-1)
    yield
    assert running.table.changes_since(-1) == before
    assert list(folder.iterdir()) == []
    assert running.post("fit", EMPTY)[0] == 200


@pytest.mark.parametrize("place", PLACES)
@pytest.mark.parametrize("method", METHODS, ids=lambda method: method[:10])
def test_methods_on_paths(running: Running, method: str, place: str) -> None:
    """Without the header Origin nothing but the page itself is had."""
    answer = running.send(filled(f"{method} {place} HTTP/1.1\r\nHost: {{host}}\r\nConnection: close\r\n\r\n", running))
    (status,) = statuses(answer)
    if (method, place) in (("GET", "{path}"), ("HEAD", "{path}")):
        assert status == 200
        assert (PAGE.encode() in answer) == (method == "GET")
    else:
        assert status in (CLOSED, 400, 403, 404, 405)
        assert PAGE.encode() not in answer
    assert len(answer) < LONGEST_ANSWER


@pytest.mark.parametrize("path", PATHS, ids=lambda path: ascii(path)[:30])
def test_paths(running: Running, path: str) -> None:
    """No path but its own leads to the page, and none to a file."""
    answer = running.send(filled(f"GET {path} HTTP/1.1\r\nHost: {{host}}\r\nConnection: close\r\n\r\n", running))
    own = path in ("{path}\0", "{path};x") or path.endswith("X: 1")
    assert set(statuses(answer)) <= {CLOSED, 307, 400, 404, 405, 414, 431} | ({200} if own else set())
    assert b"root:" not in answer
    assert len(answer) < LONGEST_ANSWER


def changed_tokens(path: str) -> Iterator[str]:
    token = path.strip("/")
    yield from (
        token[:-1],
        token + "x",
        token.swapcase(),
        token[::-1],
        token[1:],
        f"%20{token}",
        f"{token}%20",
        "A" * 24,
    )
    yield from (token.replace(token[0], "%41", 1), f"x/{token}", token[:12], f"{token}\u00e9", f'"{token}"')


def test_tokens(running: Running) -> None:
    for token in changed_tokens(running.path):
        for name in ("", "save"):
            answer = running.send(filled(f"GET /{token}/{name} HTTP/1.1\r\nHost: {{host}}\r\n\r\n", running))
            assert set(statuses(answer)) <= {400, 404}, token
            assert running.path.encode() not in answer


@pytest.mark.parametrize("host", HOSTS, ids=lambda host: ascii(host)[:30])
def test_hosts(running: Running, host: str | None) -> None:
    """A page under another name cannot reach the server, also if that name points here."""
    line = "" if host is None else f"Host: {host}\r\n"
    for head in (f"GET {{path}} HTTP/1.1\r\n{line}", f"GET {{path}} HTTP/1.0\r\n{line}"):
        answer = running.send(filled(f"{head}Connection: close\r\n\r\n", running))
        assert set(statuses(answer)) <= {CLOSED, 400, 421, 431}
        assert PAGE.encode() not in answer


@pytest.mark.parametrize("origin", ORIGINS, ids=lambda origin: ascii(origin)[:30])
def test_origins(running: Running, origin: str | None) -> None:
    body = json.dumps({"revision": 1, "shown": 1, "window": "w"})
    line = "" if origin is None else f"Origin: {origin}\r\n"
    head = f"POST {{path}}save HTTP/1.1\r\nHost: {{host}}\r\n{line}Content-Type: application/json\r\n"
    answer = running.send(filled(f"{head}Content-Length: {len(body)}\r\nConnection: close\r\n\r\n{body}", running))
    assert set(statuses(answer)) <= {400, 403}


@pytest.mark.parametrize("kind", KINDS, ids=lambda kind: ascii(kind)[:30])
def test_content_types(running: Running, kind: str | None) -> None:
    line = "" if kind is None else f"Content-Type: {kind}\r\n"
    head = f"POST {{path}}open HTTP/1.1\r\nHost: {{host}}\r\nOrigin: http://{{host}}\r\n{line}Content-Length: 2\r\n"
    answer = running.send(filled(f"{head}Connection: close\r\n\r\n{{}}", running))
    assert set(statuses(answer)) <= {CLOSED, 400, 415, 431}


@pytest.mark.parametrize("name", HEADS)
def test_heads(running: Running, name: str) -> None:
    """What is not a plain request is refused or closed; what can be read as one gets its own answer only."""
    answer = running.send(filled(HEADS[name] + "\r\n{}", running))
    assert set(statuses(answer)) <= {CLOSED, 400, 414, 421, 431, 501, 505} | ({200} if name in READABLE else set())
    assert len(answer) < LONGEST_ANSWER


def test_a_request_behind_another_is_judged_by_itself(running: Running) -> None:
    behind = "GET {path} HTTP/1.1\r\nHost: evil.example\r\nConnection: close\r\n\r\n"
    first = OWN + "Content-Length: 2\r\n\r\n{}"
    assert statuses(running.send(filled(first + behind, running), is_whole=True)) == [200, 421]
    chunked = OWN + "Transfer-Encoding: chunked\r\n\r\n2\r\n{}\r\n0\r\n\r\n"
    assert statuses(running.send(filled(chunked + behind, running), is_whole=True)) == [200, 421]
    wrong = OWN + "Transfer-Encoding: chunked\r\n\r\nzz\r\n{}\r\n"
    assert set(statuses(running.send(filled(wrong, running)))) <= {CLOSED, 400}


@pytest.mark.parametrize("name", BODIES)
def test_bodies(running: Running, name: str) -> None:
    """Each action answers in one line that is not our own fault."""
    body = BODIES[name]
    for action in ACTIONS:
        head = OWN.replace("fit", action, 1) + f"Content-Length: {len(body)}\r\nConnection: close\r\n\r\n"
        answer = running.send(filled(head, running) + body, is_whole=True)
        assert statuses(answer) == [200], action
        record = json.loads(answer.partition(b"\r\n\r\n")[2])
        if action in ("table", "open", "seams", "suggest", "promise") and "answer" in record:
            continue  # what is there, or the names of features, is all that these read
        message = record["fault"]["message"]
        assert message.isprintable(), action
        assert "internal error" not in message, (action, message)
        assert len(message) < 2000, action


@pytest.mark.parametrize("name", NAMES, ids=lambda name: ascii(name)[:20])
def test_names_to_save_as(tee_for_the_picker: PickPart, tmp_path: Path, name: str) -> None:
    """A name of a file beside the table is taken, a path is not."""
    inner = tmp_path / "in"
    inner.mkdir()
    with serving(tee_for_the_picker, inner / "taught.csv") as running:
        kept = {"revision": 1, "window": "w", "number": 1, "table": KEYED, "conflicts": []}
        revision = running.post("keep", kept)[1]["answer"]["revision"]
        before = {path.name for path in tmp_path.rglob("*")}
        given = {"revision": revision, "shown": revision, "window": "w", "name": name}
        record = running.post("save", given)[1]
    made = {path for path in tmp_path.rglob("*") if path.name not in before}
    if "fault" in record:
        assert not made
        assert record["fault"]["message"].isprintable()
        assert "internal error" not in record["fault"]["message"]
    assert all(path.parent == inner for path in made)
    assert not Path("/tmp/day-x.csv").exists()


def test_many_at_once(running: Running) -> None:
    """Requests that are answered, refused and broken, side by side."""
    rows = {"columns": list(NEW_COLUMNS), "rows": [ROW]}

    def one(number: int) -> Any:
        if number % 3 == 0:
            return running.post("fit", rows)[0]
        if number % 3 == 1:
            return running.post("save", EMPTY, Origin="http://evil.example")[0]
        return statuses(running.send(b"\x16\x03\x01" * number))[0]

    with ThreadPoolExecutor(30) as pool:
        found = list(pool.map(one, range(90)))
    assert found[0::3] == [200] * 30
    assert found[1::3] == [403] * 30
    assert set(found[2::3]) <= {CLOSED, 400}
