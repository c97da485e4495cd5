"""Trust check of an FMU's saved states before the run: steps with and without restoring them."""

from collections.abc import Collection, Mapping, Sequence
from contextlib import suppress
from types import MappingProxyType
from typing import Any, NamedTuple

import numpy as np

from ..fmi.errors import BadInput, Discard, Finished, ParticipantFault
from .derivatives import put_back

COMPARED_STEPS = 2
"""Number of steps to compare. A missing part of the state may affect only the second one."""
TALLY = " so far"
"""In the description of an output that counts repeated steps too, and is no part of a state."""
ROUND_OFF = 1e-12
"""Difference of an output, relative to its size, that counts as round-off of a step."""
LARGEST_NOISE = 1e-2
"""Difference of an output, relative to its size, from which saved states are not used."""
SMALLEST_SIZE = 1e-5
"""Smallest size of an output, in nominals: LARGEST_NOISE of it is a tenth of a wire's tolerance."""

UNTRIED = ("Binary", "Clock")
"""Types of outputs that are not compared."""


class RollbackTrial(NamedTuple):
    """Result of the trial of a participant's saved states.

    fault : why they cannot be used, or empty; noise : largest difference of an output after a
    restored step, relative to its size, 0 for round-off; message : about that output; sizes :
    largest value of each output; outputs : outputs after the last step; remark : about an output
    that is neither a real number nor on a wire, which does not count.
    """

    fault: str = ""
    noise: float = 0.0
    message: str = ""
    sizes: dict[str, float] = {}
    outputs: dict[str, np.ndarray] = {}
    remark: str = ""

    @property
    def is_noisy(self) -> bool:
        """Return whether the noise is too large for an iteration."""
        return self.noise >= LARGEST_NOISE


def rollback_trial(
    participant: Any,
    inputs: Sequence[str],
    step: float,
    begin: float = 0.0,
    changes: Mapping[str, Any] = MappingProxyType({}),
    wired: Collection[str] = (),
) -> RollbackTrial:
    """Return whether the saved states of a started participant are reliable.

    Two steps are taken, and again with each step repeated from a saved state. If the FMU allows a
    second instance, that one is used. The state of the participant is restored.

    Parameters
    ----------
    participant : Participant
    inputs : sequence of str
        Its inputs on wires.
    step : float
        Macro step [s].
    begin : float
        Current time of the participant [s].
    changes : mapping of str to value
        Inputs that have another value during the trial.
    wired : collection of str
        Its outputs on wires.

    Returns
    -------
    RollbackTrial
        Without a fault also if the FMU does not take these steps, which the run then reports.

    Raises
    ------
    BadInput
        If the second instance changes the first.
    """
    before = _outputs(participant)
    one = _second_instance(participant, inputs)
    if one is not None:
        try:
            trial = _compare(one, inputs, step, begin, changes, wired)
        finally:
            with suppress(ParticipantFault):
                one.close()
        if any(
            value.tobytes() != before[name].tobytes()
            for name, value in _outputs(participant).items()
        ):
            raise BadInput(
                f"participants.{participant.name}: expected independent instances, got outputs "
                "that a second instance changes; set isolated = true"
            )
        return trial
    try:
        saved = participant.save()
    except ParticipantFault as error:
        return RollbackTrial(f"its state cannot be saved: {error}")
    values = {name: participant.get(name) for name in inputs}
    trial = _compare(participant, inputs, step, begin, changes, wired)
    with suppress(ParticipantFault):
        put_back(participant, saved, values)
        participant.free(saved)
    return trial


def _second_instance(participant: Any, inputs: Sequence[str]) -> Any:
    """Return a second instance, started with the same parameters and inputs; else None."""
    while not hasattr(type(participant), "another"):  # a wrapper delegates the rest
        if (participant := vars(participant).get("participant")) is None:
            return None
    one = participant.another()
    if one is None:
        return None
    try:
        one.start(*participant.started_with)
        for name in one.fields.keys() & inputs:
            one.set(name, participant.get(name))
    except (BadInput, ParticipantFault):
        with suppress(ParticipantFault):
            one.close()
        return None
    return one


def _compare(
    one: Any,
    inputs: Sequence[str],
    step: float,
    begin: float,
    changes: Mapping[str, Any],
    wired: Collection[str],
) -> RollbackTrial:
    """Return the difference between steps with and without saved states."""
    for name, value in changes.items():
        one.set(name, value)
    values = {name: one.get(name) for name in one.fields.keys() & inputs}
    try:
        first = one.save()
    except ParticipantFault as error:
        return RollbackTrial(f"its state cannot be saved: {error}")
    times = [begin + k * step for k in range(COMPARED_STEPS)]
    try:
        plain = [_step_outputs(one, time, step) for time in times]
    except (Discard, ParticipantFault, Finished):
        return RollbackTrial()
    try:
        put_back(one, first, values)
        repeated = [_repeat(one, time, step, values) for time in times]
        one.free(first)
    except (Discard, ParticipantFault, Finished) as error:
        return RollbackTrial(f"a step from a saved state fails: {error}")
    return _difference(one, plain, repeated, wired)


def _repeat(one: Any, time: float, step: float, values: dict[str, Any]) -> dict[str, np.ndarray]:
    """Return the outputs after a step that is taken, undone and repeated."""
    saved = one.save()
    one.step(time, step)
    put_back(one, saved, values)
    one.free(saved)
    return _step_outputs(one, time, step)


def _step_outputs(one: Any, time: float, step: float) -> dict[str, np.ndarray]:
    """Return the outputs after a step."""
    one.step(time, step)
    return _outputs(one)


def _outputs(one: Any) -> dict[str, np.ndarray]:
    """Return the current outputs: texts as they are, all others as floats."""
    return {
        name: np.array(one.get(name), dtype=None if field.type == "String" else float)
        for name, field in one.fields.items()
        if field.causality == "output" and field.type not in UNTRIED and 0 not in field.shape
    }


def _difference(
    one: Any,
    plain: list[dict[str, np.ndarray]],
    repeated: list[dict[str, np.ndarray]],
    wired: Collection[str],
) -> RollbackTrial:
    """Return the trial with the output that differs most."""
    worst, message, remark = ROUND_OFF, "", ""
    sizes = {
        name: max(
            SMALLEST_SIZE * (one.fields[name].nominal or 1.0),
            *(_size(row[name]) for row in (*plain, *repeated)),
        )
        for name in plain[0]
    }
    for k, (before, after) in enumerate(zip(plain, repeated), 1):
        for name, value in before.items():
            difference = _apart(value, after[name])
            share = difference / sizes[name]
            counts = one.fields[name].type == "Real" or name in wired
            is_tally = TALLY in (one.fields[name].description or "")
            if share <= (worst if counts else ROUND_OFF) or (is_tally and not counts):
                continue
            fault = (
                f"{name} differs by {difference:.3g} ({100 * share:.3g} %) after step {k} if "
                "states are saved and restored"
            )
            if counts:
                worst, message = share, fault
            else:
                remark = remark or fault
    return RollbackTrial(
        fault="",
        noise=worst if message else 0.0,
        message=message,
        sizes=sizes,
        outputs=plain[-1],
        remark=remark,
    )


def _size(value: np.ndarray) -> float:
    """Return the largest absolute value, 1 for texts."""
    return float(np.nanmax(np.abs(value), initial=0.0)) if value.dtype.kind == "f" else 1.0


def _apart(value: np.ndarray, other: np.ndarray) -> float:
    """Return the largest difference, 1 for different texts."""
    if value.dtype.kind != "f":
        return float(not np.array_equal(value, other))
    is_equal = (value == other) | (np.isnan(value) & np.isnan(other))
    return float(np.max(np.where(is_equal, 0.0, np.abs(other - value)), initial=0.0))
