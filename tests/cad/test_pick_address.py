"""Where the picker's page can be reached, and who sees its secret."""

import stat
from pathlib import Path

import pytest
import segno

from cad.pick.address import BLOCKS, HTTP_PORT, listen, opening_file, qr_code
from wpcal.core.errors import InputError

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
