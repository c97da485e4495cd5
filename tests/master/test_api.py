"""The Python interface: `help()` is enough, examples run, and what it gives is what a run holds."""

import doctest
import inspect
import re
import sys
from pathlib import Path
from types import SimpleNamespace
from typing import NamedTuple

import numpy as np
import pytest

import piston_cosim as pc
from piston_cosim.fmu_mfbd.offline import BodyReport
from piston_cosim.master.api import fmus
from piston_cosim.master.results.labelled import to_dataframe
from piston_cosim.master.results.plots import Plots
from piston_cosim.master.results.recorded import RecordedField

from ..command import call, script

DOCUMENTED = [name for name in pc.__all__ if name not in ("variables", "Slave")]
ERRORS = ("BadInput", "Discard", "StepFailed")


@pytest.fixture
def here(tmp_path, monkeypatch):
    """Change to an empty working folder."""
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.fixture
def oscillator(here):
    """Three steps of the two-mass oscillator."""
    return pc.open_case("two_mass_oscillator", {"time.stop": "0.03 s"}).run()


@pytest.fixture(scope="module")
def skirt(tmp_path_factory):
    """Run a rigid skirt on a coarse grid for 8 deg; fields are recorded at every second degree.

    No step is repeated in parts, which would be rows of their own.
    """
    changes = {
        "time.stop": "8 deg",
        "participants.bodies.build.grid": [16, 8],
        "participants.ehd.build.grid": [16, 8],
        "participants.bodies.parameters.impact_resolution": "1 m",
        "record.every": 2,
    }
    return pc.open_case("data_sheet", changes).run(tmp_path_factory.mktemp("skirt") / "rigid.h5")


@pytest.fixture
def objects(skirt):
    """Kind -> object of all that a user holds."""
    film = pc.Film((8, 4))
    film.start(1e-5, sliding_velocity=1.0)
    return {
        "Case": pc.open_case("two_mass_oscillator"),
        "Results": skirt,
        "Plots": skirt.plot,
        "Series": skirt.series("ehd.friction_power"),
        "RecordedField": RecordedField(np.ones((8, 4)), 1e-3, "Pa", "Pressure"),
        "Film": film,
        "BodyReport": BodyReport("piston", [], 10, 5, 30, 0.1, np.zeros(3), np.eye(3), 1.0, 1, []),
        "Memory of a film": film.state,
    }


def test_a_repr_is_one_short_line_without_an_address(objects):
    shown = {kind: repr(one) for kind, one in objects.items()}
    for kind, text in shown.items():
        assert text.startswith(f"<{kind}") and len(text) <= 120 and "\n" not in text
        assert not re.search(r"\bat 0x[0-9a-f]+", text)
    assert "8 x 4 cells" in shown["Film"] and "9 values from" in shown["Series"]
    assert shown["RecordedField"] == "<RecordedField Pressure: 8 x 4 values from 1 to 1 Pa>"
    assert shown["Memory of a film"] == "<Memory of a film: 8 x 4 cells>"


@pytest.mark.parametrize(
    "thing", [*map(pc.__getattr__, DOCUMENTED), Plots], ids=lambda t: t.__name__
)
def test_examples_run(here, thing):
    finder = doctest.DocTestFinder(recurse=False)
    runner = doctest.DocTestRunner(verbose=False, optionflags=doctest.ELLIPSIS)
    tests = finder.find(thing, globs={"pc": pc, "np": np})
    for test in tests:
        runner.run(test, out=sys.stderr.write)
    assert runner.failures == 0
    # the others are run by tests of their own
    assert runner.tries > 0 or thing.__name__ in ERRORS + (
        "open_results",
        "reduce_bodies",
        "sensitivities",
        "sweep",
    )


@pytest.mark.parametrize("name", pc.__all__)
def test_every_public_name_is_documented_and_typed(name):
    thing = getattr(pc, name)
    assert inspect.getdoc(thing)
    callables = [thing] if inspect.isfunction(thing) else []
    if inspect.isclass(thing) and name not in (*ERRORS, "Slave"):
        members = [m for m in vars(thing).values() if inspect.isfunction(m)]
        callables = [m for m in members if not m.__name__.startswith("_")]
        assert all(inspect.getdoc(m) for m in callables)
    for one in callables:
        signature = inspect.signature(one)
        parameters = [p for p in signature.parameters.values() if p.name != "self"]
        assert all(p.annotation is not p.empty for p in parameters), one
        assert signature.return_annotation is not signature.empty, one


def test_importing_is_cheap():
    """Parts of the package, and what they need, are imported when they are used."""
    code = (
        "import sys; import typing; before = set(sys.modules); import piston_cosim as pc;"
        "print(*set(sys.modules) - before)"
    )
    assert script(code).split() == ["piston_cosim"]


def test_an_unknown_name_is_an_attribute_error():
    with pytest.raises(AttributeError, match="no attribute 'run_case'"):
        pc.run_case  # noqa: B018
    assert set(pc.__all__) <= set(dir(pc))


def test_a_case_changed_leaves_the_first_as_it_was():
    case = pc.open_case("numerical_example")
    thick = case.changed({"participants.ehd.parameters.viscosity": "20 mPa s"})
    assert case["participants.ehd.parameters.viscosity"] == "6 mPa s"
    assert thick["participants.ehd.parameters.viscosity"] == "20 mPa s"
    assert thick["wires.0.tolerance"] == "10 nm"
    assert case.variant("rigid").label == "rigid"
    assert case.variant("rigid")["participants.bodies.build.block.modes"] == 0
    assert repr(case).startswith("<Case numerical_example, flexible: Motored single")
    with pytest.raises(KeyError, match="no.such"):
        case["no.such"]


def test_a_run_is_that_of_the_command(oscillator, here):
    words = "run two_mass_oscillator --only hermite --output command --set".split()
    assert call(*words, "time.stop=0.03 s").returncode == 0
    other = pc.open_results("command/hermite.h5")
    with pytest.raises(pc.BadInput, match="there is no recorded field, got 'left.nope'"):
        other.field("left.nope", 0.0)
    with pytest.raises(pc.BadInput, match="unknown scalar output 'left.displacment'; did you mean"):
        other.series("left.displacment")
    for port in other.ports:
        assert np.array_equal(other.series(port).values, oscillator.series(port).values)
    assert oscillator.path == here / "results" / "two_mass_oscillator" / "hermite.h5"


def test_progress_is_told_after_every_step(here):
    steps = []
    changes = {"time.stop": "0.03 s", "monitor": {"x": "last left.displacement"}}
    results = pc.open_case("two_mass_oscillator", changes).run(progress=steps.append)
    assert [step.time for step in steps] == pytest.approx([0.01, 0.02, 0.03])
    assert [step.share for step in steps] == pytest.approx([1 / 3, 2 / 3, 1])
    last, unit = steps[-1].monitored["x"]
    assert (last, unit) == (results.series("left.displacement").values[-1], "m")
    assert [step.iterations for step in steps] == list(
        results.series("coupling.iterations").values[1:]
    )


def test_an_exception_in_progress_ends_the_run(here):
    def refuse(step):
        raise ZeroDivisionError

    with pytest.raises(ZeroDivisionError):
        pc.open_case("two_mass_oscillator").run("run.h5", refuse)
    assert not (here / "run.h5").exists()
    assert (here / "run.h5.partial").exists()


def test_results_as_xarray_have_named_dimensions(skirt):
    pytest.importorskip("xarray")
    data = skirt.to_xarray()
    pressure = data["ehd.pressure"]
    assert pressure.dims == ("instant", "angle", "height")
    assert pressure.attrs["units"] == "Pa"
    assert data.sizes["angle"] == 16 and data.sizes["height"] == 8
    # cell floor(16/4) + 1 = 5 has its centre on the thrust side, 90 deg from the pin axis
    assert float(data["angle"][4]) == 90.0 and data["angle"].attrs["units"] == "deg"
    assert data["height"].values == pytest.approx(-45.5 + (np.arange(8) + 0.5) / 8 * 82.8)  # mm
    assert data["height"].attrs["units"] == "mm"
    # 1 deg at 1680 rpm are 99.2 us; fields at every second one from -360 deg on
    assert np.degrees(data["instant_crank_angle"].values) == pytest.approx(
        [-360, -358, -356, -354, -352]
    )
    assert np.degrees(data["crank_angle"].values) == pytest.approx(np.arange(-360, -351))
    assert np.array_equal(data["time"], skirt.time)
    chosen = pressure.sel(angle=90, instant=data["instant"][1])
    assert np.array_equal(chosen, skirt.field("ehd.pressure", skirt.instants[1]).values[4])


def test_the_file_opens_in_plain_xarray(skirt):
    xarray = pytest.importorskip("xarray")
    pytest.importorskip("h5netcdf")
    scalars = xarray.open_dataset(skirt.path, group="ehd", engine="h5netcdf")
    assert scalars["friction_power"].dims == ("time",)
    where = xarray.open_dataset(skirt.path, group="fields", engine="h5netcdf")
    fields = xarray.open_dataset(skirt.path, group="fields/ehd", engine="h5netcdf")
    fields = fields.assign_coords(where.variables)
    assert fields["pressure"].dims == ("time", "angle", "height")
    assert float(fields["angle"][4]) == 90.0
    assert np.degrees(fields["crank_angle"].values) == pytest.approx([-360, -358, -356, -354, -352])
    skirt.close()


def test_results_as_a_table(oscillator):
    pytest.importorskip("pandas")
    table = oscillator.to_dataframe()
    assert list(table.columns) == oscillator.ports
    assert table.index.to_numpy() == pytest.approx([0, 0.01, 0.02, 0.03])
    assert table.attrs["units"]["left.displacement"] == "m"


def test_a_missing_library_is_told(oscillator, monkeypatch):
    monkeypatch.setitem(sys.modules, "pandas", None)
    with pytest.raises(pc.BadInput, match="pandas: expected it installed, got nothing"):
        to_dataframe(oscillator)


def test_own_participants_take_part(here):
    """x = 1 + f, f = -x/2 every step: x = 2/3, whatever the method."""
    for method in ("newton", "aitken", "iqn_ils"):
        results = _pair(method=method).run("pair.h5")
        assert results.series("one.x").values[1:] == pytest.approx([2 / 3] * 3, abs=1e-6)
        assert results.series("one.x").description == "Answer"


def test_what_is_wrong_with_a_description_is_told(here):
    with pytest.raises(pc.BadInput, match="wires: expected one of one, two, got"):
        _pair(parameters={"three": {}})
    with pytest.raises(pc.BadInput, match=r"wires: expected 'participant\.output ->"):
        _pair(wires=["one.x two.x"])
    with pytest.raises(pc.BadInput, match="unknown input 'two.y'"):
        _pair(wires=["one.x -> two.y"]).run("pair.h5")
    with pytest.raises(pc.BadInput, match="expected FMUs in a sweep"):
        pc.sweep(_pair(), {"coupling.relaxation": [0.5, 0.6]})


def _pair(wires=("one.x -> two.x", "two.f -> one.f"), **given):
    class Linear(pc.Slave):
        name, gain, offset, ends = "linear", 1.0, 1.0, ("f", "x")

        @classmethod
        def variables(cls, options):
            source, target = cls.ends
            return [
                pc.variables.input_variable(source, "1", "Question", 0.0, 1.0),
                pc.variables.output_variable(target, "1", "Answer", 1.0),
            ]

        def start(self, values):
            return self.advance(None, values, 0.0, 0.0)

        def advance(self, state, values, time, step):
            source, target = self.ends
            return state, {target: self.offset + self.gain * values[source]}

    class Back(Linear):
        gain, offset, ends = -0.5, 0.0, ("x", "f")

    given.setdefault("stop", "3 s")
    return pc.couple({"one": Linear, "two": Back}, list(wires), step="1 s", **given)


def test_a_sweep_has_a_row_for_each_combination(here):
    case = pc.open_case("two_mass_oscillator", {"time.stop": "0.02 s"})
    told = []
    key = "participants.left.parameters.start_displacement"
    rows = pc.sweep(
        case, {key: ["1 m", "2 m"]}, "swept", workers=1, progress=lambda *row: told.append(row)
    )
    assert [row[key] for row in rows] == ["1 m", "2 m"]
    assert [row["status"] for row in rows] == ["done", "done"]
    heavy = case.changed({key: "2 m"}).run("heavy.h5")
    assert rows[1]["left_displacement_last_m"] == heavy.summary["left_displacement_last_m"]
    assert [done for _, done, _ in told] == [1, 2]
    with pytest.raises(pc.BadInput, match="coupling.relaxation"):
        pc.sweep(case, {"coupling.relaxation": [0.5, 7.0]})


def test_a_film_tells_every_wrong_parameter():
    with pytest.raises(pc.BadInput) as told:
        pc.Film(viscosty="1 Pa s", bore_radius="3 kg", skirt_length=5.0, cavitation_model="wet")
    assert [fault.split(" ")[0].strip(":") for fault in told.value.faults] == [
        "viscosty",
        "bore_radius",
        "skirt_length",
        "cavitation_model",
    ]
    assert "did you mean 'viscosity'" in told.value.faults[0]
    with pytest.raises(pc.BadInput, match="viscosity_40: expected more than"):
        pc.Film(viscosity_law="two_point", viscosity_40="5 mPa s", viscosity_100="9 mPa s")
    with pytest.raises(pc.BadInput, match="two numbers of cells"):
        pc.Film((4.5, 3))
    with pytest.raises(pc.BadInput, match=r"open_cells: expected shape \(8, 8\), got \(2,\)"):
        pc.Film((8, 8), open_cells=np.zeros(2))


def test_a_film_asks_for_what_it_needs():
    film = pc.Film((8, 4))
    with pytest.raises(pc.BadInput, match="film: expected a call of start before step,"):
        film.step(1e-5, 1e-4, sliding_velocity=0.0)
    with pytest.raises(pc.BadInput, match=r"film_thickness: expected shape \(8, 4\), got \(4, 8\)"):
        film.start(np.full((4, 8), 1e-5), sliding_velocity=0.0)
    film.start(1e-5, sliding_velocity=0.0)
    with pytest.raises(pc.BadInput, match="expected a positive"):
        film.step(1e-5, 0.0, sliding_velocity=0.0)
    with pytest.raises(pc.BadInput, match="expected finite values"):
        film.step(np.nan, 1e-4, sliding_velocity=0.0)
    with pytest.raises(pc.Discard, match=r"1,1.: expected more than 0 m, got -1e-05 m"):
        film.step(-1e-5, 1e-4, sliding_velocity=0.0)


def test_a_film_set_back_repeats_its_step_and_its_tangent_is_the_difference():
    film = pc.Film((8, 16), viscosity="20 mPa s")
    film.start(1e-5, sliding_velocity=2.0)
    before = film.state
    first = film.step(0.9e-5, 1e-4, sliding_velocity=2.0)["nodal_pressure_force"]
    change, _ = film.tangent(1.0)
    film.state = before
    assert np.array_equal(
        film.step(0.9e-5, 1e-4, sliding_velocity=2.0)["nodal_pressure_force"], first
    )
    film.state = before
    size = 1e-10
    moved = film.step(0.9e-5 + size, 1e-4, sliding_velocity=2.0)["nodal_pressure_force"]
    # of first order in 1e-5 of the film, on forces that go with its inverse cube: 1e-4
    assert (moved - first) / size == pytest.approx(change, rel=1e-3)


def test_what_a_film_is_told_at_the_edges_counts():
    film = pc.Film((8, 16))
    film.start(1e-5, sliding_velocity=0.0, pressure_upper_edge=2e5)
    outputs = film.step(1e-5, 1e-4, sliding_velocity=0.0, pressure_upper_edge=2e5)
    # a film of equal thickness: pressure linear along it, in the middle of cell j (j + 1/2)/16
    assert outputs["pressure"][0] == pytest.approx(2e5 * (np.arange(16) + 0.5) / 16, rel=1e-9)


def test_pictures_of_a_run(skirt):
    results = pc.open_results(skirt.path)
    drawn = results.plot()
    assert list(drawn) == [p["file"] for p in results.case["pictures"]]
    lines = results.plot.lines("ehd.minimum_film_thickness")
    assert lines.axes[0].get_xlabel() == "crank angle [rad]"
    assert lines._repr_png_().startswith(b"\x89PNG")  # what a notebook shows
    shown = results.plot.map("ehd.pressure", time="0 s", units={"ehd.pressure": "kPa"})
    assert shown.axes[-1].get_ylabel() == "pressure [kPa]"
    section = results.plot.section("bodies.film_thickness", time="0 s", beside={"again": results})
    assert len(section.axes[0].lines) == 2
    with pytest.raises(pc.BadInput, match="plot: expected one of"):
        results.plot.map("ehd.presure", time="0 s")


def test_a_picture_of_an_instant_that_a_run_does_not_reach_is_omitted_with_a_warning(skirt):
    results = pc.open_results(skirt.path)
    first, *others = results.plot._case.pictures
    late = first.model_copy(update={"time": "100 s"})
    case = results.plot._case.model_copy(update={"pictures": [late, *others]})
    with pytest.warns(UserWarning, match=f"{first.file} is omitted: .* does not reach 100 s"):
        drawn = Plots(results, case)()
    assert list(drawn) == [one.file for one in others]


def test_time_is_the_abscissa_without_a_crank(oscillator):
    assert oscillator.crank_angle is None
    figure = oscillator.plot.lines("left.displacement")
    assert figure.axes[0].get_xlabel() == "time [s]"
    (line,) = figure.axes[0].lines
    assert np.array_equal(line.get_xdata(), oscillator.time)


def test_an_fmu_of_a_case_has_the_options_asked_for(here):
    film = pc.open_fmu(pc.build_fmu("data_sheet", "ehd", options={"grid": [16, 8]}))
    assert film.fields["film_thickness"].shape == (16, 8)
    assert repr(film).startswith("<FMU ") and " at 0x" not in repr(film)
    with pytest.raises(pc.BadInput, match="no such file"):
        pc.open_fmu("film.fmu")


OWN = """import piston_cosim as pc


class Twice(pc.Slave):
    name = "twice"

    @staticmethod
    def variables(options):
        return [
            pc.variables.input_variable("x", "m", "Question"),
            pc.variables.output_variable("y", "m", "Answer"),
        ]

    def start(self, values):
        return self.advance(None, values, 0.0, 0.0)

    def advance(self, state, values, time, step):
        return state, {"y": 2.0 * values["x"]}
"""


def test_a_file_that_imports_the_public_names_becomes_an_fmu(here):
    """Inside the FMU there is no installed package: its own tree answers to the name."""
    (here / "twice.py").write_text(OWN)
    fmu = pc.open_fmu(pc.build_fmu("twice.py:Twice", output="twice.fmu"))
    fmu.start({"x": 1.5}, 0.0, 1.0)
    fmu.step(0.0, 0.1)
    assert fmu.get("y") == 3.0
    fmu.close()
    code = (
        "import sys; sys.modules['piston_cosim'] = None;"  # not to be had
        "from fmpy import simulate_fmu;"
        "print(simulate_fmu('twice.fmu', start_values={'x': 2.0}, stop_time=0.1)['y'][-1])"
    )
    assert script(code).strip() == "4.0"


class Point(NamedTuple):
    x: float


class Law(pc.Slave):
    name, description, state_type = "law", "output of a law", Point

    def variables(self, options):
        law = pc.variables.Variable("law", "1", "parameter", "law", "one", choices=("one", "two"))
        return [law, pc.variables.Variable("y", "1", "output", "its number")]

    def start(self, values):
        return Point(0.0), {"y": 0.0}

    def advance(self, state, values, time, step):
        return state, {"y": {"one": 1.0, "two": 2.0}[values["law"]]}


@pytest.mark.parametrize("law", ["two", 2])
def test_a_choice_of_an_own_model_by_name_and_number(law, tmp_path):
    case = pc.couple({"a": Law}, [], stop="1 s", step="1 s", parameters={"a": {"law": law}})
    assert case.run(tmp_path / "o.h5").series("a.y").values[-1] == 2.0


def test_an_fmu_that_does_not_start_says_why(monkeypatch):
    class Refusing:
        """FMU whose default values are not valid."""

        description = SimpleNamespace(
            defaultExperiment=SimpleNamespace(stopTime="1.0", stepSize="0.1")
        )

        def start(self, *_):
            raise pc.BadInput("radius: expected a positive value, got 0 m")

        def close(self):
            """Do nothing."""

    monkeypatch.setattr(fmus.opening, "open_fmu", lambda name, path: Refusing())
    said: list[str] = []
    fmus.compile_code(Path("film.fmu"), said.append)
    assert said[-1].endswith("default values: radius: expected a positive value, got 0 m")
