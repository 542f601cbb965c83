"""How an answer was found: the solver, its seed, what it tried."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum
from typing import Any

from wpcal.optim.annealing import AnnealingReport, AnnealingSchedule, AnnealingTrace


class Solver(Enum):
    """Where the search for the pose starts."""

    ANNEALING = "annealing"
    """The published annealer over the whole box. Its best pose is then polished to the optimum."""

    EXACT = "exact"  #: The least-squares fit, polished to the optimum.


@dataclass(frozen=True, slots=True, eq=False)
class SolverReport:
    """How the answer was found."""

    solver: Solver
    method: str  #: In words.
    seed: int  #: Of every random number used.
    evaluations: int = 0  #: Largest distances computed by the annealer.
    temperatures: int = 0
    starts: int = 0  #: Local solves of the polish.
    schedule: str | None = None  #: Name of the annealer's schedule: ``default``, ``yin2003`` or ``custom``.
    trace: AnnealingTrace | None = None  #: f and best f per temperature: the paper's figure 2.
    annealed_objective_mm: float | None = None  #: Largest distance of the annealer's best pose, before the polish, mm.

    @classmethod
    def of_run(
        cls,
        run: AnnealingReport,
        schedule: AnnealingSchedule,
        *,
        method: str,
        seed: int,
        starts: int,
        annealed_objective_mm: float,
    ) -> SolverReport:
        """Report an annealed search that was polished from `starts` starts."""
        return cls(
            Solver.ANNEALING,
            method,
            seed,
            evaluations=run.evaluations,
            temperatures=run.temperatures,
            starts=starts,
            schedule=schedule.name,
            trace=run.trace,
            annealed_objective_mm=annealed_objective_mm,
        )

    def to_record(self) -> dict[str, Any]:
        """Return plain values for a JSON file."""
        record: dict[str, Any] = {
            "name": self.solver.value,
            "method": self.method,
            "schedule": self.schedule,
            "seed": self.seed,
            "evaluations": self.evaluations,
            "temperatures": self.temperatures,
            "starts": self.starts,
        }
        if self.trace is not None:
            columns = {
                "temperature_mm": "temperature",
                "f_mm": "cost",
                "best_f_mm": "best_cost",
                "accepted": "accepted",
            }
            record["trace"] = {key: getattr(self.trace, name).tolist() for key, name in columns.items()}
        return record
