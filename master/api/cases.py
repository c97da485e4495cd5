"""Cases in Python: open, change, run, sweep."""

import itertools
import logging
import sys
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, NamedTuple

from ..case import changes as changes_of
from ..case.checked import check_case
from ..case.contract import swap_all
from ..case.reading import find_case, name_of_case, read_tree
from ..case.system import open_system
from ..fmi.errors import BadInput, for_all
from ..participants.participant import Participant
from ..results.file import Results
from ..runs.completed import complete_run

log = logging.getLogger("piston_cosim")

Changes = Mapping[str, Any]
"""Dotted key of the case -> value: text with a unit ("20 mPa s"), number, bool, list."""


class Progress(NamedTuple):
    """Progress of a run after a macro step.

    share : completed share of the run, 0 to 1; time, stop : [s]; iterations : of the step;
    residual : largest residual over its tolerance; monitored : the case's monitor entries, name
    -> (value, SI unit).
    """

    share: float
    time: float
    stop: float
    iterations: int
    residual: float
    monitored: dict[str, tuple[float, str]]


@dataclass(frozen=True)
class Case:
    """Case to simulate, immutable; `changed` returns another one.

    It is created by `open_case`, or by `couple` for your own participants.

    Parameters
    ----------
    tree : dict
        The resolved TOML tree.
    path : Path
        Its file. Relative paths in the tree start from its folder.
    own : mapping of str to callable
        Participants that exist only in this process: name -> constructor.

    Examples
    --------
    >>> case = pc.open_case("two_mass_oscillator")
    >>> case.title
    'Two-mass oscillator: order of the coupled step by the inputs inside it'
    >>> case.variants
    ('hermite', 'linear', 'held')
    >>> shorter = case.changed({"time.stop": "0.03 s", "wires.0.tolerance": "1 nm"})
    >>> shorter["time.stop"], case["time.stop"]
    ('0.03 s', '1 s')
    >>> shares = []
    >>> results = shorter.run(progress=lambda step: shares.append(round(step.share, 2)))
    >>> shares
    [0.33, 0.67, 1.0]
    """

    tree: dict[str, Any]
    path: Path
    own: Mapping[str, Callable[[], Participant]] = field(
        default_factory=dict[str, Callable[[], Participant]]
    )

    def __post_init__(self) -> None:
        check_case(self.tree, self.path)

    @property
    def title(self) -> str:
        """Title of the case."""
        return self.tree["title"]

    @property
    def label(self) -> str:
        """Name of the case among its variants."""
        return self.tree.get("label", "base")

    @property
    def name(self) -> str:
        """Name of the case: its folder, or its file if that is not case.toml."""
        return name_of_case(self.path)

    @property
    def variants(self) -> tuple[str, ...]:
        """Labels of the case itself and of its variants."""
        return (self.label, *self.tree.get("variants", {}))

    def variant(self, label: str) -> "Case":
        """Return one of the case's variants; raise `BadInput` if the label is unknown."""
        changes = changes_of.changes_of_variant(self.tree, label, "variant")
        return self.changed({**changes, "label": label, "variants": {}, "beside": []})

    def changed(self, changes: Changes) -> "Case":
        """Return the case with other values.

        Parameters
        ----------
        changes : mapping
            Dotted key -> value: "participants.ehd.parameters.viscosity" -> "20 mPa s". Entries of a
            list have numbers from 0: "wires.0.tolerance" -> "2 nm".

        Raises
        ------
        BadInput
            With every unknown key and every invalid value.
        """
        return replace(self, tree=changes_of.changed(self.tree, changes.items(), self.path.parent))

    def __getitem__(self, key: str) -> Any:
        """Return the value at a dotted key, as in the case; raise `KeyError` if there is none."""
        return changes_of.value_at(self.tree, key, self.path.parent)

    def run(
        self,
        output: str | Path | None = None,
        progress: Callable[[Progress], object] | None = None,
        *,
        lubrication: type | str | Path | None = None,
        bodies: type | str | Path | None = None,
        uncertainty: bool = False,
    ) -> Results:
        """Run to the stop time; Ctrl-C ends the run after its macro step, with a checkpoint.

        Parameters
        ----------
        output : path, optional
            The results file. Default: results/NAME/LABEL.h5.
        progress : callable, optional
            Called with a `Progress` after every macro step. The logger "piston_cosim" reports the
            work before the first one (reduction of bodies, FMUs).
        lubrication, bodies : class, str or Path, optional
            Model that replaces the participant in this role: a model class, "FILE.py:CLASS" or an
            FMU. The class must be in a file that can be imported; its FMU is built and cached.
            "PARTICIPANT=MODEL" selects one of several participants.
        uncertainty : bool
            Compute the uncertainty of the main results from a second grid and doubled steps.

        Returns
        -------
        Results

        Raises
        ------
        BadInput
            With every fault that was found before the run.
        StepFailed
            If a macro step does not converge.
        """
        output = Path(output or Path("results") / self.name / f"{self.label}.h5").absolute()
        models = {"lubrication": _model(lubrication), "bodies": _model(bodies)}
        tree = swap_all({self.label: self.tree}, models, log.info)[self.label]
        checked = check_case(tree, self.path)
        system = open_system(checked, self.path.parent, log.info, self.own)
        watch = (_progress_observer(progress, system.begin),) if progress else ()
        what = system, checked, tree, output, *watch
        summary = complete_run(*what, say=log.info, log=log.info, uncertainty=uncertainty)
        if summary.get("loops_stepped_explicitly"):
            log.warning(
                "%s: loops with an FMU that cannot restore a saved state step without "
                "iteration; level INFO of this logger lists them",
                self.name,
            )
        for line in summary.get("warnings", ()):
            if line.startswith("wire ") or "expected a finite output" in line:
                log.warning("%s: %s", self.name, line)
        return Results(output)

    def __repr__(self) -> str:
        return f"<Case {self.name}, {self.label}: {self.title}>"


def _model(model: type | str | Path | None) -> list[str]:
    """Return a model as the command line writes it; raise BadInput for a class without a file."""
    if not isinstance(model, type):
        return [] if model is None else [str(model)]
    module = sys.modules[model.__module__]
    file = getattr(module, "__file__", None)
    if module.__name__ == "__main__" or file is None:
        raise BadInput(
            f"{model.__name__}: expected a class in a file of its own, got one of the running "
            "script or notebook; move it to a file and import it"
        )
    return [f"{file}:{model.__name__}"]


def _progress_observer(progress: Callable[[Progress], object], begin: float) -> Callable[..., None]:
    """Return `progress` as the `watch` of a run."""

    def watch(
        time: float, stop: float, solution: Any, monitored: dict[str, tuple[float, str]]
    ) -> None:
        share = (time - begin) / (stop - begin)
        residual = float(solution.history[-1])
        progress(
            Progress(
                share=share,
                time=time,
                stop=stop,
                iterations=solution.iterations,
                residual=residual,
                monitored=monitored,
            )
        )

    return watch


def open_case(case: str | Path, changes: Changes | None = None, variant: str | None = None) -> Case:
    """Open and check a case.

    Parameters
    ----------
    case : str or Path
        Name of an installed case ("numerical_example"), its folder, or a file: TOML or SSP.
    changes : mapping, optional
        Dotted key -> value, as for `Case.changed`.
    variant : str, optional
        Label of one of its variants.

    Raises
    ------
    BadInput
        With every fault of the file and its key.

    Examples
    --------
    >>> pc.open_case("numerical_example", variant="rigid")["participants.bodies.build.piston.modes"]
    0
    >>> pc.open_case("numerical_example", {"coupling.max_iterations": 0})
    Traceback (most recent call last):
    piston_cosim.master.fmi.errors.BadInput: coupling.max_iterations: expected ...
    """
    path = find_case(str(case))
    opened = Case(read_tree(path), path)
    if variant is not None:
        opened = opened.variant(variant)
    return opened.changed(changes) if changes else opened


def sweep(
    case: Case,
    vary: Mapping[str, Sequence[Any]],
    output: str | Path | None = None,
    workers: int | None = None,
    progress: Callable[[dict[str, Any], int, int], object] = lambda row, done, total: None,
    uncertainty: bool = False,
) -> list[dict[str, Any]]:
    """Run a case over all combinations of values of its keys.

    Parameters
    ----------
    case : Case
        Case from a file. Participants in this process cannot be used by other processes.
    vary : mapping
        Dotted key -> values.
    output : path, optional
        Folder of `sweep.csv` and the results of each run. Default: results/sweep_NAME. Finished
        runs of an earlier sweep are reused, failed ones are repeated.
    workers : int, optional
        Number of processes. Default: number of processors.
    progress : callable, optional
        Called with (row, number done, number of all) after each run.
    uncertainty : bool
        Compute the uncertainty of the main results from a second grid and doubled steps.

    Returns
    -------
    list of dict
        A row for each run, in the order of the combinations: its values, `results` (its file, a
        path in the folder), `status` ("done", "failed", "bad input"), `message`, the measures of a
        design with their uncertainties (`NAME_uncertainty`), and the entries of its summary.
        `pandas.DataFrame(rows)` is a table.

    Raises
    ------
    BadInput
        With every fault of every combination.
    """
    from ..runs import sweep as sweeps  # slow to import
    from ..runs.pool import LocalPool

    if case.own:
        raise BadInput(f"participants: expected FMUs in a sweep, got objects {', '.join(case.own)}")
    combinations = [dict(zip(vary, values)) for values in itertools.product(*vary.values())]
    points = for_all(lambda values: sweeps.Point(values, case.changed(values).tree), combinations)
    folder = Path(output or Path("results") / f"sweep_{case.name}").absolute()
    sweeps.build_all(sweeps.unfinished(points, folder, uncertainty), case.path.parent, log.info)
    with LocalPool(workers) as executor:
        return sweeps.sweep(points, case.path.parent, folder, executor, progress, uncertainty)
