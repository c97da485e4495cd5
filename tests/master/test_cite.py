"""Citations: every key has its work, and they follow what a case uses."""

import re
from pathlib import Path

import pytest
import yaml

import piston_cosim as pc
from piston_cosim.fmu_ehd.parameters import CHOICES as LAWS
from piston_cosim.master.api import cite

ROOT = Path(__file__).parents[2]


def cited(case):
    """Keys that are printed for a case."""
    return {line.split("]")[0][1:] for line in cite.citations(case)[2:]}


def test_the_project_and_the_paper_that_it_follows_are_cited(capsys):
    pc.cite()
    line, paper = capsys.readouterr().out.splitlines()
    assert line.startswith(f"The piston-cosim developers: piston-cosim {pc.__version__}.")
    doi = yaml.safe_load((ROOT / "CITATION.cff").read_text())["references"][0]["doi"]
    assert paper.startswith("[Kim2019] S. Kim and co-authors") and doi in paper
    assert cite.citations("data_sheet")[:2] == [line, paper]


def test_every_choice_that_has_a_reference_has_it_in_the_list():
    listed = set(re.findall(r"(?m)^\| \[(\w+)\]", (ROOT / "docs/references.md").read_text()))
    choices = [value for values in LAWS.values() for value in values]
    keys = {key for value in (*choices, *cite.CHOICES) for key in cite._of_choice(value)}
    keys |= {cite.STANDARD, *(key for keys in cite.PACKAGES.values() for key in keys)}
    assert {"Greenwood1970", "Patir1978", "Barus1893", "Vogel1921", "Craig1968"} <= keys
    assert keys - listed == set()


def test_a_case_cites_the_laws_that_it_uses():
    case = pc.open_case("numerical_example")
    assert {"Reynolds1886", "Jakobsson1957", "Olsson1965", "Greenwood1970"} <= cited(case)
    film = "participants.ehd.parameters."
    assert "Greenwood1970" not in cited(case.changed({film + "roughness_rms": "0 um"}))
    other = {film + "flow_factors": "patir_cheng_1978", film + "cavitation_model": "reynolds"}
    assert cited(case.changed(other)) - cited(case) == {"Patir1978"}
    assert cited(case) - cited(case.changed(other)) == {"Jakobsson1957", "Olsson1965"}


@pytest.mark.parametrize("modes, expected", [(20, {"Craig1968"}), (0, set())])
def test_a_basis_is_cited_if_the_body_is_flexible(modes, expected):
    piston = "participants.bodies.build.piston."
    case = pc.open_case("numerical_example")
    changed = case.changed({piston + "basis": "craig_bampton", piston + "modes": modes})
    assert cited(changed) - cited(case) == expected


def test_results_cite_what_their_run_used(tmp_path):
    case = pc.open_case("two_mass_oscillator", {"time.stop": "0.02 s"})
    with case.run(tmp_path / "run.h5") as results:
        assert cite.citations(results) == cite.citations(case)


def test_the_citation_file_has_its_references():
    citation = yaml.safe_load((ROOT / "CITATION.cff").read_text())
    scopes = {work["scope"] for work in citation["references"]}
    assert {"Reynolds equation", "Cavitation", "Asperity contact"} <= scopes
    for work in citation["references"]:
        assert work["authors"] and work["title"] and work["type"] and work["year"]
