# SPDX-License-Identifier: MIT
"""The preference page: which `wpcal` is started, found and tested there."""

from __future__ import annotations

from .client import Client, Executable, Failure, command_of, found_executables, how_to_install, preferred, set_preferred
from .document.session import stop_sessions
from .qt import QtCore, widgets
from .words import translate

GOOD, BAD = "color: #1b7f4b", "color: #b00020"


class PreferencePage:
    """The page in FreeCAD's preferences. FreeCAD makes it, shows `form`, and calls the two methods."""

    def __init__(self, _parent: object = None) -> None:
        self.form = widgets().QWidget()
        self.form.setWindowTitle("wpcal")
        self._client: Client | None = None
        layout = widgets().QVBoxLayout(self.form)
        box = widgets().QGroupBox(translate("Executable of wpcal"))
        inside = widgets().QVBoxLayout(box)
        self.edit = widgets().QLineEdit()
        self.edit.setObjectName("wpcal_executable")
        self.edit.setPlaceholderText(translate("empty: the first wpcal that is found"))
        buttons = widgets().QHBoxLayout()
        for text, name, action in (
            ("Find", "wpcal_find", self.find),
            ("Choose …", "wpcal_choose", self.choose),
            ("Test", "wpcal_test", self.test),
        ):
            button = widgets().QPushButton(translate(text))
            button.setObjectName(name)
            button.clicked.connect(lambda _checked=False, action=action: action())
            buttons.addWidget(button)
        self.answer = widgets().QLabel()
        self.answer.setObjectName("wpcal_answer")
        self.answer.setWordWrap(True)
        self.answer.setTextFormat(QtCore.Qt.PlainText)
        self.answer.setTextInteractionFlags(QtCore.Qt.TextSelectableByMouse)
        inside.addWidget(self.edit)
        inside.addLayout(buttons)
        inside.addWidget(self.answer)
        layout.addWidget(box)
        layout.addStretch(1)

    def loadSettings(self) -> None:
        """Show the preference."""
        self.edit.setText(preferred())

    def saveSettings(self) -> None:
        """Keep the preference. The next question starts wpcal anew if it has changed."""
        if self.edit.text().strip() != preferred():
            set_preferred(self.edit.text())
            stop_sessions()

    def find(self) -> None:
        """Take the first wpcal that is found, and test it."""
        found = next(found_executables(), None)
        if found is None:
            self._say(how_to_install(), is_good=False)
            return
        self.edit.setText(found.command[0])
        self.test()

    def choose(self) -> None:
        """Ask for the file."""
        path = widgets().QFileDialog.getOpenFileName(self.form, translate("Executable of wpcal"), self.edit.text())[0]
        if path:
            self.edit.setText(path)
            self.test()

    def test(self) -> None:
        """Start the wpcal of the line and ask for its version."""
        text = self.edit.text().strip()
        executable = Executable(command_of(text), translate("this line")) if text else next(found_executables(), None)
        self._end()
        self._client = Client(lambda: executable)
        self._say(translate("wpcal starts …"), is_good=True)
        self._client.call("hello", on_result=self._works, on_failure=self._fails)

    def _works(self, answer: dict[str, object]) -> None:
        text = translate("wpcal {version} answers.").format(version=answer["wpcal"])
        self._say(text, is_good=True)
        self._end()

    def _fails(self, failure: Failure) -> None:
        self._say(failure.text, is_good=False)
        self._end()

    def _end(self) -> None:
        client, self._client = self._client, None
        if client is not None:
            QtCore.QTimer.singleShot(0, client.stop)

    def _say(self, text: str, *, is_good: bool) -> None:
        self.answer.setText(text)
        self.answer.setStyleSheet(GOOD if is_good else BAD)
