"""Study of piston slap: its regression, its gas pressure and its measures."""

import numpy as np
import pytest

from piston_cosim.models.measured.piston_slap import study


def test_effects_are_those_of_the_noise():
    """A factor of 3 dB a deviation has an effect of 3 dB; the others have none beyond doubt."""
    designs, published = study.designs_of(None)
    assert published is None and designs.shape == (study.COUNT, len(study.FACTORS))
    z = (designs - designs.mean(axis=0)) / designs.std(axis=0)
    scatter = np.random.default_rng(1).normal(0.0, 0.5, len(z))
    noise = 50.0 + 3.0 * z[:, study.CLEARANCE] - z[:, study.CLEARANCE] * z[:, study.OFFSET]
    found = study.effects(designs, noise + scatter)
    # scatter over the root of the number of designs is a standard error, 0.05 dB
    assert found["clearance_um"].slope == pytest.approx(3.0, abs=0.2)
    assert found[study.PRODUCT].slope == pytest.approx(-1.0, abs=0.2)
    assert found["clearance_um"].error == pytest.approx(0.05, rel=0.2)
    others = set(found) - {"clearance_um", study.PRODUCT}
    assert all(abs(found[name].t) < 4.0 for name in others)


@pytest.mark.parametrize("location", study.FACTORS["peak_pressure_location_deg"])
def test_the_gas_pressure_peaks_where_it_is_asked_to(location):
    lines = study.gas_table(location).splitlines()[1:]
    angle, pressure = np.array([[float(text) for text in line.split(",")] for line in lines]).T
    assert angle[pressure.argmax()] == pytest.approx(location, abs=0.25)  # half a row


@pytest.mark.slow
def test_a_loose_piston_slaps_more(tmp_path):
    """0.94 dB a deviation of 20 um in the published study; 60 um here."""
    middle = [np.mean(ends) for ends in study.FACTORS.values()]
    designs = np.array([middle, middle])
    designs[:, study.CLEARANCE] = [20.0, 80.0]
    for noise in study.measured(study.run_designs(designs, tmp_path, 1), tmp_path).values():
        assert noise[1] - noise[0] > 2.0
