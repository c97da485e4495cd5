"""How benches take times."""

from time import perf_counter


def shortest(work, repeats):
    """Shortest of several runs [s]."""
    times = []
    for _ in range(repeats):
        begin = perf_counter()
        work()
        times.append(perf_counter() - begin)
    return min(times)
