"""What is said of a measured profile, and its smooth table beside the true shape."""

from dataclasses import replace

import numpy as np
import pytest

from piston_cosim.fmu_mfbd.geometry.profile import MeasuredShape, barrel, ovality
from piston_cosim.fmu_mfbd.preview import preview
from piston_cosim.fmu_mfbd.profile_judgement import (
    LEAST_DUST,
    LEAST_DUST_OVER_NOISE,
    form_of,
    judge_profile,
    smooth_shape,
)
from piston_cosim.fmu_mfbd.profile_reader import Reading, read_profile
from piston_cosim.master.commands.profile import command
from piston_cosim.master.fmi.errors import BadInput

from .test_preview import CRANK, SHEET

LOWER, UPPER, RADIUS = -25e-3, 20e-3, 43e-3
NOISE = 0.3e-6
"""Standard deviation of a gauge [m]."""


def true_values(angle, height, drop=35e-6, oval=240e-6):
    along = barrel(height, LOWER, UPPER, drop)
    return along[:, None] + ovality(angle, oval)


def measured(**form):
    """Return a table of 20 heights and 24 angles with the noise of a gauge."""
    angle, height = np.arange(24) * (np.pi / 12), np.linspace(LOWER, UPPER, 20)
    noise = np.random.default_rng(1).normal(0.0, NOISE, (20, 24))
    return MeasuredShape(angle, height, true_values(angle, height, **form) + noise)


def grain(shape, row=7, column=5, gap=-25e-6):
    value = shape.value.copy()
    value[row, column] += gap
    return replace(shape, value=value)


SOUND = measured()
EXACT = replace(SOUND, value=true_values(SOUND.angle, SOUND.height))
GROOVED = replace(SOUND, value=SOUND.value + 15e-6 * (np.arange(20) == 9)[:, None])


@pytest.mark.parametrize(
    "shape, kinds, words",
    [
        (SOUND, [], ""),
        (replace(SOUND, height=0.99 * SOUND.height), [], ""),  # all but a hundredth
        (replace(SOUND, height=1e-3 * SOUND.height), ["fault"], "-25 to 20 mm, got -0.025 to 0.02"),
        (replace(SOUND, height=0.9 * SOUND.height), ["warning"], "first and the last row"),
        (replace(SOUND, value=43e-3 - SOUND.value), ["fault"], "got 43 mm; check value_unit"),
        (replace(SOUND, value=-SOUND.value), ["warning"], "m wider ends"),
        (replace(SOUND, value=np.roll(SOUND.value, 6, 1)), ["warning"], "smallest diameter"),
        (replace(SOUND, value=np.roll(SOUND.value, 2, 1)), ["warning"], "got it at 30 deg"),
        (replace(SOUND, value=2 * SOUND.value), ["warning"], "if values are diameters"),
        (replace(SOUND, value=SOUND.value + 1e-3), ["warning"], "below 1e+03"),
        (grain(SOUND), ["warning"], "outside it at 75 deg, -8.421 mm"),
        (grain(SOUND, row=0, column=0), ["warning"], "outside it at 0 deg, -25 mm"),
        (EXACT, ["remark"], "got the same values at opposite angles"),
        (replace(SOUND, value=1e-3 * SOUND.value), ["warning"], "m; check value_unit"),
        (GROOVED, ["remark"], "steps and grooves"),
        (MeasuredShape(np.zeros(1), np.zeros(1), np.zeros((1, 1))), [], ""),
        (MeasuredShape(np.zeros(1), SOUND.height, EXACT.value[:, 6:7]), [], ""),
    ],
)
def test_what_is_said_of_a_profile(shape, kinds, words):
    found = judge_profile(shape, LOWER, UPPER, RADIUS)
    assert [one.kind for one in found] == kinds, found
    assert all(one.text.startswith("expected ") for one in found)
    assert words in " ".join(one.text for one in found)


def test_a_bore_has_no_usual_form():
    assert judge_profile(replace(SOUND, value=-SOUND.value), LOWER, UPPER, None) == []


def test_form_by_hand():
    form = form_of(EXACT, LOWER, UPPER)
    # splines through 24 angles and 20 heights are 1e-4 off a cosine and a parabola
    assert form.barrel == pytest.approx(35e-6, rel=1e-3)
    assert form.ovality == pytest.approx(240e-6, rel=1e-3)
    assert form.turn == pytest.approx(0.0, abs=1e-6)


def test_a_smooth_table_is_nearer_to_the_truth():
    """5 coefficients of 24 angles leave sqrt(5/24) of white noise, before the splines along."""
    smooth = smooth_shape(grain(SOUND))
    error = smooth.shape.value - EXACT.value
    assert np.sqrt(np.mean(error**2)) < np.sqrt(5 / 24) * NOISE
    assert abs(error[7, 5]) < 3 * NOISE
    assert smooth.order == 2
    # the fit takes 5 of 24 degrees of freedom; 480 values know their noise to 3 %
    assert smooth.noise == pytest.approx(np.sqrt(19 / 24) * NOISE, rel=0.1)
    (found,) = smooth.grains
    assert (found.row, found.column) == (7, 5)
    assert found.gap == pytest.approx(-25e-6, abs=5 * NOISE)
    # the table of a designer has no noise, and stays as it is, also with order 4 at 8 angles
    square = EXACT.value + 3e-6 * np.cos(4 * EXACT.angle)
    for table in (
        replace(EXACT, value=square),
        MeasuredShape(EXACT.angle[::3], EXACT.height, square[:, ::3]),
    ):
        assert np.abs(smooth_shape(table).shape.value - table.value).max() < 0.01 * NOISE


def test_noise_is_not_dust():
    """One in 1e12 tables of 480 normal values has one off by `LEAST_DUST_OVER_NOISE` deviations."""
    rough = replace(EXACT, value=EXACT.value + 10 * (SOUND.value - EXACT.value))
    assert LEAST_DUST_OVER_NOISE * 10 * NOISE > LEAST_DUST
    assert smooth_shape(rough).grains == []


def write(shape, path, unit=1e-6):
    rows = [",".join(f"{one:.9g}" for one in [0, *np.degrees(shape.angle)])]
    for height, values in zip(shape.height, shape.value):
        rows.append(",".join(f"{one:.6f}" for one in [1e3 * height, *values / unit]))
    path.write_text("\n".join(rows))
    return path


def test_the_reader_turns_and_smooths(tmp_path, capsys):
    """The table that it writes is read without a message, and is the true shape."""
    turned = replace(grain(SOUND), value=np.roll(grain(SOUND).value, -6, 1))
    command(
        write(turned, tmp_path / "raw.csv"),
        turn="90 deg",
        radius="43 mm",
        smooth=True,
        output=tmp_path / "smooth.csv",
        picture=tmp_path / "profile.png",
    )
    said = capsys.readouterr().out
    assert "removed a value -2" in said and "Fourier orders 0 to 2" in said and "90 deg" in said
    assert (tmp_path / "profile.png").stat().st_size > 20_000
    whole = Reading(lower=LOWER, upper=UPPER, radius=RADIUS)
    picture = tmp_path / "again.svg"
    again = read_profile(tmp_path / "smooth.csv", whole, picture, False, tmp_path / "same.csv")
    assert again.messages == []
    share = next(one.value for one in again.figures if one.name == "covered_share")
    assert share == pytest.approx(1.0, abs=1e-6)
    rows = np.loadtxt(tmp_path / "same.csv", delimiter=",", skiprows=1)
    np.testing.assert_allclose(rows[:, 1:] * 1e-6, EXACT.value, atol=3 * NOISE)


def test_faults_of_the_reader(tmp_path):
    with pytest.raises(BadInput, match=r"--turn: (.|\n)*--radius: "):
        command(tmp_path / "no.csv", turn="3 mm", radius="3 deg")
    few = MeasuredShape(SOUND.angle[::8], SOUND.height[:3], SOUND.value[:3, ::8])
    with pytest.raises(BadInput, match="--smooth: expected 5 heights or 12 angles, got 3 heights"):
        command(write(few, tmp_path / "few.csv"), smooth=True, picture=tmp_path / "few.png")
    with pytest.raises(BadInput, match="--skirt-upper: expected more than 0 mm, the lower"):
        command(tmp_path / "few.csv", skirt_lower="0 mm", skirt_upper="-5 mm")
    row = MeasuredShape(SOUND.angle, SOUND.height[:1], SOUND.value[:1])
    command(write(row, tmp_path / "row.csv"), picture=tmp_path / "row.png")
    short = write(replace(SOUND, height=1e-3 * SOUND.height), tmp_path / "short.csv")
    with pytest.raises(BadInput, match="short.csv: expected heights over -25 to 20 mm"):
        command(short, skirt_lower="-25 mm", skirt_upper="20 mm", picture=tmp_path / "short.pdf")


def test_the_check_of_a_case_judges_its_profiles(tmp_path):
    write(replace(SOUND, height=1e-3 * SOUND.height), tmp_path / "metres.csv")
    write(grain(SOUND), tmp_path / "dust.csv")
    units = {"angle_unit": "1 deg", "height_unit": "1 mm", "value_unit": "1 um"}
    profiles = [{"file": name, **units} for name in ("metres.csv", "dust.csv")]
    seen = preview(SHEET | {"piston": SHEET["piston"] | {"profiles": profiles}}, CRANK, tmp_path)
    assert seen.faults == [
        "build.piston.profiles, metres.csv: expected heights over -25 to 20 mm, got -0.025 to "
        "0.02 mm; check height_unit and the origin of the heights"
    ]
    assert any("dust.csv: expected a smooth surface" in line for line in seen.warnings)
