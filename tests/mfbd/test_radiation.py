"""Sound radiation of a block.

Tests cover normal motion over its sides against closed forms, and power by Parseval's theorem, by
the example of fired_motorcycle.
"""

import subprocess
import sys
from types import SimpleNamespace

import numpy as np
import pytest

from piston_cosim.fmu_mfbd.finite_elements.faces import normal_products
from piston_cosim.fmu_mfbd.finite_elements.mesh import outer_faces
from piston_cosim.master.fmi.errors import BadInput
from piston_cosim.models.fired_motorcycle import noise
from piston_cosim.models.fired_motorcycle.noise import AIR, level, radiation, spectrum
from piston_cosim.tests.verification.cases.bodies import box_mesh

from .conftest import tube

SIZE = np.array([0.1, 0.2, 0.3])


@pytest.fixture(scope="module")
def box():
    """Off the axis by its own half: a corner at the origin."""
    points, tets = box_mesh((2, 3, 2), SIZE)
    return points, outer_faces(tets)


def test_a_stretched_box_by_hand(box):
    """phi_1 = (x, 0, 0), phi_2 = (1, 0, z): R over all faces."""
    points, faces = box
    shapes = np.zeros((len(points), 3, 2))
    shapes[:, 0, 0] = points[:, 0]
    shapes[:, 0, 1] = 1.0
    shapes[:, 2, 1] = points[:, 2]
    a, b, c = SIZE
    # phi_1 moves the face x = a alone; phi_2 both faces of x by 1, that of z = c by c
    exact = [[a**2 * b * c, a * b * c], [a * b * c, 2 * b * c + c**2 * a * b]]
    assert normal_products(points, faces, shapes) == pytest.approx(np.array(exact), rel=1e-12)


def test_sides_of_a_block_without_its_bore():
    """A tube that breathes: radially by 1, and along by 1; its bore moves too and does not count.

    The outer wall of 2 pi r L is shared by four sides, each a quarter of a turn.
    """
    inner, outer, length = 0.03, 0.05, 0.1
    points, tets = tube((48, 2, 6), 0.02, 0.02 + length, inner, outer)
    away = np.hypot(points[:, 0], points[:, 2])
    shapes = np.zeros((len(points), 3, 2))
    shapes[:, 0, 0] = points[:, 0] / away
    shapes[:, 2, 0] = points[:, 2] / away
    shapes[:, 1, 1] = 1.0
    anatomy = SimpleNamespace(points=points, skin=outer_faces(tets), shapes=shapes)
    found = radiation(SimpleNamespace(radius=inner), anatomy)
    assert set(found) == {"+x", "-x", "+y", "-y", "+z", "-z"}
    quarter = 0.5 * np.pi * outer * length
    # 48 faces around with curved edges miss the circle by less than 1e-5
    for side in ("+x", "-x", "+z", "-z"):
        assert found[side][0, 0] == pytest.approx(quarter, rel=1e-3)
    ring = np.pi * (outer**2 - inner**2)
    for side in ("+y", "-y"):
        assert found[side][1, 1] == pytest.approx(ring, rel=1e-3)
        assert abs(found[side][0, 0]) < 1e-12 * ring
    total = sum(found.values())
    assert total[0, 0] == pytest.approx(2 * np.pi * outer * length, rel=1e-3)


def recorded(velocity, angle, speed=100.0, extra=1):
    """Stands in for a run's file: `extra` coordinates of the piston, then the block's."""
    time = angle / speed
    whole = np.hstack([np.full((len(angle), extra), 1e3), velocity])
    series = SimpleNamespace(values=angle)
    period = 4.0 * np.pi / speed
    last = time >= time[-1] - period * (1 + 1e-9)
    return SimpleNamespace(
        path="run.h5",
        case={"participants": {"bodies": {"role": "bodies"}}},
        ports=["bodies.crank_angle"],
        recorded=["bodies.modal_velocity"],
        time=time,
        series=lambda port: series,
        last=SimpleNamespace(period=period, instants=time[last], dataset=lambda port: whole[last]),
    )


def harmonic(n, cycles=1, offset=0.3):
    """Two modes at the 3rd and 5th order of a cycle of 720 deg, the second with a constant part."""
    angle = offset + np.linspace(0.0, cycles * 4.0 * np.pi, n + 1)
    turn = 0.5 * (angle - offset)
    velocity = np.column_stack([2e-3 * np.sin(3.0 * turn), 1e-3 + 3e-3 * np.cos(5.0 * turn)])
    return velocity, angle


def test_power_of_two_harmonics():
    """P = rho c (R11 a^2/2 + R22 (c^2 + b^2/2)), in their lines, of odd and even numbers."""
    sides = {"+x": np.array([[0.02, 0.005], [0.005, 0.03]]), "-z": np.diag([0.0, 0.01])}
    for n, cycles in ((180, 1), (91, 1), (360, 2)):
        found = spectrum(recorded(*harmonic(n, cycles)), "bodies", sides)
        power, mean = sum(found.power.values()), sum(found.mean.values())
        assert len(power) == n // cycles
        first = AIR * 0.02 * (2e-3) ** 2 / 2
        second = AIR * 0.04 * (3e-3) ** 2 / 2
        constant = AIR * 0.04 * 1e-6
        # 720 deg at 100 rad/s
        assert found.frequency[3] == pytest.approx(3 * 100.0 / (4 * np.pi), rel=1e-9)
        assert mean[[0, 3, 5]] == pytest.approx([constant, first, second], rel=1e-9)
        assert power.mean() == pytest.approx(first + second + constant, rel=1e-9)
        assert mean.sum() == pytest.approx(power.mean(), rel=1e-12)
    assert level(1e-3) == pytest.approx(90.0)


def test_uneven_instants_are_made_even():
    """Halved steps in between: the lines stand, on a spline, as if they had not been."""
    sides = {"+x": np.diag([0.02, 0.03])}
    velocity, angle = harmonic(360)
    kept = np.r_[0:100:2, 100:140, 140:361:2]
    found = spectrum(recorded(velocity[kept], angle[kept]), "bodies", sides).power["+x"]
    even = spectrum(recorded(velocity[::2], angle[::2]), "bodies", sides).power["+x"]
    # five waves over 180 points: a spline's fourth order is 1e-4 of them
    assert found == pytest.approx(even, abs=1e-3 * even.max())


@pytest.mark.parametrize(
    "spoil, words",
    [
        (
            lambda run: run.recorded.clear(),
            r"angle and bodies\.modal_velocity, got",
        ),
        (lambda run: run.ports.clear(), "h5: expected a crank angle and"),
        (
            lambda run: run.last.instants.__setitem__(slice(1, 170), run.time[0] + 1e-6),
            "h5: expected 8 even instants in a period, got",
        ),
    ],
)
def test_what_cannot_be_told_is_refused(spoil, words):
    run = recorded(*harmonic(180))
    spoil(run)
    with pytest.raises(BadInput, match=words):
        spectrum(run, "bodies", {"+x": np.eye(2)})


def test_less_than_a_period_is_refused():
    velocity, angle = harmonic(180)
    with pytest.raises(BadInput, match="h5: expected a period with recorded ends, got"):
        spectrum(recorded(velocity[:40], angle[:40]), "bodies", {"+x": np.eye(2)})


def test_the_example_prints_the_sides_of_a_reduced_block(
    coarse, kept, tmp_path, monkeypatch, capsys
):
    """The bolted end of the block moves nothing, so its side is at the floor of the levels."""
    folder, table = coarse
    run = recorded(*harmonic(180), extra=20)  # 12 modes of the piston, 10 of the block
    run.path = tmp_path / "run.h5"
    tables = {"bodies": table}
    monkeypatch.setattr(noise, "bodies_of", lambda file: (run, tables))
    monkeypatch.setattr(noise, "case_folder", lambda results, case: folder)
    noise.main(run.path)
    rows = [line.split() for line in capsys.readouterr().out.splitlines() if " dB " in line]
    levels = {
        " ".join(row[1 : row.index("dB") - 1]): float(row[row.index("dB") - 1]) for row in rows
    }
    assert set(levels) == {"+x", "-x", "+y", "-y", "+z", "-z", "all sides"}
    assert levels["-y"] == -300.0 and levels["all sides"] > max(levels["+x"], levels["+z"])
    assert (tmp_path / "run-bodies-noise.png").stat().st_size > 1e4


def test_the_example_ends_with_code_2_for_a_file_that_is_missing(tmp_path):
    words = [sys.executable, "-m", noise.__name__, str(tmp_path / "run.h5")]
    done = subprocess.run(words, capture_output=True, text=True)
    assert done.returncode == 2 and "run.h5" in done.stderr and "Traceback" not in done.stderr
