"""Where the wall time of a run goes: each participant's own work, and carrying values and states to
and fro.
"""

from time import perf_counter


class Timed:
    """A participant under a stopwatch; everything but the time it takes is the participant's own.

    Parameters
    ----------
    participant : Participant
    spent : dict of str to float
        Seconds by what they went into: steps and derivatives under the participant's name, all else
        under "transport".
    """

    def __init__(self, participant, spent):
        self.participant, self.spent = participant, spent
        spent.setdefault(participant.name, 0.0)

    def __getattr__(self, name):
        return getattr(self.participant, name)


def _measured(method, own):
    def call(self, *arguments):
        begin = perf_counter()
        try:
            return getattr(self.participant, method)(*arguments)
        finally:
            self.spent[self.participant.name if own else "transport"] += perf_counter() - begin

    return call


for _method in ("step", "begin_step", "end_step", "derivative"):
    setattr(Timed, _method, _measured(_method, own=True))
for _method in ("set", "get", "save", "restore", "free", "serialise", "deserialise"):
    setattr(Timed, _method, _measured(_method, own=False))


def split(spent, whole):
    """Summary entries [s]: what is in `spent`, and as acceleration the rest of the whole."""
    return {
        f"wall_time_{name}_s": seconds
        for name, seconds in (spent | {"acceleration": whole - sum(spent.values())}).items()
    }
