"""Parts of programs as text templates (Jinja2): a shop replaces ours with its own, file by file.

Each language has the templates `BLOCKS` beside its writer. A template gets names and gives lines. What wpcal decides
(the moves along a seam, the points, the declarations) is not in templates.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping, Sequence
from contextlib import nullcontext
from dataclasses import dataclass
from functools import cache
from importlib.resources import files
from pathlib import Path
from types import TracebackType
from typing import TYPE_CHECKING, Any, ClassVar, Protocol

from wpcal.controllers.language.naming import in_ascii
from wpcal.controllers.program import ControllerSettings, WeldPath, WeldProgram
from wpcal.controllers.registry import controllers, find_controller
from wpcal.core.errors import FormatError, InputError
from wpcal.core.input_file import read_bytes, require_folder
from wpcal.weld.values import VALUE_NAMES

if TYPE_CHECKING:
    from importlib.resources.abc import Traversable

    from jinja2 import Environment, Template

BLOCKS = ("header", "weld_start", "weld_end", "air_move", "joint_move", "footer")
"""The templates of a language, each a file ``BLOCK.txt``."""
TOUCH_BLOCKS = ("touch_on", "touch_off")  #: Those of languages with touch programs.
HOOKS = {
    "before_run": "{# Before the first move: check the gas, home the tool. #}\n",
    "after_run": "{# After the last move. #}\n",
    "before_weld": "{# Before the way to each seam: clean the torch, cut the wire. Names: seam, weld, speed_mm_s. #}\n",
    "after_weld": "{# After the way from each seam. Names: seam, weld, speed_mm_s. #}\n",
}
"""The templates of all languages for what shops do around a run and around a weld; ours are empty."""
ENDING = ".txt"


def _package(language: str) -> Traversable | None:
    """Return the folder of a controller's writer; None for a format that is no controller."""
    controller = find_controller(language)
    package = "" if controller is None else controller.writer.split(":")[0].rpartition(".")[0]
    return files(package) if package else None


def template_languages() -> tuple[str, ...]:
    """Return the names of the formats that have templates."""
    return tuple(controller.name for controller in controllers() if blocks_of(controller.name))


def blocks_of(language: str) -> tuple[str, ...]:
    """Return the templates that a format has; none for a format without templates."""
    package = _package(language)
    if package is None:
        return ()
    known = tuple(one for one in (*BLOCKS, *TOUCH_BLOCKS) if (package / "templates" / f"{one}{ENDING}").is_file())
    return (*known, *HOOKS) if known else ()


def shipped_templates(language: str) -> dict[str, str]:
    """Return the templates of wpcal for a language: names of files and texts.

    Raises `InputError` when the format has no templates.
    """
    package, blocks = _package(language), blocks_of(language)
    if package is None or not blocks:
        raise InputError(f"{language} has no templates; formats with templates: {', '.join(template_languages())}")
    folder = package / "templates"
    own = {block: HOOKS.get(block) or (folder / f"{block}{ENDING}").read_text(encoding="utf-8") for block in blocks}
    return {f"{block}{ENDING}": text for block, text in own.items()}


class Programmed(Protocol):
    """What the templates need to know of a program."""

    @property
    def controller(self) -> ControllerSettings:
        """Its `templates` is the folder of the user, with a folder per format."""

    @property
    def arc(self) -> object | None:
        """None if the program switches no arc."""


@dataclass(frozen=True, slots=True)
class Blocks:
    """The templates of one language that every program uses."""

    language: str  #: The name of the format.
    program: Programmed

    def header(self, about: Sequence[str]) -> list[str]:
        """Return the header: `about` are the lines about the program, wrapped for the language."""
        return self.lines("header", about=list(about))

    def footer(self) -> list[str]:
        """Return what ends the program."""
        return self.lines("footer")

    def air_move(self, point: str, *, speed: str, joint: bool = False) -> list[str]:
        """Return the move to a point off the seams."""
        return self.lines("air_move", needs=point, point=point, speed=speed, joint=joint)

    def joint_move(self, point: str, *, speed: str, zone: str = "") -> list[str]:
        """Return the move of a plan to joints; `zone` is empty where it stops, other arguments as of `air_move`."""
        return self.lines("joint_move", needs=point, point=point, speed=speed, zone=zone)

    def lines(self, block: str, *, needs: str = "", **names: Any) -> list[str]:
        """Return the lines of a template; without the point `needs` the torch would go another way than checked."""
        folder = self.program.controller.templates
        template, file = _template(self.language, block, folder)
        tool = self.program.controller.tool_name
        common = {"arc_on": self.program.arc is not None, "tool": tool, "program": self.program.controller.program_name}
        lines = [
            line.rstrip()
            for line in _rendered(template, file, {**common, **names}, is_own=folder is not None).splitlines()
        ]
        if needs and not any(needs in line for line in lines):
            what = f"writes no move to the point {needs[:60]}: the torch would go another way than the checked one"
            raise FormatError(what, path=file)
        return lines


def metres_per_second(mm_s: float) -> str:
    """Write a speed in m/s."""
    return f"{mm_s / 1000.0:g}"


class AirMoves:
    """Moves off seams and searches, as a language writes them."""

    post: Blocks
    air_mm_s: float
    speed_of: ClassVar[staticmethod[[float], str]]  #: Writes a speed in mm/s.

    @classmethod
    def written(cls, program: Any) -> dict[str, str]:
        """Return the files of a program; `InputError` when the language or the controller cannot hold it."""
        writer: Any = cls
        return writer(program).files()  # type: ignore[no-any-return]

    @property
    def air(self) -> str:
        """The speed of linear moves."""
        return self.speed_of(self.air_mm_s)

    @property
    def first(self) -> str:
        """The speed of the only joint move, to the first point."""
        return self.air

    def air_moves(self, points: Sequence[str]) -> list[str]:
        """Return linear moves."""
        return [line for point in points for line in self.post.air_move(point, speed=self.air)]


@dataclass(frozen=True, slots=True)
class Post(Blocks):
    """The templates of one language for a weld program. `language`: The name of the format."""

    program: WeldProgram

    def hook(self, name: str, path: WeldPath | None = None) -> list[str]:
        """Return what a shop does before or after a run, or the weld of a path."""
        about = {} if path is None else self._of_seam(path, list, 0)
        return self.lines(name, **{key: about[key] for key in ("seam", "weld", "speed_mm_s") if about})

    def weld_start(self, path: WeldPath, instructions: Callable[[], Sequence[str]], **names: Any) -> list[str]:
        """Return what is before the moves along a seam."""
        needs = "" if names.get("folds") else str(names.get("point", ""))
        return self.lines("weld_start", needs=needs, **self._of_seam(path, instructions, 0), **names)

    def weld_end(self, path: WeldPath, instructions: Callable[[], Sequence[str]], **names: Any) -> list[str]:
        """Return what is after the moves along a seam; as `weld_start`."""
        return self.lines("weld_end", **self._of_seam(path, instructions, 1), **names)

    def _of_seam(self, path: WeldPath, instructions: Callable[[], Sequence[str]], end: int) -> dict[str, Any]:
        return {
            "seam": in_ascii(path.seam.name),
            "weld": {name: getattr(path.values, name) for name in VALUE_NAMES},
            "speed_mm_s": self.program.weld_speed_mm_s(path),
            "mark": self.program.marks[end],
            "instructions": instructions if self.program.arc is not None else list,
        }


def _rendered(template: Template, file: str, names: Mapping[str, Any], *, is_own: bool) -> str:
    from jinja2.exceptions import SecurityError, TemplateError, UndefinedError

    from wpcal.controllers.language.limits import limited_steps

    try:
        with limited_steps() if is_own else nullcontext():
            return template.render(names)
    except UndefinedError as error:
        raise FormatError(_missing(str(error), names), path=file, line=_line(error, file)) from None
    except InputError:
        raise
    except RecursionError:
        raise FormatError("cannot be used: a macro calls itself too often", path=file) from None
    except (TemplateError, SecurityError, TypeError, ValueError, ArithmeticError, LookupError, MemoryError) as error:
        raise FormatError(f"cannot be used: {error}", path=file, line=_line(error, file)) from None


def _missing(error: str, names: Mapping[str, Any]) -> str:
    """Return the message about a name that a template uses and that is not there."""
    found = re.search(r"^'(?P<name>\w+)' is undefined$|'dict object' has no attribute '(?P<key>\w+)'", error)
    name, key = found.groups() if found is not None else (None, None)
    known = names.get("weld", names) if key else names
    what = f"there is no name {name or key!r}" if found is not None else error
    return f"{what}; names here: {', '.join(sorted(known))}"


def _line(error: BaseException, file: str) -> int | None:
    """Return the line of a template in which an error arose."""
    found, trace = None, error.__traceback__
    while isinstance(trace, TracebackType):
        if trace.tb_frame.f_code.co_filename == file:
            found = trace.tb_lineno
        trace = trace.tb_next
    return found


@cache
def _template(language: str, block: str, folder: Path | None) -> tuple[Template, str]:
    """Return a template and the name of its file: that of the user, or ours where he has none."""
    from jinja2.exceptions import TemplateSyntaxError

    name = f"{block}{ENDING}"
    if folder is not None:
        own = folder / language
        _refuse_unknown_files(own, language)
        if (own / name).is_file():
            try:
                text = read_bytes(own / name).decode("utf-8-sig")
                return _compiled(text, str(own / name)), str(own / name)
            except UnicodeDecodeError:
                raise FormatError("is not a UTF-8 text file", path=str(own / name)) from None
            except (RecursionError, MemoryError):
                raise FormatError("cannot be used: it is nested too deeply", path=str(own / name)) from None
            except TemplateSyntaxError as error:
                raise FormatError(str(error.message), path=str(own / name), line=error.lineno) from None
    return _compiled(shipped_templates(language)[name], name), name


def own_arc_templates(language: str, folder: Path) -> tuple[str, ...]:
    """Return the templates around a weld that a user's folder replaces by other texts than those of wpcal."""
    if not blocks_of(language):
        return ()
    names = [folder / language / f"{block}{ENDING}" for block in ("weld_start", "weld_end")]
    ours = shipped_templates(language)
    own = [path for path in names if path.is_file() and read_bytes(path).decode("utf-8-sig") != ours[path.name]]
    return tuple(map(str, own))


def _refuse_unknown_files(folder: Path, language: str) -> None:
    """Refuse a folder without templates, and one with a misspelt one, which would not be used.

    Raises `InputError` if it is so.
    """
    expected = [f"{block}{ENDING}" for block in blocks_of(language)]
    require_folder(folder, f"the templates {', '.join(expected)}, or some of them")
    for path in sorted(folder.glob(f"*{ENDING}")):
        if path.name not in expected:
            raise InputError(f"{path}: is no template; expected {', '.join(expected)}")


def _compiled(text: str, file: str) -> Template:
    environment = _environment()
    code = environment.compile(text, name=file, filename=file)
    return environment.template_class.from_code(environment, code, environment.make_globals(None), None)


NO_LINE = "\0"


def whole_template(language: str, name: str, names: Mapping[str, Any]) -> list[str]:
    """Return the lines of a template beside the writer of a format; a list among the names becomes as many lines."""
    package = _package(language)
    assert package is not None
    text = (package / f"{name}{ENDING}").read_text(encoding="utf-8")
    lines = _whole_environment().from_string(text).render(names).split("\n")
    return [line for line in lines[:-1] if line.strip() != NO_LINE]


def _as_lines(value: Any) -> Any:
    return ("\n".join(value) or NO_LINE) if isinstance(value, list) else value


@cache
def _whole_environment() -> Environment:
    return _environment().overlay(finalize=_as_lines)


@cache
def _environment() -> Environment:
    """Return the environment: a missing name is an error, and a template reaches nothing but its names."""
    from jinja2 import StrictUndefined

    from wpcal.controllers.language.limits import LimitedEnvironment

    return LimitedEnvironment(
        undefined=StrictUndefined, trim_blocks=True, lstrip_blocks=True, keep_trailing_newline=True, autoescape=False
    )
