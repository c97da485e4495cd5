"""Lubrication FMUs that replace the shipped one: a template, one in C, one without derivatives."""

import importlib
import re
import zipfile
from pathlib import Path

import numpy as np
import pytest
from pythonfmu.builder import FmuBuilder

import piston_cosim as pc
from piston_cosim.master.case.checked import check_case
from piston_cosim.master.case.contract import check_fmu, players, swap
from piston_cosim.master.case.reading import case_names, find_case, read_tree
from piston_cosim.master.commands.app import main
from piston_cosim.master.fmi.builder import build_fmu_of_file
from piston_cosim.master.fmi.errors import BadInput
from piston_cosim.master.participants.fmi2 import FmuParticipant

from .c_fmus import compile_model
from .runs import coarse, problems_of, run_tree

CELLS = (12, 10)
HERE = Path(__file__).parent
PATH = find_case("numerical_example")
TEMPLATE = PATH.parents[1] / "lubrication_template" / "axial_film.py"
SMALL = coarse(("time.stop", "20 deg"))


@pytest.fixture(scope="module")
def template():
    return build_fmu_of_file(f"{TEMPLATE}:AxialFilm", {"grid": list(CELLS)})


@pytest.fixture(scope="module")
def in_c(template, tmp_path_factory):
    """Build the template's model in C: its model description with a library without Python."""
    folder = tmp_path_factory.mktemp("c")
    library, fmu = folder / "axial_c.so", folder / "axial_c.fmu"
    sizes = f"-DN={CELLS[0]}", f"-DM={CELLS[1]}"
    compile_model(HERE / "axial_film.c", library, "-ffp-contract=off", *sizes)
    with zipfile.ZipFile(template) as source, zipfile.ZipFile(fmu, "w") as target:
        text = source.read("modelDescription.xml").decode()
        text = re.sub(r"<VendorAnnotations>.*</VendorAnnotations>", "", text, flags=re.S)
        target.writestr(
            "modelDescription.xml",
            text.replace('modelIdentifier="axial_film"', 'modelIdentifier="axial_c"'),
        )
        target.write(library, "binaries/linux64/axial_c.so")
    return fmu


def test_template_is_short_and_valid(template):
    assert len(TEMPLATE.read_text().splitlines()) < 60
    assert problems_of(template) == []


def test_fmu_in_c_computes_what_the_template_computes(template, in_c):
    rng = np.random.default_rng(5)
    forces = []
    for path in (template, in_c):
        participant = FmuParticipant("film", path)
        participant.start({}, 0.0, 1.0)
        rng = np.random.default_rng(5)
        for k in range(3):
            participant.set("film_thickness", 2e-5 + 1e-5 * rng.random(CELLS))
            participant.set("sliding_velocity", 5 * rng.random(CELLS))
            participant.step(k * 1e-4, 1e-4)
        forces.append(participant.get("nodal_pressure_force"))
        participant.close()
    np.testing.assert_allclose(forces[0], forces[1], rtol=1e-9, atol=1e-9)  # sums in another order
    assert forces[0].max() > 1.0


QUASI_NEWTON = [
    ("coupling.method", "iqn_ageing"),
    ("coupling.advanced.probing", True),
    ("coupling.max_iterations", 60),
]


def run_with(fmu, folder, changes=()):
    tree, left_out = swap(read_tree(PATH, [*SMALL, *changes]), "ehd", fmu)
    return run_tree(PATH, tree, folder / "run.h5"), left_out


def converged(summary):
    assert summary["unconverged_steps"] == 0 and summary["steps"] >= 20


def test_a_swapped_fmu_stays_isolated(template):
    """Isolation is the best way to run a foreign FMU.

    Its options are `--lubrication X.fmu --set participants.ehd.isolated=true`.
    """
    changes = [("participants.ehd.isolated", True), ("participants.ehd.timeout", "5 s")]
    tree, _ = swap(read_tree(PATH, [*SMALL, *changes]), "ehd", template)
    table = check_case(tree, PATH).participants["ehd"]
    assert table.isolated and table.timeout == "5 s" and table.fmu == str(template)


def test_both_run_the_numerical_example_to_the_same_result(template, in_c, tmp_path):
    """Both agree without derivatives.

    The template uses Newton on differences of two steps, the FMU in C quasi-Newton.
    """
    results = {}
    for name, fmu in (("template", template), ("c", in_c)):
        folder = tmp_path / name
        folder.mkdir()
        results[name], left_out = run_with(fmu, folder, QUASI_NEWTON if name == "c" else ())
        converged(results[name].summary)
        assert "participants.ehd.parameters.roughness_rms" in left_out
    one, two = (r.series("bodies.lateral_displacement")[0] for r in results.values())
    np.testing.assert_allclose(one[-1], two[-1], atol=2e-9)  # a step is converged to 1 nm
    assert abs(one[-1]) > 1e-7


def test_a_run_takes_a_model_class_or_its_file(template, tmp_path, monkeypatch):
    """The class is packed with the grid of the case: the same FMU, so the same results."""
    monkeypatch.syspath_prepend(TEMPLATE.parent)
    own = importlib.import_module(TEMPLATE.stem).AxialFilm
    case = pc.open_case("numerical_example", dict(SMALL), "rigid")
    models = {"class": own, "file": f"{TEMPLATE}:AxialFilm", "fmu": template}
    films = [
        case.run(tmp_path / f"{name}.h5", lubrication=model)
        .series("ehd.minimum_film_thickness")
        .values
        for name, model in models.items()
    ]
    assert np.array_equal(films[0], films[1]) and np.array_equal(films[0], films[2])
    monkeypatch.setattr(own, "__module__", "__main__")
    with pytest.raises(pc.BadInput, match="move it to a file"):
        case.run(lubrication=own)
    argv = ["piston-cosim", "run", "numerical_example", "--lubrication", f"{TEMPLATE}:NoFilm"]
    monkeypatch.setattr("sys.argv", argv)
    with pytest.raises(SystemExit, match="2"):
        main()


STATES = (
    "canGetAndSetFMUstate: expected true, got false; build it with `pythonfmu build --handle-state`"
)


def test_a_film_of_stock_pythonfmu_runs_at_the_first_attempt(tmp_path, monkeypatch):
    """It has no units, nominals or derivatives, and another grid than the case.

    Its state is kept variable by variable. Without saved states, check and run reject it alike, and
    the run does so before a body is built.
    """
    built = FmuBuilder.build_FMU
    fmu = built(HERE / "stock_film.py", dest=tmp_path / "stock.fmu", canGetAndSetFMUstate=True)
    role, breaches, remarks = check_fmu(fmu)
    assert (role, breaches) == ("lubrication", [])
    assert any("no unit" in line and "film_thickness [m]" in line for line in remarks)
    names = [
        f"ehd.{name}" for name in ("film_thickness", "sliding_velocity", "nodal_friction_force")
    ]
    changes = coarse(*QUASI_NEWTON, ("time.stop", "20 deg"), ("record.fields", names), grid=(16, 8))
    case = pc.open_case("numerical_example", dict(changes), "rigid")
    results = case.run(tmp_path / "run.h5", lubrication=fmu)
    converged(results.summary)
    assert results.summary["derivative_products"] == 0
    assert np.ptp(results.series("bodies.lateral_displacement")[0]) > 1e-8
    film, speed, friction = (results.dataset(name)[-1] for name in names)
    assert film.shape == CELLS
    area = 27e-3 / CELLS[1] * 2 * np.pi * 28.25e-3 / CELLS[0]
    # the 6 mPa s of the case, in the unit that the FMU does not declare; 3 products round
    np.testing.assert_allclose(friction, -6e-3 * speed / film * area, rtol=1e-12)
    plain = built(HERE / "stock_film.py", dest=tmp_path / "plain.fmu")
    assert check_fmu(plain)[1] == [STATES]
    monkeypatch.setattr("piston_cosim.fmu_mfbd.build.prepare", None)
    with pytest.raises(BadInput, match=re.escape(STATES)):
        case.run(tmp_path / "plain.h5", lubrication=plain)


def test_the_body_takes_the_grid_of_a_film_and_the_modes_that_it_resolves():
    """12 x 8 cells resolve 96 modes, and the film of another model may be asymmetric."""
    fmu = build_fmu_of_file(f"{TEMPLATE}:AxialFilm", {"grid": [12, 8]})
    told = []
    tree, _ = swap(read_tree(find_case("fired_motorcycle")), "ehd", fmu, told.append)
    build = tree["participants"]["bodies"]["build"]
    assert (build["grid"], build["piston"]["modes"], build["block"]["modes"]) == ([12, 8], 96, 112)
    changes, _, reason = told[0].rpartition(": ")
    assert reason == "the grid of the FMU of ehd"
    assert set(changes.split("participants.bodies.build.")) == {
        "",
        "grid = [12, 8], ",
        "piston.symmetric_film = False, ",
        "piston.modes = 96, ",
        "block.symmetric_film = False",
    }


def test_the_film_takes_the_grid_of_a_body(bodies_fmu):
    told = []
    tree = read_tree(find_case("data_sheet"))
    changed, _ = swap(tree, "bodies", bodies_fmu, told.append)
    grid = list(FmuParticipant("bodies", bodies_fmu).fields["film_thickness"].shape)
    assert changed["participants"]["ehd"]["build"]["grid"] == grid
    assert grid != tree["participants"]["ehd"]["build"]["grid"]
    assert told == [f"participants.ehd.build.grid = {grid}: the grid of the FMU of bodies"]


def test_a_film_fits_every_shipped_case_or_is_rejected_before_a_body_is_reduced(template):
    """It has 12 x 10 cells and slides along the bore."""
    around = "circumferential_velocity, nodal_circumferential_force for its wires, got one without"
    shape = r"shape \(40, 19\), got \(12, 10\); build the FMU on the grid"
    pin = ["left_film", "right_film", "small_end_film"]
    bearings = {"floating_pin": pin, "yielding_bosses": pin}
    six = [*pin, "big_end_film", "main_film"]
    bearings |= dict.fromkeys(["crank_bearings", "whole_engine"], six)
    rejected = {(case, film): around for case, films in bearings.items() for film in films}
    rejected |= {("grooved_skirt", film): shape for film in ("lower_film", "upper_film")}
    fits = 0
    for case in case_names():
        tree = read_tree(find_case(case))
        for name in players(tree, "lubrication"):
            if words := rejected.pop((case, name), None):
                with pytest.raises(BadInput, match=f"participants.{name}: expected .*{words}"):
                    swap(tree, name, template)
            else:
                fits += swap(tree, name, template)[0]["participants"][name]["fmu"] == str(template)
    assert not rejected and fits >= 10


def test_check_lists_what_is_missing(template, fmu, bodies_fmu):
    role, breaches, remarks = check_fmu(template)
    assert (role, breaches) == ("lubrication", [])
    assert any(line.startswith("mass_imbalance") for line in remarks)
    assert check_fmu(fmu) == ("lubrication", [], [])
    assert check_fmu(bodies_fmu) == ("bodies", [], [])


def described(fmu, path, **words):
    """Write the description of an FMU alone, with some words replaced."""
    with zipfile.ZipFile(fmu) as source, zipfile.ZipFile(path, "w") as target:
        text = source.read("modelDescription.xml").decode()
        for old, new in words.items():
            text = text.replace(old, new)
        target.writestr("modelDescription.xml", text)
    return path


def test_check_lists_every_breach(fmu, tmp_path):
    states = {'canGetAndSetFMUstate="true"': 'canGetAndSetFMUstate="false"'}
    words = {'name="sliding_velocity[': 'name="slide[', 'name="contract_version"': 'name="version"'}
    _, breaches, _ = check_fmu(described(fmu, tmp_path / "wrong.fmu", **states, **words))
    assert len(breaches) == 3
    assert any("canGetAndSetFMUstate" in b for b in breaches)
    assert any(b.startswith("sliding_velocity") for b in breaches)
    words = "expected the outputs of one of lubrication, bodies, got others"
    with pytest.raises(BadInput, match=words):
        check_fmu(described(fmu, tmp_path / "other.fmu", nodal_pressure_force="load"))


def test_missing_file_or_class_is_bad_input(tmp_path):
    with pytest.raises(
        BadInput, match="file: expected an existing FILE.py:CLASS, got .*none.py:Film"
    ):
        build_fmu_of_file(f"{tmp_path}/none.py:Film", {"grid": [4, 4]})
    with pytest.raises(BadInput, match="file: expected a class of .*, got 'Film'"):
        build_fmu_of_file(f"{TEMPLATE}:Film", {"grid": [4, 4]})
    (tmp_path / "no_slave.py").write_text("class Film: pass")
    with pytest.raises(BadInput, match="from Slave, got 'Film'"):
        build_fmu_of_file(f"{tmp_path}/no_slave.py:Film", {"grid": [4, 4]})


def test_dry_contact_pushes_only_where_the_gap_is_closed():
    fmu = build_fmu_of_file(f"{TEMPLATE.parent}/dry_contact.py:DryContact", {"grid": list(CELLS)})
    assert problems_of(fmu) == []
    assert check_fmu(fmu)[:2] == ("lubrication", [])
    tree, left_out = swap(read_tree(PATH.parents[1] / "data_sheet/case.toml"), "ehd", fmu)
    # the instant of maps.png is that of the maximum pressure, which this FMU lacks
    assert "pictures.maps.png: ehd.maximum_pressure" in left_out
    assert [picture["file"] for picture in tree["pictures"]] == ["motion.png"]
    participant = FmuParticipant("dry", fmu)
    gap = np.full(CELLS, 2e-5)
    gap[3, 4] = 0.0  # 1 um of overlap
    participant.start({"film_thickness": gap}, 0.0, 1.0)
    participant.set("sliding_velocity", np.full(CELLS, 5.0))
    participant.step(0.0, 1e-4)  # nothing closes: the spring alone
    area = 27e-3 / CELLS[1] * 2 * np.pi * 28.25e-3 / CELLS[0]
    force = participant.get("nodal_pressure_force")
    assert np.flatnonzero(force).tolist() == [3 * CELLS[1] + 4]
    assert force[3, 4] == pytest.approx(1e12 * 1e-6 * area, rel=1e-12)
    assert participant.get("nodal_friction_force")[3, 4] == pytest.approx(
        -0.1 * force[3, 4], rel=1e-12
    )  # tanh(500) = 1
    participant.close()
