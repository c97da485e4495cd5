"""How a user hears of trouble: bad input (all faults at once), a step that cannot be taken, a run
that stops, a bug in a participant.
"""


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
    """A step that physics or numerics refuse: the FMU answers fmi2Discard, its state is untouched,
    the master retries.
    """


class Ticked(Discard):
    """A clock ticks inside a step, at `time` [s]: it is to be taken to there, so that others hear
    of it.
    """

    def __init__(self, name, time):
        super().__init__(f"{name}: a clock ticks at t = {time:.6g} s")
        self.name, self.time = name, time

    def __reduce__(self):
        return Ticked, (self.name, self.time)


class Finished(RuntimeError):
    """A participant asks for the end of the simulation inside a step: what was accepted before
    stands.
    """


class Stopped(RuntimeError):
    """A run that came to an end before its own: what was accepted stands, notes say how to go on.

    Attributes
    ----------
    headline : str
        Of all runs that stop so; "" where what the error says is headline enough.
    """

    headline = ""


class ParticipantFault(Stopped):
    """A bug inside a participant: its traceback, as it logged it; or its process has hung or
    ended.
    """

    headline = "an FMU reports a fault of its own"
