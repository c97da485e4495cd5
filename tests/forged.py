"""Saved states of a slave with other content and valid checksums."""

from collections import Counter

import numpy as np

from piston_cosim.master.fmi.errors import BadInput
from piston_cosim.master.fmi.state_bytes import join, split

STRANGE = (0.0, 1.0, -1.0, 1e300, -1e300, 1e15, -1e9, np.nan, np.inf, 2.0**31)


def forged(data: bytes, rng: np.random.Generator) -> bytes:
    """Bytes of a state with one member changed: values, order, length or type."""
    head, arrays = split(data)
    name = str(rng.choice([name for name, array in arrays.items() if array.size]))
    array = arrays[name]
    flat, kind = array.reshape(-1), rng.integers(5)
    if kind == 0:
        flat[rng.integers(flat.size)] = rng.choice(STRANGE) if array.dtype == float else 1
    elif kind == 1:
        flat[:] = flat[::-1].copy()
    elif kind == 2 and array.dtype == float:
        flat[:] = rng.normal(0.0, 10.0 ** rng.integers(-12, 12), flat.size)
    elif kind == 3:
        arrays[name] = flat[: rng.integers(flat.size + 1)]
    else:
        with np.errstate(invalid="ignore"):
            arrays[name] = array.astype(rng.choice(["f4", "i2", "c16", "U3"]))
    return join(head, arrays)


def outcomes(slave, count: int, time: float, step: float) -> Counter:
    """Restore forged states, take a step [s] from each, and count what happens.

    Every rejection is one sentence, and nothing raises.
    """
    data, rng = slave._fmu_state_to_bytes(slave._get_fmu_state()), np.random.default_rng(3)
    seen = Counter()
    for _ in range(count):
        try:
            saved = slave._fmu_state_from_bytes(forged(data, rng))
        except BadInput as error:
            assert "\n" not in str(error)
            seen["not read"] += 1
            continue
        slave._set_fmu_state(saved)
        taken = not slave.fault and slave.do_step(time, step)
        _, messages = slave.verdict()
        assert taken or (messages and "\n" not in messages[-1][2]), messages
        seen["taken" if taken else "rejected"] += 1
    return seen
