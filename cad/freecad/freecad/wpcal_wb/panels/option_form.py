# SPDX-License-Identifier: MIT
"""A form for the options of a command, made from what `wpcal rpc` says of them.

A field that is empty, or shows what it showed first, is not sent: then wpcal's own default counts.
"""

from __future__ import annotations

import re
from typing import Any, Callable, Mapping, Sequence

from ..qt import QtCore, widgets
from ..words import translate

_FLAG = re.compile(r"(['\"]?)--([a-z][a-z0-9-]*[a-z0-9])\1")
DEFAULT = ""  #: The first choice of a list: wpcal decides.


class OptionForm:
    """The fields of the options of one command."""

    def __init__(self, *, first: Mapping[str, str], left_out: Sequence[str] = (), switches: Sequence[str] = ()) -> None:
        """Make an empty form."""
        self._first, self._left_out, self._switches = first, left_out, switches
        self.is_filled = False
        self._fields: dict[str, _Field] = {}
        self._wanted: dict[str, Any] = {}
        self.changed: Callable[[], None] | None = None  #: Called after a field was changed, without arguments.
        self.widget = widgets().QWidget()
        outer = widgets().QVBoxLayout(self.widget)
        outer.setContentsMargins(0, 0, 0, 0)
        self._near, near = _form()
        self._rest, rest = _form()
        self.more = widgets().QCheckBox(translate("More options"))
        self.more.toggled.connect(rest.setVisible)
        for widget in (near, self.more, rest):
            outer.addWidget(widget)
        self.more.hide()
        rest.hide()

    def fill(self, options: Sequence[Mapping[str, Any]]) -> None:
        """Make the fields; `options` is the answer of the request of the same name."""
        by_name = {option["name"]: dict(option) for option in options if option["name"] not in self._left_out}
        for name in self._switches:
            if name in by_name:
                by_name[name].update(type="boolean", default=False)
        names = [name for name in self._first if name in by_name]
        names += [name for name in by_name if name not in names]
        for name in names:
            if name in self._fields:
                continue
            label = translate(self._first[name]) if name in self._first else _label_of(name)
            field = _Field(by_name[name], label, self._tell)
            self._fields[name] = field
            layout = self._near if name in self._first else self._rest
            layout.addRow(field.label, field.widget)
        self.more.setVisible(any(name not in self._first for name in names))
        self.is_filled = True
        self.set_values(self._wanted)

    def values(self) -> dict[str, Any]:
        """Return the options that the user gave.

        Raises `ValueError` if a field is not a number and should be one; the message names it.
        """
        found = {name: field.value() for name, field in self._fields.items()}
        return {name: value for name, value in found.items() if value is not None}

    def set_values(self, values: Mapping[str, Any]) -> None:
        """Show options as given; those before `fill` are shown then."""
        self._wanted = dict(values)
        for name, field in self._fields.items():
            field.show(values.get(name))

    def with_labels(self, text: str) -> str:
        """Return a text of wpcal with the labels of the fields instead of the options (`--tack-mm`) of this form."""

        def label(found: re.Match[str]) -> str:
            field = self._fields.get(found.group(2).replace("-", "_"))
            return found.group() if field is None else f"“{field.label.text()}”"

        return _FLAG.sub(label, text)

    def field(self, name: str) -> Any:
        """Return the widget of an option."""
        return self._fields[name].widget

    def _tell(self) -> None:
        if self.changed is not None:
            self.changed()


class _Field:
    """One option: a label, a widget, and its value."""

    def __init__(self, option: Mapping[str, Any], label: str, changed: Callable[[], None]) -> None:
        self._option = option
        self.label = widgets().QLabel(label)
        self.label.setToolTip(_tip(option))
        if option["type"] == "boolean":
            self.widget = widgets().QCheckBox()
            self.widget.toggled.connect(lambda _on: changed())
        elif option.get("choices") and not option.get("repeated"):
            self.widget = widgets().QComboBox()
            self.widget.addItems([DEFAULT, *map(str, option["choices"])])
            self.widget.currentIndexChanged.connect(lambda _index: changed())
        else:
            self.widget = widgets().QLineEdit()
            self.widget.setPlaceholderText(_default_of(option))
            self.widget.editingFinished.connect(changed)
        self.widget.setObjectName(f"wpcal_{option['name']}")
        self.widget.setToolTip(_tip(option))
        self.show(None)

    def show(self, value: Any) -> None:
        """Show a value; None is the default."""
        self.widget.blockSignals(True)  # Qt's own signature
        if self._option["type"] == "boolean":
            self.widget.setChecked(bool(self._option["default"] if value is None else value))
        elif hasattr(self.widget, "setCurrentText"):
            self.widget.setCurrentText(DEFAULT if value is None else str(value))
        else:
            is_list = isinstance(value, (list, tuple))
            self.widget.setText("" if value is None else "; ".join(map(str, value)) if is_list else _text(value))
        self.widget.blockSignals(False)

    def value(self) -> Any:
        if self._option["type"] == "boolean":
            on = self.widget.isChecked()
            return on if on != bool(self._option["default"]) else None
        if hasattr(self.widget, "currentText"):
            return self._converted(self.widget.currentText()) if self.widget.currentText() else None
        text = self.widget.text().strip()
        if not text:
            return None
        if self._option.get("repeated"):
            return [self._converted(word.strip()) for word in text.split(";") if word.strip()]
        return self._converted(text)

    def _converted(self, text: str) -> Any:
        kinds: dict[str, Callable[[str], Any]] = {"number": float, "integer": int}
        try:
            return kinds.get(self._option["type"], str)(text.replace(",", ".") if self._is_number else text)
        except ValueError:
            kind = translate("a whole number") if self._option["type"] == "integer" else translate("a number")
            message = translate("{name}: expected {kind}, got {text}")
            raise ValueError(message.format(name=self.label.text(), kind=kind, text=text)) from None

    @property
    def _is_number(self) -> bool:
        return self._option["type"] in ("number", "integer")


def _form() -> list[Any]:
    widget = widgets().QWidget()
    layout = widgets().QFormLayout(widget)
    layout.setContentsMargins(0, 0, 0, 0)
    layout.setFieldGrowthPolicy(widgets().QFormLayout.ExpandingFieldsGrow)
    layout.setRowWrapPolicy(widgets().QFormLayout.WrapLongRows)
    layout.setLabelAlignment(QtCore.Qt.AlignLeft)
    return [layout, widget]


def _label_of(name: str) -> str:
    """Return the name of an option as a person reads it, with its unit in brackets."""
    words = name.split("_")
    units = {("mm", "s"): "mm/s", ("mm", "min"): "mm/min"}
    if tuple(words[-2:]) in units:
        return f"{' '.join(words[:-2])} ({units[(words[-2], words[-1])]})"
    if words[-1] in ("mm", "deg", "s") and len(words) > 1:
        return f"{' '.join(words[:-1])} ({words[-1]})"
    return " ".join(words)


def _tip(option: Mapping[str, Any]) -> str:
    more = translate("Several: separate them with semicolons.") if option.get("repeated") else ""
    return " ".join(filter(None, [str(option.get("help") or ""), more]))


def _default_of(option: Mapping[str, Any]) -> str:
    default = option.get("default")
    return "" if default in (None, [], "") else _text(default)


def _text(value: Any) -> str:
    return f"{value:g}" if isinstance(value, float) else str(value)
