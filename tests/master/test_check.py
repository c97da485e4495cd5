"""`check` examines a case before anything is built.

It reports all faults at once, and participants that describe different engines.
"""

import pytest

from piston_cosim.master.case.check import check
from piston_cosim.master.case.reading import case_names
from piston_cosim.master.commands.check import command


@pytest.mark.parametrize("name", case_names())
def test_shipped_cases_are_sound(name):
    assert check(name).faults == []


def test_all_faults_at_once():
    changes = [
        ("ehd.bore_radius", "28 mm"),
        ("ehd.skirt_length", "27.1 mm"),
        ("rod_length", "20 mm"),
        ("participants.ehd.parameters.viscos", "1 Pa s"),
        ("flow_factors", "patir_cheng_1978"),
        ("roughness_rms", "0 um"),
    ]
    found = check("numerical_example", changes)
    text = "\n".join(found.faults)
    assert "viscos: expected one of cavitation_model," in text
    assert "skirt_length: expected 27 mm, the skirt" in text
    assert "rod_length: expected more than crank_radius" in text
    assert "unknown parameter or input 'viscos'; did you mean 'viscosity" in text
    assert "roughness_rms: expected more than 0 m with flow_factors" in text
    assert len(found.faults) == 5
    assert found.previews["ehd"].figure("roughness_rms").value == 0.0


def test_a_default_of_another_engine_is_told(tmp_path):
    from piston_cosim.master.case.reading import find_case

    text = find_case("data_sheet").read_text().replace('bore_radius = "55 mm"\n', "")
    (tmp_path / "case.toml").write_text(text.replace("gas_pressure.csv", "g.csv"))
    (tmp_path / "g.csv").write_text("0,0\n360,1\n720,0\n")
    (fault,) = check(tmp_path).faults
    assert "bore_radius: expected 55 mm, the bore" in fault


@pytest.mark.parametrize(
    "key, value", [("rod_length", "4 m"), ("bore_radius", "2 m"), ("skirt_length", "0.5 mm")]
)
def test_a_parameter_out_of_range_is_the_only_fault(key, value):
    """Not held against the bore, or as its default against the other part, besides."""
    (fault,) = check("data_sheet", [(key, value)]).faults
    assert f"{key}: expected " in fault and f", got {value}" in fault


def test_a_rejected_parameter_has_no_figures_of_its_default():
    found = check("data_sheet", [("crank_radius", "7 bar")])
    assert found.faults and list(found.previews) == ["ehd"] and not found.remarks


def test_the_command(tmp_path, capsys):
    command("data_sheet", picture=tmp_path / "look.png")
    printed = capsys.readouterr().out
    assert printed.splitlines()[-1] == "no faults, 1 remark"
    assert "swept volume 1368.5 cm^3" in printed
    assert (tmp_path / "look.png").exists()


def test_an_oil_by_name_with_a_viscosity_is_a_warning(tmp_path, capsys):
    command("data_sheet", set_=["participants.ehd.build.oil=sae_0w_20"], picture=tmp_path / "l.png")
    printed = capsys.readouterr().out
    assert "viscosity: no effect with viscosity_law = " in printed
    assert printed.splitlines()[-1] == "no faults, 1 warning, 1 remark"
