"""The arc of a language without arc instructions: an output switches it, or two functions that the user has."""

from __future__ import annotations

from dataclasses import dataclass

from wpcal.controllers.arc_settings import ArcSettings
from wpcal.controllers.arc_values import end_time_s, require_no_weave
from wpcal.controllers.program import WeldPath


@dataclass(frozen=True, slots=True)
class ArcSwitch:
    """How one language switches the arc.

    Parameters
    ----------
    language : str
        For messages.
    start, end : str
        Calls of the functions; ``{job}`` is the job.
    on, off : str
        Instructions that set the output ``{output}``.
    wait : str
        Instruction that waits for ``{seconds}``.
    """

    language: str
    start: str
    end: str
    on: str
    off: str
    wait: str

    def start_lines(self, path: WeldPath, arc: ArcSettings) -> list[str]:
        """Return the lines that start the arc.

        Raises
        ------
        InputError
            When the weld data states a weave, which the language cannot carry out.
        """
        require_no_weave(path, language=self.language)
        call = self.start if arc.output is None else self.on
        switch = call.format(job=path.values.job or 0, output=arc.output)
        return [f"  {switch}", *self._wait(path.values.start_delay_s or 0.0)]

    def end_lines(self, path: WeldPath, arc: ArcSettings) -> list[str]:
        """Return the lines that end the arc."""
        switch = (self.end if arc.output is None else self.off).format(output=arc.output)
        return [*self._wait(end_time_s(path)), f"  {switch}"]

    def _wait(self, seconds: float) -> list[str]:
        return [f"  {self.wait.format(seconds=f'{seconds:g}')}"] if seconds > 0.0 else []
