"""Steps of a participant's own, FMUs of one step length, signal tables and a start time.

Eq. (X7):  x_n = x_0 / (1 + h k)^n,  n = time / h               a lag alone, backward Euler
Eq. (X8):  x_{n+1} = (x_n + h u(t_{n+1})) / (1 + h k)           the lag behind a signal
"""

import numpy as np
import pytest

from piston_cosim.master.coupling.stepping import StepFailed

from .c_fmus import pack
from .counter import case_text, description
from .test_any_fmu import refused, solved

H = 0.1
TABLE = "time [ms], force [mm]\n0, 0\n500, 250\n1000, 1000\n1500, 1750\n2000, 4000\n"


@pytest.fixture(autouse=True)
def signal(folder):
    (folder / "signal.csv").write_text(TABLE)


def lag(count, step, k, u, x=1.0):
    """Return the lag behind u(t) at every step."""
    found = [x]
    for n in range(count):
        found.append((found[-1] + step * u((n + 1) * step)) / (1 + step * k))  # Eq. (X8)
    return np.array(found)


@pytest.mark.parametrize("isolated", ["false", "true"])
def test_a_step_of_its_own_divides_the_macro_step(folder, isolated):
    text = case_text([], a="k = 2.0", b="k = 2.0").replace(
        'fmu = "a.fmu"', f'fmu = "a.fmu"\nstep = "26 ms"\nisolated = {isolated}'
    )
    _, results = solved(folder, text)
    n = np.arange(11)
    # four steps of 25 ms, ten divisions to each: 40 roundings
    expected = (1 + H / 4 * 2.0) ** (-4.0 * n)  # Eq. (X7)
    np.testing.assert_allclose(results.series("a.x").values, expected, rtol=1e-14)
    np.testing.assert_allclose(results.series("b.x").values, 1.2**-n, rtol=1e-14)


def test_a_loop_of_two_rates_agrees(folder):
    """a takes two steps to one of b, its input held over both: a linear system for each step."""
    k, h = 2.0, H / 2
    wires = [("a.x", "b.u", ""), ("b.x", "a.u", "tolerance = 1e-13")]
    text = case_text(wires, a=f"k = {k}", b="k = 1.0")
    text = text.replace('fmu = "a.fmu"', f'fmu = "a.fmu"\nstep = "{h} s"')
    _, results = solved(folder, text)
    p = 1 / (1 + h * k)
    a, b = [1.0], [1.0]
    for _ in range(10):
        # a' = p (p (a + h b') + h b'), b' = (b + H a') / (1 + H)
        matrix = [[1, -(p * p + p) * h], [-H / (1 + H), 1]]
        found = np.linalg.solve(matrix, [p * p * a[-1], b[-1] / (1 + H)])
        a.append(found[0])
        b.append(found[1])
    # the tolerance of the wire times ten steps
    np.testing.assert_allclose(results.series("a.x").values, a, rtol=0, atol=1e-11)
    np.testing.assert_allclose(results.series("b.x").values, b, rtol=0, atol=1e-11)


def with_table(kind, interpolation, more="", time=""):
    """Return a case whose table drives the lag a in steps of a fifth of the macro step."""
    return f"""title = "table"
[time]
{time}
step = "{H} s"
[participants.source]
table = "signal.csv"
interpolation = "{kind}"
[participants.a]
fmu = "a.fmu"
{more}
parameters = {{k = 2.0}}
[[wires]]
from = "source.force"
to = "a.u"
interpolation = "{interpolation}"
[coupling]
order = ["source", "a"]
"""


def test_a_linear_table_moves_the_input_inside_the_macro_step(folder):
    text = with_table("linear", "linear", 'step = "20 ms"', 'stop = "2 s"')
    _, results = solved(folder, text)
    t, u = np.array([0, 0.5, 1, 1.5, 2]), np.array([0, 0.25, 1, 1.75, 4])
    fine = lag(100, 0.02, 2.0, lambda time: np.interp(time, t, u))
    # knots of the table lie on macro steps, so that the chord of each is the table's
    np.testing.assert_allclose(results.series("a.x").values, fine[::5], rtol=1e-13)
    np.testing.assert_allclose(
        results.series("source.force").values, np.interp(H * np.arange(21), t, u), rtol=1e-13
    )


def test_a_cubic_table_gives_its_slope(folder):
    """t^2 and t^3 lie in the cubic spline's own space: it is exact between the rows."""
    rows = "".join(f"{t},{t**3 - t * t}\n" for t in np.linspace(0, 2, 9))
    (folder / "signal.csv").write_text(f"time [s],force [m]\n{rows}")
    _, results = solved(folder, with_table("cubic", "hermite", 'step = "20 ms"', 'stop = "2 s"'))
    t = H * np.arange(21)
    force, slope = (results.series(f"source.{name}").values for name in ("force", "der(force)"))
    np.testing.assert_allclose(force, t**3 - t * t, atol=1e-13)
    np.testing.assert_allclose(slope, 3 * t * t - 2 * t, atol=1e-12)
    fine = lag(100, 0.02, 2.0, lambda time: time**3 - time * time)
    np.testing.assert_allclose(results.series("a.x").values, fine[::5], atol=1e-12)


def test_a_held_table_and_a_start_time(folder):
    text = with_table("hold", "held", time='start = "0.5 s"\nstop = "2.5 s"')
    _, results = solved(folder, text)
    np.testing.assert_allclose(results.time, 0.5 + H * np.arange(21), rtol=1e-14)
    force = results.series("source.force").values
    assert force[[0, 4, 5, 9, 10, 14, 15, 20]].tolist() == [0.25, 0.25, 1, 1, 1.75, 1.75, 4, 4]
    (folder / "signal.csv").write_text("time [s] force [m]\n-2 1\n-1 2\n0 3\n")
    _, results = solved(folder, with_table("hold", "held", time='start = "-2 s"\nstop = "0 s"'))
    force = results.series("source.force").values
    assert force[[0, 9, 10, 19, 20]].tolist() == [1, 1, 2, 2, 3]
    expected = [1.0]
    for u in force[1:]:
        expected.append((expected[-1] + H * u) / (1 + 2 * H))  # Eq. (X8)
    np.testing.assert_allclose(results.series("a.x").values, expected, rtol=1e-13)


@pytest.mark.parametrize(
    "table, words",
    [
        ("time [s], force [m]\n0, 1\n1, 2\n", "expected times from 0 s to 2 s, got 0 s to 1 s"),
        ("time [s], force [furl]\n0, 1\n2, 2\n", "column force: expected a known unit, got 'furl'"),
        (
            "time [kg], force [m]\n0, 1\n2, 2\n",
            "expected 'time [s]' as the first column, got 'time [kg]', kg",
        ),
        ("time [s], force [m]\n0, 1\n0, 2\n", "row 3: expected a time after 0, got 0"),
        ("time [s], force [m]\n0, x\n2, 2\n", "row 2: expected 2 finite numbers, got '0,  x'"),
        (
            "time [s], force [m], force\n0, 1, 2\n2, 2, 3\n",
            "expected different names, got 'force' twice",
        ),
        ("time [s]\n0\n2\n", "expected a column after the time"),
        ("time [s], force [m]\n0, 1\n1\n2, 2\n", "row 3: expected 2 finite numbers, got '1'"),
    ],
)
def test_tables_that_cannot_be_used(folder, table, words):
    (folder / "signal.csv").write_text(table)
    assert words in refused(folder, with_table("linear", "held", time='stop = "2 s"'))


def one_length(folder, library):
    """Write the FMU a, which takes steps of one length alone."""
    text = description().replace('StepSize="true"', 'StepSize="false"')
    pack(folder / "a.fmu", text, library)


@pytest.mark.parametrize("step, taken", [("", 1), ('step = "0.05 s"', 2)])
def test_an_fmu_of_one_step_length(folder, library, step, taken):
    one_length(folder, library)
    _, results = solved(folder, case_text([], a="k = 2.0", own=step))
    expected = (1 + 0.2 / taken) ** (-taken * np.arange(11.0))  # Eq. (X7)
    np.testing.assert_allclose(results.series("a.x").values, expected, rtol=1e-14)


def test_an_fmu_of_one_step_length_is_never_given_another(folder, library):
    one_length(folder, library)
    wires = [("a.x", "b.u", "local_error = 1e-3")]
    words = "expected an FMU with variable steps with local_error"
    assert words in refused(folder, case_text(wires))
    with pytest.raises(StepFailed, match="a multiple of 0.03 s"):
        solved(folder, case_text([], own='step = "0.03 s"'))
