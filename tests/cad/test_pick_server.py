"""The picker's server answers its own page, and nobody else: where it can be reached, and who sees its secret."""

import base64
import socket
import stat
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import pytest
import segno
from picker_server import WHOLE_REQUEST_S, Running, serving

from cad.pick.address import BLOCKS, HTTP_PORT, LOCAL, listen, opening_file, qr_code
from cad.pick.server import LARGEST_BYTES
from cad.session.part import PickPart
from cad.session.rows import NEW_COLUMNS
from wpcal.core.errors import InputError

TEE = Path(__file__).parents[2] / "fixtures" / "tee" / "tee.step"
EMPTY = {"columns": list(NEW_COLUMNS), "rows": []}


@pytest.fixture(scope="module")
def running(tee_for_the_picker: PickPart, tmp_path_factory: pytest.TempPathFactory) -> Iterator[Running]:
    with serving(tee_for_the_picker, tmp_path_factory.mktemp("pick") / "taught.csv") as found:
        yield found


def test_the_page_answers_at_its_whole_address(running: Running) -> None:
    status, text, headers = running.ask("GET", running.path, {})
    assert (status, text) == (200, b"<!DOCTYPE html>the page")
    assert headers["Cache-Control"] == "no-store"
    assert headers["Content-Security-Policy"] == "frame-ancestors 'none'"
    assert not {"Access-Control-Allow-Origin", "Server"} & set(headers)


def test_only_what_the_page_uses_is_there(running: Running) -> None:
    assert running.ask("GET", running.path + "save", {})[0] == 405
    assert running.ask("PUT", running.path + "save", {"Origin": running.origin}, EMPTY)[0] == 405
    assert running.post("other", EMPTY)[0] == 404


def test_half_a_character_is_refused_and_a_whole_one_taken(running: Running) -> None:
    for text, said in (("\ud800", "is not JSON of Unicode text"), ("\U0001f600", "expected a number")):
        row = ["V1", "1", text, "3", "V1", "yes"]
        status, answer = running.post("fit", {"columns": list(NEW_COLUMNS), "rows": [row]})
        assert status == 200
        assert said in answer["fault"]["message"]


def test_a_giant_is_not_read_to_its_end(running: Running) -> None:
    status, answer = running.post("read", {"name": "a.csv", "base64": "A" * (LARGEST_BYTES + 1)})
    assert (status, answer["fault"]["message"]) == (200, "expected at most 8 MB")


HALVES = (
    b"",
    b"GET ",
    b"GET /x/ HTTP/1.1\r\nHost: ",
    b"POST {path}fit HTTP/1.1\r\nHost: {host}\r\nOrigin: http://{host}\r\nContent-Type: application/json\r\n"
    b"Content-Length: 90\r\n\r\n{{",
    b"GET {path} HTTP/1.1\r\nHost: {host}\r\n\r\nGET ",
)
"""Silence, a word, half a header, half a body, and half of a second request."""


def test_half_a_request_is_not_waited_for(running: Running) -> None:
    """Byte after byte does not make the server wait longer."""
    words = {"path": running.path, "host": running.host}

    def is_closed(half: bytes) -> bool:
        text = half.decode().format(**words).encode() if b"{path}" in half else half
        with socket.create_connection(("127.0.0.1", running.port), timeout=60) as connection:
            connection.sendall(text)
            connection.settimeout(WHOLE_REQUEST_S / 5)
            for _ in range(100):
                try:
                    if not connection.recv(65536):
                        return True
                except TimeoutError:
                    connection.sendall(b"x" if half else b"")
                except ConnectionError:
                    return True
        return False

    with ThreadPoolExecutor(len(HALVES)) as pool:
        closed = list(pool.map(is_closed, HALVES))
    assert [half for half, is_so in zip(HALVES, closed, strict=True) if not is_so] == []
    assert running.post("fit", EMPTY)[0] == 200


def test_control_characters_are_refused(running: Running) -> None:
    cells = ["V1\0", "V\x1b[31m1", "V\x7f", "V\x9b1"]
    for cell in cells:
        table = {"columns": list(NEW_COLUMNS), "rows": [[cell, "1", "2", "3", "V1", "yes"]], "keys": ["a"]}
        change = {"revision": running.table.changes_since(-1)["revision"], "window": "n", "number": 1, "table": table}
        for name, body in (("fit", table), ("keep", change)):
            fault = running.post(name, body)[1]["fault"]["message"]
            assert "contains a control character" in fault
            assert fault.isprintable()
        raw = f"name,x_mm,y_mm,z_mm\n{cell},1,2,3\n".encode()
        fault = running.post("read", {"name": "a.csv", "base64": base64.b64encode(raw).decode()})[1]["fault"]["message"]
        assert fault.startswith("a.csv, line 2, column name: ")
        assert fault.isprintable()


def test_rows_are_fitted(running: Running) -> None:
    taught = (TEE.parent / "taught.csv").read_text(encoding="utf-8").splitlines()
    columns = taught[0].split(",")
    rows = {"columns": [*columns, "feature"], "rows": [[*line.split(","), line.split(",")[0]] for line in taught[1:]]}
    status, answer = running.post("fit", rows)
    assert status == 200
    assert answer["answer"]["verdict"] == "PASS"


def test_a_port_that_is_taken_is_said(running: Running) -> None:
    with pytest.raises(InputError, match=f"port {running.port}: address already in use"):
        listen(LOCAL, running.port)


URL = "http://192.168.100.23:54321/abcdefghijklmnopqrstuvwx/"


def hosts_of(host: str) -> tuple[tuple[str, ...], bool]:
    found = listen(host, 0)
    port = found.socket.getsockname()[1]
    found.socket.close()
    return tuple(name.replace(str(port), "P") for name in found.hosts), found.is_local


def test_the_host_is_called_as_it_was_given_and_by_its_address() -> None:
    assert hosts_of("127.0.0.1") == (("127.0.0.1:P",), True)
    assert hosts_of("localhost")[0][0] == "localhost:P"


@pytest.mark.parametrize("host", ["0.0.0.0", "::", "no-such-host.invalid", "", "192.0.2.77", "a\0b", "x" * 300])
def test_what_is_not_one_address_of_this_machine_is_refused(host: str) -> None:
    with pytest.raises(InputError) as caught:
        listen(host, 0)
    assert str(caught.value).isprintable()


def test_the_port_of_http_is_left_out_by_browsers(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("socket.socket.getsockname", lambda _: ("127.0.0.1", HTTP_PORT))
    found = listen("127.0.0.1", 0)
    found.socket.close()
    assert found.hosts == ("127.0.0.1:80", "127.0.0.1")


def test_the_qr_code_is_that_of_the_address() -> None:
    lines = qr_code(URL).splitlines()
    modules = {block: pair for pair, block in BLOCKS.items()}
    rows = [[modules[block][half] for block in line] for line in lines for half in (0, 1)]
    expected = [[not dark for dark in row] for row in segno.make(URL, error="l", micro=False).matrix_iter(border=4)]
    assert rows[: len(expected)] == expected
    assert len(lines[0]) < 50


def test_the_browser_gets_a_file_that_only_this_user_reads() -> None:
    """The command line of a browser is shown to every user of the machine."""
    with opening_file(URL) as path:
        assert "abcdefgh" not in str(path)
        assert URL in path.read_text(encoding="utf-8")
        assert stat.S_IMODE(path.stat().st_mode) == 0o600
        assert stat.S_IMODE(path.parent.stat().st_mode) == 0o700
    assert not Path(path).exists()
