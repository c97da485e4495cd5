"""Directional derivatives that are not the FMU's word alone: differences of steps, and the trial of
what an FMU offers.

Interface Newton needs the derivative of the step map: the change of the outputs at the end of a
step for a change of what the inputs are held at over it. The standard's directional derivative is
another thing, the partial derivative at a communication point, which is zero for an output that is
a state. FMUs answer one or the other by the same call, so that a trial has to tell.
"""

from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import numpy as np

from ..fmi.errors import Discard, ParticipantFault
from .participant import Participant

Fields = dict[str, np.ndarray]
"""Values or changes by field."""

DIFFERENCE = 1e-5
"""Change of inputs for difference quotients, in nominals: far above round-off, far below what bends
the step map.
"""
TRIED = (DIFFERENCE, 1e-2)
"""Changes tried in turn until one agrees: an FMU that solves to a loose tolerance answers small
ones by noise.
"""
MOVED = (0.0, -1e-2, 1e-2)
"""Shifts of the inputs, in nominals, about which changes are tried in turn until one agrees: a
start is often at a kink (a film at rest without pressure, a gap just closed), where slopes differ
from side to side and no derivative is right.
"""
AGREES = 0.1
"""Of the difference: with a derivative that is off by this much Newton's residual still falls to a
tenth in every iteration, which is cheaper than taking differences. The standard's derivative of a
state is off by 1.
"""
ROUND_OFF = 1e-12
"""Of an output's largest value: less than ten times this in a change says nothing."""
INSTANTS = 2
"""Steps from which the trial is made: the first may be one without response."""
GROUPS = 2
"""Groups of inputs that are changed one after the other, so that an input with a strong influence
does not hide the others.
"""

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
    """Directional derivative from the last step taken once more with changed inputs; the
    participant is left as it was.

    Eq. (P1):  J v = (y(x + e v) - y(x)) / e,   e = share / max|v / scale|,
               scale: nominal, else max|x|, else 1

    Parameters
    ----------
    participant : Participant
    begin : saved state
        Where the last step began.
    last_step : (float, float)
        Its time and size [s].
    seeds : dict of str to ndarray
        Change of every input that was set since `begin`; zero where it is to stay.
    products : iterable of str
    share : float
        Largest change of an input, in its scale; negative to go the other way.

    Returns
    -------
    dict of str to ndarray
    """
    before = {name: participant.get(name) for name in (*seeds, *products)}
    scale = scales(participant, before, seeds)
    largest = max(
        (float(np.max(np.abs(value))) / scale[name] for name, value in seeds.items()), default=0.0
    )
    if largest == 0.0:
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
    """Restore a state and set its inputs: what was set counts, and never what an FMU answers."""
    participant.restore(saved)
    for name, value in inputs.items():
        participant.set(name, value)


def scales(
    participant: Participant, values: Mapping[str, Any], names: Iterable[str]
) -> dict[str, float]:
    """Nominal of each field, else its largest value, else 1."""
    return {
        name: participant.fields[name].nominal or float(np.max(np.abs(values[name]))) or 1.0
        for name in names
    }


class Differenced:
    """A participant whose derivative is taken by differences of its steps, whatever it offers."""

    has_derivatives = False

    def __init__(self, participant: Participant):
        self.participant = participant
        self._begin: Any = None
        self._last_step = (0.0, 0.0)

    def __getattr__(self, name):
        return getattr(self.participant, name)

    def restore(self, saved: Any) -> None:
        """Go back to a saved state; the next step counts from it."""
        self._begin = saved
        self.participant.restore(saved)

    def step(self, time: float, step: float) -> None:
        """One step [s]."""
        self._last_step = time, step
        self.participant.step(time, step)

    def begin_step(self, time: float, step: float) -> None:
        """The same as far as it can be sent away; see `IsolatedParticipant.begin_step`."""
        self._last_step = time, step
        apart: Any = self.participant
        apart.begin_step(time, step)

    def derivative(self, seeds: Mapping[str, np.ndarray], products: Iterable[str]) -> Fields:
        """Directional derivative of the last step, see `difference`."""
        return difference(self.participant, self._begin, self._last_step, seeds, products)


def objection(
    participant: Participant,
    inputs: Sequence[str],
    outputs: Sequence[str],
    step: float,
    begin: float = 0.0,
) -> str:
    """Return why a participant's derivative does not match that of a step; empty if it does.

    Its products are compared with differences of a step, output by output. The participant is left
    as it was; three steps are taken where the first comparison of both groups of inputs agrees,
    nine where none does, at most thirty where nothing responds.

    Parameters
    ----------
    participant : Participant
        Started, and one that `has_derivatives`.
    inputs, outputs : sequence of str
        Fields on wires, at least one of each.
    step : float
        Macro step [s].
    begin : float
        Where the participant stands [s].

    Returns
    -------
    str
    """
    saved = participant.save()
    disagreed = False
    try:
        for k in range(INSTANTS):
            for moved in MOVED:
                try:
                    verdict = _tried(participant, (begin + k * step, step), inputs, outputs, moved)
                except Discard:
                    continue  # the step is refused for these inputs
                if verdict:
                    return ""
                disagreed = disagreed or verdict is False
            if disagreed:
                return DIFFERENT
            participant.step(begin + k * step, step)  # from here nothing responds
        return SILENT
    except Discard as refusal:
        return f"the FMU rejected a trial step: {refusal}"
    except ParticipantFault as fault:
        return f"the FMU returned an error: {fault}"
    finally:
        participant.restore(saved)
        participant.free(saved)


def _tried(
    participant: Participant,
    this_step: tuple[float, float],
    inputs: Sequence[str],
    outputs: Sequence[str],
    moved: float,
) -> bool | None:
    """Whether the derivatives of this step agree with differences, its inputs moved by a share of
    their scale; None if no output responds. The participant is left as it was.
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
    """A change of a field, of one sign so that effects add, uneven so that no symmetry hides it."""
    shape = participant.fields[name].shape
    size = int(np.prod(shape))
    return np.linspace(1.0, 0.5, size).reshape(shape)


def _agrees_at_any_size(
    participant: Participant,
    begin: Any,
    last_step: tuple[float, float],
    seed: Fields,
    product: Mapping[str, np.ndarray],
    outputs: Sequence[str],
) -> bool | None:
    """Whether a product agrees with a difference; None if no change is large enough to say."""
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
    """Whether a predicted change agrees with the true one in every output that shows either; None
    if none does.
    """
    shown = False
    for name, true in change.items():
        noise = ROUND_OFF * float(np.max(np.abs(values[name]))) * np.sqrt(true.size)
        largest = max(np.linalg.norm(true), np.linalg.norm(predicted[name]))
        if largest <= 10 * noise:
            continue
        shown = True
        apart = np.linalg.norm(predicted[name] - true)
        if not apart <= AGREES * np.linalg.norm(true) + noise:
            return False
    return True if shown else None
