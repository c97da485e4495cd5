"""The two ways a user hears of trouble: bad input (all faults at once) and a step that cannot be taken."""


class BadInput(ValueError):
    """Input that cannot be used. Carries every fault found, so that the user mends them in one go.

    Parameters
    ----------
    faults : list of str
        One sentence each: what, where, value with unit, what is allowed.
    """

    def __init__(self, faults):
        self.faults = [faults] if isinstance(faults, str) else list(faults)
        super().__init__("\n".join(self.faults))


class Discard(RuntimeError):
    """A step that physics or numerics refuse: the FMU answers fmi2Discard, its state is untouched, the master retries."""
