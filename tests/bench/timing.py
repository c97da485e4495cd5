"""How benches take times."""

from time import perf_counter


def shortest(work, repeats, before=lambda: None):
    """Shortest of several runs [s]; `before` each, untimed, something else."""
    times = []
    for _ in range(repeats):
        before()
        begin = perf_counter()
        work()
        times.append(perf_counter() - begin)
    return min(times)
