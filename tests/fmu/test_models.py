"""`run CASE --lubrication A --lubrication B`: a run with each model, as a user calls it."""

import numpy as np
import pytest

from piston_cosim.master.case.contract import swap_all
from piston_cosim.master.case.reading import find_case, read_tree
from piston_cosim.master.fmi.errors import BadInput
from piston_cosim.master.results.file import Results

from ..command import call
from .runs import coarse

SMALL = [f"--set={key}={value}" for key, value in coarse(("time.stop", "10 deg"))]


def run(folder, *words):
    return call("run", "numerical_example", "--only=flexible", *words, folder=folder)


def test_cavitation_models_differ_and_a_model_not_from_itself(tmp_path, fmu):
    (tmp_path / "same.fmu").write_bytes(fmu.read_bytes())
    done = run(
        tmp_path,
        *SMALL,
        "--set=participants.ehd.build.mask=none",  # the FMU was built without the case's mesh
        "--set=symmetric=false",  # given FMUs compute whole films
        *(f"--lubrication={model}" for model in ("jfo", "same.fmu", "gumbel")),
        "--output=out",
    )
    assert done.returncode == 0, done.stdout + done.stderr
    written = {path.name for path in (tmp_path / "out").iterdir()}
    assert {"motion.png", "film.png", "jfo.h5", "same.h5", "gumbel.h5"} <= written
    runs = [Results(tmp_path / "out" / f"{name}.h5") for name in ("jfo", "same", "gumbel")]
    films = [one.series("ehd.minimum_film_thickness").values for one in runs]
    assert np.array_equal(films[0], films[1]) and np.abs(films[2] - films[0]).max() > 1e-10


def test_every_fault_is_listed(tmp_path):
    done = run(tmp_path, "--lubrication=none.fmu", "--lubrication=no.fmu")
    assert done.returncode == 2
    assert "got 'none.fmu'" in done.stderr and "got 'no.fmu'" in done.stderr


def models(tree, *texts, labels=("base",)):
    return swap_all(dict.fromkeys(labels, tree), {"lubrication": texts}, print)


def test_a_label_names_variant_and_model():
    tree = read_tree(find_case("numerical_example"), [])
    made = models(tree, "jfo", "reynolds")
    parameters = [each["participants"]["ehd"]["parameters"] for each in made.values()]
    assert [values["cavitation_model"] for values in parameters] == ["jfo", "reynolds"]
    assert [*made] == ["jfo", "reynolds"] and made["jfo"]["pictures"] == tree["pictures"]
    both = models(tree, "jfo", "reynolds", labels=("rigid", "flexible"))
    assert {*both} == {f"{one}_{k}" for one in ("rigid", "flexible") for k in ("jfo", "reynolds")}
    assert [*models(tree, "jfo", labels=("rigid", "flexible"))] == ["rigid", "flexible"]
    with pytest.raises(BadInput, match="expected models of different names, got jfo, jfo"):
        models(tree, "jfo", "jfo")


def two_films():
    """Return the numerical example's tree with a second film."""
    tree = read_tree(find_case("numerical_example"), [])
    participants = tree["participants"] | {"pin": {"fmu": "pin.fmu", "role": "lubrication"}}
    return tree | {"participants": participants}


def test_with_two_films_the_one_to_replace_is_named():
    tree = two_films()
    with pytest.raises(
        BadInput, match="expected one of ehd, pin, got several; write --lubrication ehd=jfo"
    ):
        models(tree, "jfo", "reynolds")
    with pytest.raises(
        BadInput, match="expected one of ehd, pin, got unknown participant 'bodies'"
    ):
        models(tree, "bodies=jfo", "ehd=jfo")
    chosen = models(tree, "pin=jfo", "pin=gumbel")["gumbel"]["participants"]
    assert chosen["pin"]["parameters"] == {"cavitation_model": "gumbel"}
    assert chosen["ehd"] == tree["participants"]["ehd"]
