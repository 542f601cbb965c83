"""`Watch`: reads a robot all the time, so that a key finds a position that has already stood still."""

from __future__ import annotations

import threading
import time
from collections import deque
from collections.abc import Callable
from functools import partial

from wpcal.core.errors import WpcalError
from wpcal.robot.links.judge import Accepted, ArmMovesError, RowJudge
from wpcal.robot.links.reading import LinkError, Reading, RobotLink

PERIOD_S = 0.08  #: Between readings: three fall into the time in which the arm must stand.
KEPT = 50  #: Readings kept, of the last four seconds at this period.
AGAIN_S = 0.5  #: Before a connection that was lost is opened again.
PATIENCE_S = 3.0  #: How long a key waits for an arm that moves.


class Watch:
    """A thread that reads one robot. The connection is opened again when it is lost."""

    def __init__(self, open_link: Callable[[], RobotLink], judge: RowJudge) -> None:
        self._open, self.judge = open_link, judge
        self._readings: deque[Reading] = deque(maxlen=KEPT)
        self._news = threading.Condition()
        self._fault, self._is_ended, self._hurries = "", False, False
        self._taking = threading.Lock()
        self._thread = threading.Thread(target=self._run, name="wpcal-link", daemon=True)
        self._thread.start()

    def take(self, patience_s: float = PATIENCE_S) -> Accepted:
        """Return a position that was asked for after this call, of an arm that stands; wait for it.

        Raises `LinkError` when the robot does not answer, the arm does not come to rest, or the judge refuses.
        """
        with self._taking:
            return self._take(time.monotonic(), time.monotonic() + patience_s)

    def close(self) -> None:
        """End the connection."""
        with self._news:
            self._is_ended = True
            self._news.notify_all()
        self._thread.join()

    def _take(self, asked_s: float, end_s: float) -> Accepted:
        said = "no position arrived"
        with self._news:
            self._fault, self._hurries = "", True
            self._news.notify_all()  # no pause before the next reading
        while True:
            with self._news:
                is_news = self._news.wait_for(partial(self._has, asked_s), max(end_s - time.monotonic(), 0.0))
                fault, readings = self._fault, list(self._readings)
            if fault:
                raise LinkError(fault)
            if not is_news:
                raise LinkError(said)
            try:
                return self.judge.accept(readings)
            except ArmMovesError as error:
                said, asked_s = str(error), readings[-1].asked_s + 1e-6

    def _has(self, asked_s: float) -> bool:
        return bool(self._fault) or bool(self._readings and self._readings[-1].asked_s >= asked_s)

    def _run(self) -> None:
        link: RobotLink | None = None
        while not self._is_ended:
            pause = PERIOD_S
            try:
                link = link or self._open()
                reading = link.read()
            except WpcalError as error:
                if link is not None:
                    link.close()
                link, pause = None, AGAIN_S
                with self._news:
                    self._readings.clear()
                    self._fault = str(error)
                    self._news.notify_all()
            else:
                with self._news:
                    self._readings.append(reading)
                    self._fault = ""
                    self._news.notify_all()
            with self._news:
                self._news.wait_for(lambda: self._is_ended or self._hurries, pause)
                self._hurries = False
        if link is not None:
            link.close()
