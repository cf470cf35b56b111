"""The outcome of a run, as a value and as a sentence."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum
from typing import Any

from galvi.input_checks import shown


class End(Enum):
    """The ways in which a run ends.

    Examples
    --------
    >>> method = galvi.Galerkin(galvi.Polynomials(8), galvi.gauss(8))
    >>> run = galvi.integrate(galvi.problems.kepler(0.6), method, step=0.1, steps=20)
    >>> run.outcome.end is galvi.End.COMPLETED
    True
    """

    COMPLETED = "completed"
    DOUBTFUL = "doubtful"
    RUINED = "ruined"
    STOPPED_BY_EVENT = "stopped by an event"
    STEP_FAILED = "step failed"
    STEP_LIMIT = "step limit"
    INTERRUPTED = "interrupted"


@dataclass(frozen=True)
class Outcome:
    """How a run ended; ``str(outcome)`` is `galvi.Trajectory.status`.

    Attributes
    ----------
    end
        COMPLETED; DOUBTFUL, completed with a result that may be wrong; RUINED, completed with one
        that is wrong from a step on; STOPPED_BY_EVENT; STEP_FAILED, where a step could not be done,
        kept since memory was full, or searched for its events; STEP_LIMIT, where a run to a time
        reached its largest number of steps; INTERRUPTED
    step
        number, from 1, of the step that failed or was not begun, or of the first ruined one
    time
        time at which the run ended, where that is before its requested end
    reason
        why the step failed, or what is wrong or in doubt, in clauses without a full stop
    notes
        further sentences
    steps
        number of requested steps; None for a run to a time
    remedy
        what to do about the reason, without a full stop; "" where the reason names it
    event
        the name of the event that ended the run
    sentence
        status of another method than galvi's, instead of the sentence composed here

    Raises
    ------
    TypeError
        Where ``end`` is no `End`.

    Examples
    --------
    >>> method = galvi.Galerkin(galvi.Polynomials(4), galvi.gauss(4))
    >>> run = galvi.integrate(galvi.problems.kepler(0.6), method, step=1.0, steps=20)
    >>> outcome = run.outcome
    >>> outcome.end, outcome.success, outcome.failed_step
    (<End.DOUBTFUL: 'doubtful'>, True, None)
    >>> str(outcome) == run.status
    True
    """

    end: End = End.COMPLETED
    step: int | None = None
    time: float | None = None
    reason: str = ""
    notes: tuple[str, ...] = ()
    steps: int | None = None
    remedy: str = ""
    event: str = ""
    sentence: str = ""

    def __post_init__(self) -> None:
        if not isinstance(self.end, End):
            raise TypeError(
                f"end must be a galvi.End; received {shown(self.end)}. Use galvi.End.STEP_FAILED, "
                f"or another of {', '.join(End.__members__)}."
            )

    @property
    def success(self) -> bool:
        """Whether the run was completed, in doubt or not, or ended by an event."""
        return self.end in (End.COMPLETED, End.DOUBTFUL, End.STOPPED_BY_EVENT)

    @property
    def in_doubt(self) -> bool:
        """Whether a success may be wrong."""
        return self.success and self.reason != ""

    @property
    def failed_step(self) -> int | None:
        """``step``; None for a success."""
        return None if self.success else self.step

    def to_json(self) -> dict[str, Any]:
        """The fields as JSON has them, for ``from_json``."""
        return {**vars(self), "end": self.end.name}

    @classmethod
    def from_json(cls, fields: dict[str, Any]) -> Outcome:
        """The outcome that was written by ``to_json``."""
        return cls(**fields | {"end": End[fields["end"]], "notes": tuple(fields["notes"])})

    def __str__(self) -> str:
        return " ".join([self.sentence or self._first_sentence(), *self.notes])

    def _first_sentence(self) -> str:
        why = ". ".join(part for part in (self.reason, self.remedy) if part)
        number = "" if self.step is None else f" step {self.step}"
        number += f" of {self.steps}" if number and self.steps else ""
        moment = "" if self.time is None else f"t = {self.time:.10g}"
        begin = f"{number and ' at'}{number}{moment and ', from '}{moment}"
        by_event = f"Ended by the event {self.event}, at {moment}"
        match self.end:
            case End.COMPLETED:
                return "Completed."
            case End.DOUBTFUL:
                return f"Completed, but {why}."
            case End.RUINED:
                ruined = f"Ruined from{number} on: {why}."
                return f"{ruined} {by_event}." if self.event else ruined
            case End.STOPPED_BY_EVENT:
                return f"{by_event}, but {why}." if why else f"{by_event}."
            case End.STEP_FAILED:
                return f"Stopped{begin}: {why}." if why else f"Stopped{begin}."
            case End.STEP_LIMIT:
                return f"Stopped after {(self.step or 1) - 1} steps, at {moment}: {why}."
            case End.INTERRUPTED:
                return f"Interrupted{begin}; what was computed is kept."
