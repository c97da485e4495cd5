"""Citations of the project and of the models that a case uses."""

import re
import sys
from importlib.metadata import metadata
from pathlib import Path
from typing import Any

from ..case.checked import check_case
from ..case.keys import declared_variables
from ..fmi.quantities import to_si
from ..fmi.tree import ROOT
from ..results.file import Results
from .cases import Case, open_case

REFERENCES = "docs/references.md"
STANDARD = "FMI2022"
PAPER = "Kim2019"
"""The paper whose method the project follows."""

PACKAGES = {"fmu_ehd": ("Reynolds1886",), "fmu_mfbd": ("Shabana2013", "Chung1993", "Arnold2007")}
"""References of a participant by its package."""

CHOICES = {
    "jfo": ("Jakobsson1957", "Olsson1965"),
    "power_fit": ("Greenwood1970",),
    "bore": ("Ma1997",),
    "bore_and_ring": ("Ma1997",),
    "craig_bampton": ("Craig1968",),
    "characteristic_constraint_modes": ("Castanier2001",),
    "aitken": ("Kuettler2008",),
    "iqn_ils": ("Degroote2009",),
    "iqn_ageing": ("Haelterman2016",),
}
"""References of a choice whose name does not contain author and year."""

LAW = re.compile(r"(?P<author>[a-z]+)(?:_[a-z]+)*_(?P<year>\d{4})")
ROUGH = ("contact_law", "flow_factors")
"""Choices without effect between smooth surfaces."""


def cite(source: Case | Results | str | Path | None = None) -> None:
    """Print how to cite the project, the paper that it follows, and the models in use.

    Parameters
    ----------
    source : Case, Results, str or Path, optional
        Case or results whose models are listed. If omitted, only project and paper are printed.

    Examples
    --------
    >>> pc.cite("data_sheet")  # doctest: +ELLIPSIS
    The piston-cosim developers: piston-cosim ...
    [Kim2019] S. Kim and co-authors, ...
    [Arnold2007] M. Arnold, O. Brüls, ...
    """
    print("\n".join(citations(source)))


def citations(source: Case | Results | str | Path | None = None) -> list[str]:
    """Return the lines that `cite` prints."""
    about = metadata("piston-cosim")
    own = f"{about['Author']}: {about['Name']} {about['Version']}. {about['Summary']}."
    works = dict(re.findall(r"(?m)^\| \[(\w+)\] \| (.+) \|$", _references()))
    project = [own, f"[{PAPER}] {works[PAPER]}"]
    if source is None:
        return project
    if not isinstance(source, (Case, Results)):
        source = open_case(source)
    tree = source.tree if isinstance(source, Case) else source.case
    return [*project, *(f"[{key}] {works[key]}" for key in sorted(keys_in_use(tree, source.path)))]


def _references() -> str:
    """Return the list of references of this installation."""
    return (Path(sys.modules[ROOT].__path__[0]) / REFERENCES).read_text(encoding="utf-8")


def keys_in_use(tree: dict[str, Any], path: Path) -> set[str]:
    """Return the keys of the references of all models that a case uses."""
    case = check_case(tree, path)
    keys = {STANDARD, *_of_choice(case.coupling.method)}
    for table in case.participants.values():
        keys.update(PACKAGES.get(table.package or "", ()))
        for choice in (*_laws(table, path.parent), *_bases(table.build)):
            keys.update(_of_choice(choice))
    return keys


def _of_choice(value: str) -> tuple[str, ...]:
    """Return the references of a choice, by its name or by author and year."""
    if match := LAW.fullmatch(value):
        return (f"{match['author'].capitalize()}{match['year']}",)
    return CHOICES.get(value, ())


def _laws(table: Any, folder: Path) -> list[str]:
    """Return the choices of a participant, as given or by default."""
    parameters = table.parameters
    rough = to_si(parameters.get("roughness_rms", "0 m"), "m") > 0.0
    return [
        str(parameters.get(variable.name, variable.start))
        for variable in declared_variables(table, folder) or ()
        if variable.choices and (rough or variable.name not in ROUGH)
    ]


def _bases(build: dict[str, Any]) -> list[str]:
    """Return the bases of the flexible bodies."""
    bodies: list[dict[str, Any]] = [body for body in build.values() if isinstance(body, dict)]
    return [body["basis"] for body in bodies if "basis" in body and body.get("modes") != 0]
