"""Directional derivatives by differences of steps, and the check of an FMU's own.

Interface Newton needs the derivative of the step map: the change of the outputs at the end of a
step for a change of the inputs during it. The directional derivative of the standard is the
partial derivative at a communication point. It is zero for an output that is a state. FMUs
return one or the other by the same call, so a check compares it with a step.
"""

from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import numpy as np

from ..fmi.errors import Discard, ParticipantFault
from ..fmi.symmetry import odd_part
from .participant import Participant, Wrapper

Fields = dict[str, np.ndarray]
"""Values or changes by field."""

DIFFERENCE = 1e-5
"""Relative change of inputs for difference quotients, in nominals: above round-off, and small
compared with the nonlinearity of the step map."""
TRIED = (DIFFERENCE, 1e-2)
"""Changes to try until one agrees. If an FMU solves to a loose tolerance, its response to small
changes is noise."""
INPUT_SHIFTS = (0.0, -1e-2, 1e-2)
"""Shifts of the inputs, in nominal values, to try until one agrees. A start is often at a kink, for
example a film at rest without pressure, where no derivative is right."""
AGREEMENT_TOLERANCE = 0.1
"""Tolerance relative to the difference. With this error, Newton's residual still falls to a
tenth in every iteration, which is cheaper than differences. The standard's derivative of a state
has an error of 1."""
NEGLIGIBLE = 1e-290
"""Relative change of inputs that counts as zero, because a division by a denormal number
overflows."""
ROUND_OFF = 1e-12
"""Round-off relative to an output's largest value. Changes below ten times this are ignored."""
CHECKED_STEPS = 2
"""Number of steps to check, because the first one may have no response."""
GROUPS = 2
"""Number of groups of inputs that are changed separately, so that a strong input does not hide
others."""

DIFFERENT = "it differs from that of a step"
SILENT = "the outputs of the first steps do not respond to the inputs"


def difference(
    participant: Participant,
    begin: Any,
    last_step: tuple[float, float],
    seeds: Mapping[str, np.ndarray],
    products: Iterable[str],
    share: float = DIFFERENCE,
) -> Fields:
    """Return the directional derivative by repeating the last step with changed inputs.

    The state of the participant is restored.

    Eq. (P1):  J v = (y(x + e v) - y(x)) / e,   e = share / max|v / scale|,
               scale: nominal, else max|x|, else 1

    Parameters
    ----------
    participant : Participant
    begin : saved state
        Beginning of the last step.
    last_step : (float, float)
        Its time and size [s].
    seeds : dict of str to ndarray
        Change of every input that was set since `begin`, zero for constant inputs.
    products : iterable of str
    share : float
        Largest change of an input, in its scale. A negative value changes the direction.

    Returns
    -------
    dict of str to ndarray
    """
    before = {name: participant.get(name) for name in (*seeds, *products)}
    scale = scales(participant, before, seeds)
    largest = max(
        (float(np.max(np.abs(value))) / scale[name] for name, value in seeds.items()), default=0.0
    )
    if largest <= NEGLIGIBLE:
        return {name: np.zeros_like(before[name]) for name in products}
    end = participant.save()
    size = share / largest
    try:
        participant.restore(begin)
        for name, value in seeds.items():
            participant.set(name, before[name] + size * value)
        participant.step(*last_step)
        return {
            name: (participant.get(name) - before[name]) / size for name in products
        }  # Eq. (P1)
    finally:
        put_back(participant, end, {name: before[name] for name in seeds})
        participant.free(end)


def put_back(participant: Participant, saved: Any, inputs: Mapping[str, Any]) -> None:
    """Restore a state and set its inputs, because FMUs may not return the inputs that were set."""
    participant.restore(saved)
    for name, value in inputs.items():
        participant.set(name, value)


def scales(
    participant: Participant, values: Mapping[str, Any], names: Iterable[str]
) -> dict[str, float]:
    """Return the nominal of each field, else its largest value, else 1."""
    return {
        name: participant.fields[name].nominal or float(np.max(np.abs(values[name]))) or 1.0
        for name in names
    }


class RepeatedStep:
    """Derivative by repeating the last step, for participants that know where it began."""

    participant: Any
    _begin: Any = None
    _last_step = (0.0, 0.0)

    def restore(self, saved: Any) -> None:
        """Restore a saved state, where the next step begins."""
        self._begin = saved
        self.participant.restore(saved)

    def derivative(self, seeds: Mapping[str, np.ndarray], products: Iterable[str]) -> Fields:
        """Return the directional derivative of the last step by a difference."""
        begin = self._begin
        try:
            whole: Any = self  # attributes of a wrapper can be those of the inner participant
            return difference(whole, begin, self._last_step, seeds, products)
        finally:
            self._begin = begin


class Differenced(RepeatedStep, Wrapper):
    """Participant with derivatives by differences of its steps, even if it offers others."""

    has_derivatives = False
    derive = None

    def step(self, time: float, step: float) -> None:
        """Take a step [s]."""
        self._last_step = time, step
        self.participant.step(time, step)

    def begin_step(self, time: float, step: float) -> None:
        self._last_step = time, step
        self.participant.begin_step(time, step)


def objection(
    participant: Participant,
    inputs: Sequence[str],
    outputs: Sequence[str],
    step: float,
    begin: float = 0.0,
) -> str:
    """Return why a participant's derivative does not match that of a step; empty if it does.

    The products are compared with differences of a step for each output. The state of the
    participant is restored. If the first comparison agrees, this takes three steps. It takes at
    most thirty if no output responds.

    Parameters
    ----------
    participant : Participant
        Started, and with `has_derivatives`.
    inputs, outputs : sequence of str
        Fields on wires, at least one of each.
    step : float
        Macro step [s].
    begin : float
        Current time of the participant [s].

    Returns
    -------
    str
    """
    saved = participant.save()
    disagreed = False
    try:
        for k in range(CHECKED_STEPS):
            for moved in INPUT_SHIFTS:
                try:
                    verdict = _agrees_at(
                        participant, (begin + k * step, step), inputs, outputs, moved
                    )
                except Discard:
                    continue  # the FMU discards the step for these inputs
                if verdict:
                    return ""
                disagreed = disagreed or verdict is False
            if disagreed:
                return DIFFERENT
            participant.step(begin + k * step, step)  # nothing has responded so far
        return SILENT
    except Discard as refusal:
        return f"the FMU rejected a trial step: {refusal}"
    except ParticipantFault as fault:
        return f"the FMU returned an error: {fault}"
    finally:
        participant.restore(saved)
        participant.free(saved)


def _agrees_at(
    participant: Participant,
    this_step: tuple[float, float],
    inputs: Sequence[str],
    outputs: Sequence[str],
    moved: float,
) -> bool | None:
    """Return whether the derivatives of a step agree with differences; None without response.

    `moved` shifts the inputs as a share of their scale. The state of the participant is restored.
    """
    begin = participant.save()
    start = {name: participant.get(name) for name in inputs}
    try:
        scale = scales(participant, start, inputs)
        unit = {name: scale[name] * _pattern(participant, name) for name in inputs}
        participant.restore(begin)
        for name in inputs if moved else ():
            participant.set(name, start[name] + moved * unit[name])
        participant.step(*this_step)
        groups = [inputs[k::GROUPS] for k in range(min(GROUPS, len(inputs)))]
        seeds = [
            {name: change if name in group else 0.0 * change for name, change in unit.items()}
            for group in groups
        ]
        own = [participant.derivative(seed, outputs) for seed in seeds]
        responds = None
        for seed, product in zip(seeds, own):
            verdict = _agrees_at_any_size(participant, begin, this_step, seed, product, outputs)
            if verdict is False:
                return False
            responds = responds or verdict
        return responds
    finally:
        put_back(participant, begin, start)
        participant.free(begin)


def _pattern(participant: Participant, name: str) -> np.ndarray:
    """Return a change of a field: of one sign, so that effects add up, and uneven.

    It is its own mirror image about the thrust plane, because half of a film needs that.
    """
    shape = participant.fields[name].shape
    size = int(np.prod(shape))
    pattern = np.linspace(1.0, 0.5, size).reshape(shape)
    return pattern - odd_part(pattern) if pattern.ndim == 2 else pattern


def _agrees_at_any_size(
    participant: Participant,
    begin: Any,
    last_step: tuple[float, float],
    seed: Fields,
    product: Mapping[str, np.ndarray],
    outputs: Sequence[str],
) -> bool | None:
    """Return whether a product agrees with a difference; None if all changes are too small."""
    said_no = False
    values = {name: participant.get(name) for name in outputs}
    for share in TRIED:
        try:
            quotient = difference(participant, begin, last_step, seed, outputs, share)
        except Discard:
            continue
        verdict = _agrees(
            {name: share * np.asarray(product[name]) for name in outputs},
            {name: share * np.asarray(quotient[name]) for name in outputs},
            values,
        )
        if verdict:
            return True
        said_no = said_no or verdict is False
    return False if said_no else None


def _agrees(predicted: Fields, change: Fields, values: Mapping[str, Any]) -> bool | None:
    """Return whether a predicted change agrees in every output that changes; None without any."""
    shown = False
    for name, true in change.items():
        noise = ROUND_OFF * float(np.max(np.abs(values[name]))) * np.sqrt(true.size)
        largest = max(np.linalg.norm(true), np.linalg.norm(predicted[name]))
        if largest <= 10 * noise:
            continue
        shown = True
        error = np.linalg.norm(predicted[name] - true)
        if not error <= AGREEMENT_TOLERANCE * np.linalg.norm(true) + noise:
            return False
    return True if shown else None
