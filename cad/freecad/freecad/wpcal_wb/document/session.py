# SPDX-License-Identifier: MIT
"""The session of a document: its part as wpcal has it open, and the questions about it.

All documents share one child process. A session opens its part there when a question needs it: again after a change of
the part, and after the process was started anew.
"""

from __future__ import annotations

import tempfile
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any, Callable, Iterator

import FreeCAD

from ..client import Client, Failure, Request
from ..client.process import Failed, Progress, Result
from ..qt import QtCore, application, wait_until
from . import export
from .kinds import Kind, object_of

Ready = Callable[[], None]


class Ask:
    """A question of a session. It may take several requests: the part is opened first if necessary."""

    def __init__(self, on_result: Result | None, on_failure: Failed | None) -> None:
        self._on_result = on_result
        self._on_failure = on_failure
        self.request: Request | None = None
        self.is_done = False
        self.is_cancelled = False
        self.result: Any = None
        self.failure: Failure | None = None

    def cancel(self) -> None:
        """Give up. The question fails with the kind `Cancelled`."""
        self.is_cancelled = True
        if self.request is not None:
            self.request.cancel()

    def wait(self, seconds: float = 600.0) -> Any:
        """Wait for the answer and return it. For scripts and tests; a window would freeze.

        Raises `RuntimeError` when there is no answer.
        """
        if not wait_until(lambda: self.is_done, seconds):
            raise RuntimeError(f"wpcal did not answer in {seconds:g} s")
        if self.failure is not None:
            raise RuntimeError(f"{self.failure.kind}: {self.failure.text}")
        return self.result

    def succeed(self, result: Any) -> None:
        """Take the answer."""
        self.is_done, self.result = True, result
        if self._on_result is not None:
            self._on_result(result)

    def fail(self, failure: Failure) -> None:
        """Take the reason why there is none."""
        self.is_done, self.failure = True, failure
        if self._on_failure is not None:
            self._on_failure(failure)


class Session:
    """What wpcal knows of one document."""

    def __init__(self, document: Any, client: Client) -> None:
        self.document = document
        self.client = client
        self.part: export.ExportedPart | None = None  #: The part as it was written last.
        self.opened: dict[str, Any] | None = None  #: The answer of `open`: features, solids, members, notes.
        self._opened_in = 0
        self._opened_path: Path | None = None
        self._changes = export.Changes(document)
        self._written_at = -1
        self._written_names: list[str] = []
        self._folder = tempfile.TemporaryDirectory(prefix="wpcal-")  # removed also when FreeCAD ends
        self._files = 0

    def chosen(self) -> list[Any]:
        """Return the objects that the seams belong to; empty for the whole document."""
        seams = object_of(self.document, Kind.SEAMS)
        return list(seams.Objects) if seams is not None else []

    @contextmanager
    def own_changes(self) -> Iterator[None]:
        """Change objects that are no part of the model, such as links to it: the part is not written again."""
        self._changes.is_paused = True
        try:
            yield
        finally:
            self._changes.is_paused = False

    def write_part(self) -> export.ExportedPart:
        """Return the part as a STEP file; it is written again only after a change.

        Raises `NothingToExportError` when there is no solid.
        """
        objects = export.part_objects(self.document, self.chosen())
        names = [obj.Name for obj in objects]
        if self.part is not None and self._written_at == self._changes.count and names == self._written_names:
            return self.part
        self._files += 1
        written = export.export_part(objects, Path(self._folder.name) / f"part-{self._files}.step")
        self._written_at, self._written_names = self._changes.count, names
        if self.part is not None and written.hash == self.part.hash:  # changed and changed back
            written = written._replace(path=self.part.path)
        self.part = written
        return written

    def ask(
        self,
        method: str,
        params: dict[str, Any] | None = None,
        *,
        on_result: Result | None = None,
        on_failure: Failed | None = None,
        on_progress: Progress | None = None,
    ) -> Ask:
        """Ask wpcal about the part; `handle` is added to the parameters.

        The callbacks are called later, by Qt's event loop; `NothingToExportError` becomes a `Failure` too.
        """
        ask = Ask(on_result, on_failure)

        def send() -> None:
            if ask.is_cancelled:
                ask.fail(Failure("Cancelled", ""))
                return
            handle = (self.opened or {}).get("handle")
            ask.request = self.client.call(
                method,
                {"handle": handle, **(params or {})},
                on_result=ask.succeed,
                on_failure=ask.fail,
                on_progress=on_progress,
            )

        self._open(ask, send, on_progress)
        return ask

    def open(
        self, *, on_result: Result | None = None, on_failure: Failed | None = None, on_progress: Progress | None = None
    ) -> Ask:
        """Open the part; the result is the answer of `open`, with the features."""
        ask = Ask(on_result, on_failure)
        self._open(ask, lambda: ask.succeed(self.opened), on_progress)
        return ask

    def _open(self, ask: Ask, ready: Ready, on_progress: Progress | None) -> None:
        application()
        try:
            part = self.write_part()
        except (ValueError, OSError, RuntimeError) as error:
            failure = Failure("InputError", str(error))
            QtCore.QTimer.singleShot(0, lambda: ask.fail(failure))
            return
        is_open = self.opened is not None and self._opened_in == self.client.starts and self.client.is_running
        if is_open and self._opened_path == part.path:
            QtCore.QTimer.singleShot(0, ready)
            return
        if is_open and self.opened is not None:
            self.client.call("close", {"handle": self.opened["handle"]})
        self.opened = None

        def take(result: dict[str, Any]) -> None:
            self.opened, self._opened_in, self._opened_path = result, self.client.starts, part.path
            ready()

        ask.request = self.client.call(
            "open", {"path": str(part.path)}, on_result=take, on_failure=ask.fail, on_progress=on_progress
        )

    def close(self) -> None:
        """Forget the part and remove its files."""
        self._changes.stop()
        if self.opened is not None and self.client.is_running and self._opened_in == self.client.starts:
            self.client.call("close", {"handle": self.opened["handle"]})
        self.opened = None
        with suppress(OSError):  # Windows keeps a file that wpcal has open; FreeCAD's end removes it
            self._folder.cleanup()


class _Sessions:
    """The sessions of all open documents. A document observer of FreeCAD."""

    def __init__(self) -> None:
        self._sessions: dict[str, Session] = {}
        self.client: Client | None = None

    def shared_client(self) -> Client:
        if self.client is None:
            self.client = Client()
            application().aboutToQuit.connect(self.stop)
        return self.client

    def of(self, document: Any) -> Session:
        if document.Name not in self._sessions:
            self._sessions[document.Name] = Session(document, self.shared_client())
        return self._sessions[document.Name]

    def slotDeletedDocument(self, document: Any) -> None:
        """Close the session of a document that is closed."""
        session = self._sessions.pop(document.Name, None)
        if session is not None:
            session.close()

    def stop(self) -> None:
        """End the process, as FreeCAD ends."""
        for session in self._sessions.values():
            session.close()
        self._sessions.clear()
        if self.client is not None:
            self.client.stop()


_SESSIONS = _Sessions()
FreeCAD.addDocumentObserver(_SESSIONS)


def session_of(document: Any) -> Session:
    """Return the session of a document; it is made by the first call."""
    return _SESSIONS.of(document)


def start_client() -> None:
    """Start wpcal now: it loads its CAD kernel while the user looks for the button. A failure is told by the panel."""
    _SESSIONS.shared_client().call("hello")


def stop_sessions() -> None:
    """End wpcal. The next question starts it again, as the preferences say then."""
    _SESSIONS.stop()
