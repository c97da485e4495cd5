"""Figures of the coupling methods, on whole runs through FMUs: rows for `piston-cosim verify
master`.
"""

from functools import partial
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

from piston_cosim.master.case.checked import check_case
from piston_cosim.master.case.reading import find_case, read_tree
from piston_cosim.master.case.system import open_system
from piston_cosim.master.coupling.stepping import StepFailed
from piston_cosim.master.results.compare import score
from piston_cosim.master.results.file import Results
from piston_cosim.master.runs.run import run

from .checks import Check, at_most

TWO_TURNS = ("time.stop", "720 deg")
"""Change of the numerical example: as many steps with every method."""


def run_of(name, changes, file):
    """Summary of a case run with changes (pairs of dotted key and value); results go to a file."""
    path = find_case(name)
    tree = read_tree(path, changes)
    case = check_case(tree, path)
    return run(open_system(case, path.parent, lambda text: None), case, tree, file)


def summary_of(name, *changes, look=lambda results: {}):
    """Summary of a case run with changes, and what `look` finds in its results."""
    with TemporaryDirectory() as folder:
        file = Path(folder) / "run.h5"
        return run_of(name, changes, file) | look(Results(file))


def tube_iterations(*changes):
    return summary_of("elastic_tube", *changes)["residual_evaluations"]


def checks():
    """Elastic tube with the settings of preCICE's tutorial, whose own log needs 846 iterations."""
    yield at_most(
        "Elastic tube, 100 windows",
        "iterations of IQN-ILS [-]",
        tube_iterations(),
        870,
        "reference log of preCICE (846)",
        "same method and settings: rounding in threads and inflow changes the number "
        "from 838 to 849",
    )
    yield at_most(
        "Elastic tube, 100 windows",
        "iterations of IQN-ILS with quadratic predictor [-]",
        tube_iterations(("coupling.predictor", 2)),
        700,
        "design target",
        "a better initial guess reduces the iterations",
    )
    yield at_most(
        "Elastic tube, 100 windows",
        "iterations of ageing secants [-]",
        tube_iterations(("coupling.method", "iqn_ageing")),
        846,
        "reference log of preCICE (846)",
        "secants that lose weight with age need no filter",
    )
    yield from oscillator_checks()


def oscillator_error(interpolation, step):
    """Largest error of either mass over [0, 1] s.

    Eq. (Z1):  u = (cos 2 pi t + cos 6 pi t)/2 of the left mass,
                   (cos 2 pi t - cos 6 pi t)/2 of the right one
    """

    def error(results):
        slow, fast = (np.cos(2 * k * np.pi * results.time) / 2 for k in (1, 3))
        exact = {"left": slow + fast, "right": slow - fast}  # Eq. (Z1)
        return {
            "error": max(
                np.max(np.abs(results.series(f"{name}.displacement")[0] - u))
                for name, u in exact.items()
            )
        }

    changes = [(f"wires.{k}.interpolation", interpolation) for k in (0, 1)]
    return summary_of("two_mass_oscillator", *changes, ("time.step", f"{step} s"), look=error)[
        "error"
    ]


def oscillator_checks():
    """preCICE's oscillator: the error at a step of 0.01 s, and the order observed from there to
    0.005 s.
    """
    source = "closed form"
    for kind, order, reference, tolerance, reason in (
        (
            "held",
            1,
            0.404,
            0.01,
            "the reference holds inputs at the step's beginning, we at its end: equal to first "
            "order",
        ),
        (
            "mean",
            2,
            1.32e-2,
            0.01,
            "the deviation from linear inputs adds their error again",
        ),
        ("linear", 2, 6.6e-3, 0.01, "the reference has two digits"),
        ("hermite", 4, 3.4e-6, 0.015, "the reference has two digits"),
    ):
        coarse, fine = (oscillator_error(kind, step) for step in (0.01, 0.005))
        yield Check(
            "Two-mass oscillator",
            f"largest error with {kind} inputs [m]",
            coarse,
            reference,
            tolerance,
            "relative",
            source,
            reason,
        )
        yield Check(
            "Two-mass oscillator",
            f"observed order with {kind} inputs [-]",
            np.log2(coarse / fine),
            order,
            0.05,
            "absolute",
            source,
            "next term of the error at these steps",
        )


def slow_checks():
    """The numerical example whole, with derivatives and without, and the fired one with adaptive
    steps.
    """
    yield at_most(
        "Elastic tube, window 1",
        "convergence of plain Gauss-Seidel, 1 or 0 [-]",
        plain_converges(),
        0,
        "known divergence",
        "unrelaxed iteration diverges on this tube",
    )
    for modes in (0, 20, 200):
        yield at_most(
            f"Numerical example, {modes} modes per body",
            "mean iterations per step [-]",
            summary_of("numerical_example", TWO_TURNS, *modes_a_body(modes))["mean_iterations"],
            2.5,
            "design target",
            "the iterations do not grow with the number of modes",
        )
    flexible = summary_of("numerical_example", TWO_TURNS, look=films)
    case = "Numerical example, 60 modes per body"
    yield at_most(
        case,
        "mean iterations per step [-]",
        flexible["mean_iterations"],
        2.5,
        "design target",
        "Newton's second evaluation of most steps is below the tolerance",
    )
    yield at_most(
        case,
        "largest mass imbalance [-]",
        flexible["mass_imbalance_max"],
        1e-12,
        "conservation",
        "round-off",
    )
    yield at_most(
        case,
        "difference in interface work over exchanged work [-]",
        abs(flexible["interface_work_imbalance"]),
        1e-6,
        "conservation",
        "films of some micrometres agree to 1 nm",
    )
    yield at_most(
        case,
        "largest interface work error [-]",
        flexible["interface_work_error_max"],
        1e-10,
        "conservation",
        "round-off",
    )
    aged = summary_of("numerical_example", TWO_TURNS, *WITHOUT_DERIVATIVES, look=films)
    yield at_most(
        case,
        "unconverged steps without derivatives [-]",
        aged["unconverged_steps"],
        0,
        "design target",
        "ageing secants",
    )
    yield at_most(
        case,
        "mean evaluations per step without derivatives, with probes [-]",
        aged["residual_evaluations"] / aged["steps"],
        8.0,
        "design target",
        "ageing secants",
    )
    apart = float(np.max(np.abs(aged["films"] - flexible["films"])))
    yield at_most(
        case,
        "film thickness, difference with and without derivatives [m]",
        apart,
        1e-9,
        "tolerance of the film thickness",
        "both converge to this tolerance in every step",
    )
    yield from convergence_checks()
    yield from adaptive_checks()


def convergence_checks():
    """What the numerical example's grid, step, modes and tolerance are worth: rms distance from
    finer ones, first turn.

    Modes are checked for a plainly oval skirt, and for the nearly round one of the case with modes
    added for the film of the case.
    """
    case = check_case(read_tree(path := find_case("numerical_example"), ()), path)
    worth = partial(_convergence, case)
    yield from worth("grid", "40 x 40", "80 x 80", 0.05)
    yield from worth("step", "1 deg", "0.25 deg", 0.01)
    yield from worth("tolerance", "1 nm", "0.1 nm", 1e-6)
    oval = (("participants.bodies.parameters.ovality", "150 um"),)
    yield from worth(
        "modes",
        "smooth_pressure_modes 40",
        "smooth_pressure_modes 60",
        0.01,
        (oval, oval),
        "oval skirt, modes",
    )
    with TemporaryDirectory() as folder:
        results = Path(folder) / "first.h5"
        run_of("numerical_example", (("time.stop", "360 deg"),), results)
        trained = tuple(
            (f"participants.bodies.build.{body}.{key}", value)
            for body in ("piston", "block")
            for key, value in (("basis", "trained"), ("train_on", str(results)))
        )
        yield from worth(
            "modes",
            "smooth_pressure_modes 60",
            "smooth_pressure_modes 200",
            0.01,
            (trained, ()),
            "60 modes and modes of the run instead of",
        )


def _convergence(case, name, standard, finer, share, changes=((), ()), words=None):
    """Distances of two points of a study, each with changes of its own."""
    study = case.studies[name]
    runs = [
        summary_of(
            "numerical_example",
            *study.set.items(),
            *study.points[point].items(),
            ("time.stop", "360 deg"),
            *more,
            look=partial(series_of, study),
        )
        for point, more in zip((standard, finer), changes)
    ]
    for port in study.curves:
        yield at_most(
            f"Numerical example, {words or name} {standard}",
            f"{port.split('.')[1]}, rms difference from {finer} over range [-]",
            score(*runs[0][port], *runs[1][port]).rms,
            share,
            "finer run",
            "first or second order, with a margin of two",
        )


def series_of(study, results):
    """Abscissa and values of every curve of a study."""
    x = results.series(study.x).values
    return {port: (x, results.series(port).values) for port in study.curves}


def films(results):
    """All recorded film thicknesses of a run."""
    return {"films": results.whole.dataset("bodies.film_thickness")[:]}


def adaptive_checks():
    """The fired engine with steps by local error and in steps of 1 deg: each curve's error against
    steps of 0.125 deg.

    From 30 deg on, because the start from rest rings elastic modes that no step resolves: in the
    first 5 deg the highest pressure still differs by a quarter of its range between steps of 1/32
    and 1/64 deg.
    """
    case = check_case(read_tree(path := find_case("fired_motorcycle"), ()), path)
    study = case.studies["step"]
    fine, fixed, adaptive = (
        summary_of(
            "fired_motorcycle",
            *study.set.items(),
            *study.points[point].items(),
            look=partial(curves, study.curves),
        )
        for point in (study.reference, "1 deg", "adaptive")
    )
    case = "Fired engine, two cycles, steps by local error"
    yield at_most(
        case,
        "macro steps over those of 1 deg [-]",
        adaptive["steps"] / fixed["steps"],
        0.5,
        "design target",
        "steps between impacts are long",
    )
    yield at_most(
        case,
        "evaluations with rejected steps over those of 1 deg [-]",
        adaptive["residual_evaluations"] / fixed["residual_evaluations"],
        1.0,
        "steps of 1 deg",
        "fewer steps need fewer evaluations",
    )
    ours, theirs = (distances(run, fine, fine["time"][-1] * 30 / 1440) for run in (adaptive, fixed))
    worst = [
        max(errors[port][0] / np.ptp(fine["curves"][port]) for port in study.curves)
        for errors in (ours, theirs)
    ]
    yield at_most(
        case,
        "largest error of all curves over that of 1 deg [-]",
        worst[0] / worst[1],
        1.0,
        "design target",
        "the same accuracy for the worst curve and instant",
    )
    for port in study.curves:
        for kind, own, other in zip(("largest", "rms"), ours[port], theirs[port]):
            yield at_most(
                case,
                f"{kind} error of {port.split('.')[1]} over that of 1 deg [-]",
                own / other,
                2.4**2,
                "steps of 0.125 deg",
                "second order, and no step is longer than 2.4 deg",
            )


def distances(run, fine, begin):
    """Largest and root mean square difference of every curve from a finer run, at the run's own
    times from `begin` [s] on.

    Eq. (Z2):  max |d|,  sqrt(integral of d^2 dt / T) by trapezia
    """
    late = run["time"] >= begin
    time = run["time"][late]
    apart_by_port = {}
    for port, values in run["curves"].items():
        apart = values[late] - np.interp(time, fine["time"], fine["curves"][port])
        mean_square = (
            np.sum(np.diff(time) * (apart[1:] ** 2 + apart[:-1] ** 2)) / 2 / (time[-1] - time[0])
        )
        apart_by_port[port] = np.max(np.abs(apart)), np.sqrt(mean_square)  # Eq. (Z2)
    return apart_by_port


def curves(ports, results):
    """Times and some scalar outputs of a run."""
    return {"time": results.time, "curves": {port: results.series(port)[0] for port in ports}}


WITHOUT_DERIVATIVES = (
    ("coupling.method", "iqn_ageing"),
    ("coupling.probing", True),
    ("coupling.max_iterations", 60),
)


def modes_a_body(count):
    """Changes that give each body that many modes."""
    return tuple((f"participants.bodies.build.{body}.modes", count) for body in ("piston", "block"))


def plain_converges():
    """1 if unrelaxed Gauss-Seidel gets through the first window of the tube, else 0."""
    try:
        summary_of(
            "elastic_tube",
            ("coupling.method", "constant"),
            ("coupling.relaxation", 1.0),
            ("coupling.halvings", 0),
            ("time.stop", "0.01 s"),
        )
        return 1
    except StepFailed:
        return 0
