# SPDX-License-Identifier: MIT
"""What all task panels have: a line of messages, progress with Cancel, and questions to wpcal."""

from __future__ import annotations

from typing import Any, Callable

import FreeCAD
import FreeCADGui

from ..client import Failure
from ..client.process import Result
from ..document.session import Ask, session_of
from ..qt import QtCore, number_of, widgets
from ..words import translate

PROGRESS_AFTER_MS = 400  #: A question that is answered sooner shows no progress bar: it would only flicker.
FORCE = "--force"  #: What wpcal advises if a folder has a result; a panel has a box for it.


class TaskPanel:
    """Base of the task panels. A subclass names its title and builds its widgets in `build`."""

    title = ""
    replace: Any = None  #: Whether a result that exists may be replaced.
    options: Any = None  #: The form with the options of the command.

    def __init__(self, document: Any) -> None:
        self.document = document
        self.session = session_of(document)
        self._asks: list[Ask] = []
        self._is_closed = False
        self.form = widgets().QWidget()  #: What FreeCAD shows.
        self.form.setWindowTitle(translate(self.title))
        outer = widgets().QVBoxLayout(self.form)
        self.body = widgets().QVBoxLayout()  #: The place of the subclass's widgets.
        outer.addLayout(self.body)
        outer.addWidget(self._message_line())
        outer.addLayout(self._progress_line())
        self._documents_end = _DocumentsEnd(document, self.reject)
        self.build()
        self.form.destroyed.connect(lambda *_: self._end())

    def build(self) -> None:
        """Make the widgets of the panel, in `body`."""
        raise NotImplementedError

    def closed(self) -> None:
        """Take away what the panel had put into the view or into FreeCAD's selection."""

    # -- questions --------------------------------------------------------------------------------------------------

    def ask(self, method: str, params: dict[str, Any] | None, on_result: Result, *, quiet: bool = False) -> Ask:
        """Ask wpcal about the part, with progress and Cancel below the widgets; a failure is shown as a message."""
        on_progress = None if quiet else self._show_progress
        return self._follow(
            lambda done, failed: self.session.ask(
                method, params, on_result=done, on_failure=failed, on_progress=on_progress
            ),
            on_result,
            quiet,
        )

    def open_part(self, on_result: Result) -> Ask:
        """Open the part of the document in wpcal; the result has its features."""
        return self._follow(
            lambda done, failed: self.session.open(on_result=done, on_failure=failed, on_progress=self._show_progress),
            on_result,
            False,
        )

    def ask_plain(self, method: str, params: dict[str, Any] | None, on_result: Result) -> Ask:
        """Ask wpcal something that needs no part, for example about a result folder."""

        def start(done: Any, failed: Any) -> Ask:
            ask = Ask(done, failed)
            ask.request = self.session.client.call(
                method, params, on_result=ask.succeed, on_failure=ask.fail, on_progress=self._show_progress
            )
            return ask

        return self._follow(start, on_result, False)

    def _follow(self, start: Any, on_result: Result, quiet: bool) -> Ask:
        asks: list[Ask] = []

        def end() -> bool:
            if asks[0] not in self._asks:
                return False
            self._asks.remove(asks[0])
            if not self._asks:
                self._stop_progress()
            return True

        def done(result: Any) -> None:
            if end():
                on_result(result)

        def failed(failure: Failure) -> None:
            if end():
                self.failed(failure)

        if not quiet:
            self.say("")  # what was said before belongs to an earlier question
        asks.append(start(done, failed))
        self._asks.append(asks[0])
        if not quiet:
            self._clock.start(PROGRESS_AFTER_MS)
        return asks[0]

    def failed(self, failure: Failure) -> None:
        """Show why there is no answer."""
        text = translate("Cancelled.") if failure.is_cancelled else failure.text
        if self.replace is not None and failure.data.get("hint") == FORCE:
            text = f"{failure.message}\n{translate('Tick')}: {self.replace.text()}"
        self.say(text, is_error=True)

    @property
    def is_busy(self) -> bool:
        """Whether a question is not answered yet."""
        return bool(self._asks)

    def cancel(self) -> None:
        """Cancel every question that is not answered yet."""
        for ask in list(self._asks):
            ask.cancel()

    # -- messages ---------------------------------------------------------------------------------------------------

    def worded(self, text: str) -> str:
        """Return a text of wpcal with the names of the panel's own fields."""
        return text if self.options is None else str(self.options.with_labels(text))

    def say(self, text: str, *, is_error: bool = False) -> None:
        """Show a message below the widgets; an empty text removes it."""
        self.message.setText(self.worded(text))
        self.message.setStyleSheet("color: #b00020" if is_error else "")
        self.message.setVisible(bool(text))

    def _message_line(self) -> Any:
        self.message = widgets().QLabel()
        self.message.setWordWrap(True)
        self.message.setTextFormat(QtCore.Qt.PlainText)
        self.message.setTextInteractionFlags(QtCore.Qt.TextSelectableByMouse)
        self.message.hide()
        return self.message

    def _progress_line(self) -> Any:
        line = widgets().QHBoxLayout()
        self.progress = widgets().QProgressBar()
        self.progress_text = widgets().QLabel()
        self.cancel_button = widgets().QPushButton(translate("Cancel"))
        self.cancel_button.clicked.connect(self.cancel)
        for widget in (self.progress_text, self.progress, self.cancel_button):
            widget.hide()
            line.addWidget(widget)
        self._clock = QtCore.QTimer()
        self._clock.setSingleShot(True)
        self._clock.timeout.connect(lambda: self._show_progress(translate("wpcal works …"), None))
        return line

    def _show_progress(self, text: str, fraction: float | None) -> None:
        if not self._asks:
            return
        self._clock.stop()
        self.progress_text.setText(text)
        self.progress.setRange(0, 0 if fraction is None else 1000)
        if fraction is not None:
            self.progress.setValue(int(fraction * 1000))
        for widget in (self.progress_text, self.progress, self.cancel_button):
            widget.show()

    def _stop_progress(self) -> None:
        self._clock.stop()
        for widget in (self.progress_text, self.progress, self.cancel_button):
            widget.hide()

    # -- FreeCAD's task dialog --------------------------------------------------------------------------------------

    def getStandardButtons(self) -> int:
        """Return the buttons above the panel: Close."""
        return number_of(widgets().QDialogButtonBox.Close)

    def reject(self) -> bool:
        """Close the panel."""
        self._stop_progress()
        self._end()
        FreeCADGui.Control.closeDialog()
        return True

    def _end(self) -> None:
        """Give up what is asked and watched. FreeCAD also takes a panel away without asking `reject`."""
        if self._is_closed:
            return
        self._is_closed = True
        self._documents_end.stop()
        self._clock.stop()
        asks, self._asks = self._asks, []
        for ask in asks:
            ask.cancel()
        self.closed()

    def isAllowedAlterSelection(self) -> bool:
        """The user may select while the panel is open."""
        return True

    def isAllowedAlterView(self) -> bool:
        """The user may turn the view while the panel is open."""
        return True

    def isAllowedAlterDocument(self) -> bool:
        """Undo and Redo work while the panel is open."""
        return True


class _DocumentsEnd:
    """Closes a panel whose document is closed. A document observer of FreeCAD."""

    def __init__(self, document: Any, close: Callable[[], Any]) -> None:
        self._name, self._close = document.Name, close
        FreeCAD.addDocumentObserver(self)

    def stop(self) -> None:
        """Hear no more."""
        FreeCAD.removeDocumentObserver(self)

    def slotDeletedDocument(self, document: Any) -> None:
        """Close the panel while the document is still there."""
        if document.Name == self._name:
            self._close()


def show_panel(panel: Any) -> Any:
    """Show a task panel; one that is open is closed first."""
    if FreeCADGui.Control.activeDialog():
        FreeCADGui.Control.closeDialog()
    FreeCADGui.Control.showDialog(panel)
    FreeCAD.Console.PrintLog(f"wpcal: panel {type(panel).__name__}\n")
    return panel
