"""The outcome of a run in blocks, from the outcomes of its blocks."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import cast

from galvi.checkpoint import Checkpoint
from galvi.outcome import End, Outcome
from galvi.run.clocked.stepper import ClockStepper
from galvi.run.point_masses.encounters import unresolved_passage
from galvi.run.status import SMALLER_STEP, notes_on_second_kernel
from galvi.run.stepper import Stepper
from galvi.trajectory import Trajectory


class Verdict:
    """The outcome of a run in blocks, composed while the blocks are done.

    Attributes
    ----------
    outcome
        outcome of the first block that was no success, or else of the last block in doubt, or with
        a note in a clock; None without such a block. Blocks that were interrupted or reached a
        bound of steps do not count
    passage
        in a clock, the worst passage of two point masses, see `galvi.kernels.forces.passages`
    """

    def __init__(self, stepper: Stepper | ClockStepper) -> None:
        self.stepper, self.passage = stepper, stepper.request.checkpoint.passage
        self.outcome: Outcome | None = None
        self._names_passage = False

    def add(self, block: Trajectory, steps_done: int) -> Outcome:
        """Include a block that follows ``steps_done`` steps; returns its outcome, with numbers of
        steps of the whole run."""
        in_clock = isinstance(self.stepper, ClockStepper)
        outcome = replace(block.outcome, steps=self.stepper.request.steps)
        if outcome.step is not None:
            outcome = replace(outcome, step=outcome.step + steps_done)
        if in_clock:
            self.passage = cast(Checkpoint, block.checkpoint).passage
        ends_block_alone = outcome.end in (End.INTERRUPTED, End.STEP_LIMIT)
        has_no_note = outcome.end is End.COMPLETED and not (in_clock and outcome.notes)
        if not (ends_block_alone or has_no_note) and (self.outcome is None or self.outcome.success):
            self.outcome = outcome
            self._names_passage = in_clock and bool(self._passage())
        return outcome

    def outcome_of_run(self, end: Outcome, counts: Mapping[str, int]) -> Outcome:
        """The outcome of a run whose last block or event led to the outcome ``end``."""
        verdict = self.outcome or end
        if not end.success:
            if verdict.end is not End.RUINED:
                return end
            note = f"It was ruined from step {verdict.step} on: {verdict.reason}."
            return replace(end, notes=(note,))
        outcome = replace(verdict, event=end.event, time=end.time)
        if end.event and verdict.success:
            outcome = replace(outcome, end=end.end, step=end.step)
        if isinstance(self.stepper, ClockStepper):
            return self._with_passage(outcome)
        if self.outcome is None:
            notes = notes_on_second_kernel(self.stepper.formulation, counts)
            outcome = replace(outcome, notes=notes)
        return outcome

    def _with_passage(self, outcome: Outcome) -> Outcome:
        """The outcome with a clause on an unresolved passage that no block has named."""
        passage = "" if self._names_passage else self._passage()
        if not outcome.success or not passage:
            return outcome
        return replace(
            outcome,
            end=End.STOPPED_BY_EVENT if outcome.event else End.DOUBTFUL,
            reason="; ".join(filter(None, [outcome.reason, passage])),
            remedy=outcome.remedy or SMALLER_STEP,
        )

    def _passage(self) -> str:
        return unresolved_passage(self.stepper.request.problem, None, self.passage)
