"""Conditions in a plan: steps that are left out by an answer, and loops that are left by a value.

A condition is a step of the plan like any other. It is followed by the steps that hang on it, all
of them: what a run may do at most. Where it says so, they are left out.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import inf, isfinite
from typing import TYPE_CHECKING

from rigrunner.api.errors import DataError
from rigrunner.api.steps import Action, StepResult
from rigrunner.api.units import from_si, unit, with_article
from rigrunner.plan.actions import Phase
from rigrunner.yamlfile.problems import suggestion

if TYPE_CHECKING:
    from rigrunner.api.conditions import Until, When
    from rigrunner.api.member import Member
    from rigrunner.api.steps import Doing
    from rigrunner.plan.draft import Place, Scene
    from rigrunner.plan.planning import Planning

_REFUSED = "the teardown is always executed: it has no conditions"


@dataclass(frozen=True)
class Chosen(Action):
    """Steps are done if an input has one of some values."""

    kind = "when"
    outcome_stands = True
    input: str
    values: tuple[str, ...]
    """Those for which the steps are done."""
    inverse: bool = False
    """Whether they are done for all others instead."""

    def do(self, step: str, doing: Doing) -> StepResult:
        """Look at the answer; the steps are left out where there was none."""
        answer = doing.answer(self.input)
        is_done = answer is not None and (answer in self.values) != self.inverse
        if not is_done:
            answer_text = "was not asked" if answer is None else f"is '{answer}'"
            doing.note(step, f"{self.input} {answer_text}: the steps that hang on it are left out")
        return StepResult({}, {}, leaves=not is_done)


@dataclass(frozen=True)
class Reached(Action):
    """A repetition ends once a channel is above, or below, a value."""

    kind = "until"
    reads = True
    outcome_stands = True
    member: Member
    unit: str
    """Of the channel."""
    minimum: float
    maximum: float
    """The repetition continues while the channel is within, in that unit."""
    condition: str
    """In words."""
    shown: str
    """The unit in which the condition is written, and the value is shown."""
    number: int
    """How often the steps were done by then, from 1."""
    of: int
    """How often at most."""

    def do(self, step: str, doing: Doing) -> StepResult:
        """Read the channel once."""
        value = doing.read((self.member,))[self.member]
        met = not self.minimum <= value <= self.maximum
        text = f"{self.member} is {from_si(value, self.shown):.6g} {self.shown}"
        if met:
            doing.note(step, f"{text}: {self.condition} after {self.number} of {self.of} times")
        elif self.number == self.of:
            doing.note(step, f"{text}: not {self.condition} after all {self.of} times")
        return StepResult({self.member: value}, {self.member: self.unit}, leaves=met)


@dataclass(frozen=True)
class ResultReached(Action):
    """A repetition ends once a result, of what was recorded by then, is above or below a value."""

    kind = "until"
    outcome_stands = True
    result: str
    minimum: float
    maximum: float
    """The repetition continues while the result is within, in the SI unit."""
    condition: str
    """In words."""
    shown: str
    """The unit in which the condition is written, and the value is shown."""
    number: int
    """How often the steps were done by then, from 1."""
    of: int
    """How often at most."""

    def do(self, step: str, doing: Doing) -> StepResult:
        """Have the result computed."""
        result = doing.result(self.result)
        result_unit, unit_ = unit(result.unit), unit(self.shown)
        if result_unit.dimension != unit_.dimension:
            message = (
                f"'{self.result}' is {with_article(result_unit.dimension)}, compared with"
                f" {with_article(unit_.dimension)}"
            )
            raise DataError(message)
        if not isfinite(result.value):  # of no range, and so it would seem to be reached
            raise DataError(f"'{self.result}' is not a finite number ({result.value})")
        value = result_unit.to_si(result.value)
        text = f"{self.result} is {unit_.from_si(value):.6g} {self.shown}"
        met = not self.minimum <= value <= self.maximum
        condition_text = self.condition if met else f"not {self.condition}"
        doing.note(step, f"{text}: {condition_text} after {self.number} of {self.of} times")
        return StepResult({}, {}, leaves=met)


def begin_choice(when: When, place: Place, scene: Scene) -> int | None:
    """Write down the condition of a step; return where, or None after adding what is wrong."""
    path, values = (*place.path, "when"), when.is_ or when.is_not
    if place.phase is Phase.TEARDOWN:
        scene.complain(path, _REFUSED, "remove the condition", key=True)
        return None
    expected = scene.draft.answered.get(when.input)
    if expected is None:
        hint = suggestion(when.input, scene.draft.answered, "inputs asked by then")
        scene.complain((*path, "input"), f"no input '{when.input}' is asked by then", hint)
        return None
    key = "is" if when.is_ else "is_not"
    if expected.unit:
        message = f"'{when.input}' is a number with a unit, and compared with a text"
        scene.complain((*path, key), message, "ask for a choice: 'choices: [...]'")
    for value in values:
        if expected.choices and value not in expected.choices:
            hint = suggestion(value, expected.choices, "choices")
            scene.complain((*path, key), f"'{value}' is not an answer to '{when.input}'", hint)
    scene.emit(place.inside("when"), Chosen(when.input, values, bool(when.is_not)), "", 0.0)
    return len(scene.draft.steps) - 1


def end_choice(at: int, when: When, place: Place, scene: Scene, before: dict[str, float]) -> None:
    """Let the condition leave out what was planned since; drives must stand as before."""
    steps = scene.draft.steps
    count = len(steps) - at - 1
    words = " or ".join(when.is_ or when.is_not)
    steps_text = "the next step" if count == 1 else f"the next {count} steps"
    text = f"If {when.input} is {'not ' if when.is_not else ''}{words}: {steps_text}"
    steps[at] = replace(steps[at], leaves=count, text=text)
    # The set-points must be known at every step before the run, for any answer.
    for member, value, symbol in scene.drives.changed(before):
        value_before = before.get(member)
        earlier = "its safe value" if value_before is None else f"{value_before:g} {symbol}"
        message = f"{member} is at {value:g} {symbol} after this step, or at {earlier} without it"
        hint = "set it back within the step (see 'group'), or set it without a condition"
        scene.complain((*place.path, "when"), message, hint, key=True)


def plan_until(
    until: Until, key: tuple[str | int, ...], count: tuple[int, int], planning: Planning
) -> int | None:
    """Write down the reading at the end of a pass; return where, or None where it cannot be.

    `count` is how often the steps were done by then, from 1, and how often they are at most.
    """
    place, (number, of) = planning.place, count
    if place.phase is Phase.TEARDOWN:
        planning.scene.complain((*place.path, "until"), _REFUSED, "give 'times'", key=True)
        return None
    name, bound = until.bound
    low, high = (-inf, bound.si) if name == "above" else (bound.si, inf)
    arguments = low, high, f"{name} {bound}", bound.unit.symbol, number, of
    action: Action
    if until.channel is not None:
        channel = planning.channel(until.channel, (*key, "channel"))
        if channel is None:
            return None
        if not planning.fits(bound, channel.unit, until.channel, (*key, name)):
            return None
        planning.must_be_read([until.channel])
        action = Reached(until.channel, channel.unit, *arguments)
    else:
        assert until.result is not None  # noqa: S101  (one of two)
        action = ResultReached(until.result, *arguments)
    what = until.channel or until.result
    text = f"Until {what} is {name} {bound}: {number} of at most {of} times"
    # Not a part of the pass: where the pass is skipped, the value is still read.
    at = place.time(number - 1).inside("until").outside()
    for listed in key[1:]:
        at = at.step(int(listed))
    planning.emit(action, text, at=at)
    return len(planning.scene.draft.steps) - 1


def end_until(conditions: list[int], scene: Scene) -> None:
    """Let the reading after each pass leave out all that was planned after it."""
    steps = scene.draft.steps
    for at in conditions:
        steps[at] = replace(steps[at], leaves=len(steps) - at - 1)
