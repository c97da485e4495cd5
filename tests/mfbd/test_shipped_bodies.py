"""Reduced bodies in `models/bodies`.

They are used for unchanged meshes and options only, and must agree with the result of the
present code.
"""

from dataclasses import fields

import numpy as np
import pytest

from piston_cosim.fmu_mfbd.build import prepare, reduced_bodies
from piston_cosim.fmu_mfbd.reduction import reduce
from piston_cosim.fmu_mfbd.reduction.reduced_body import Anatomy
from piston_cosim.fmu_mfbd.reduction.store import SHIPPED
from piston_cosim.master.api.bodies import build_table
from piston_cosim.master.api.cases import open_case

CASE = open_case("numerical_example")
FOLDER = CASE.path.parent
RENEW = "delete models/bodies and run `python .ci/bodies.py numerical_example`"


def quiet(text):
    pass


def table(label="flexible", **changes):
    return build_table(CASE.variant(label).changed(changes).tree)


@pytest.fixture
def no_reduction(monkeypatch, tmp_path):
    """Set an empty cache and make each reduction raise an exception."""

    def reduced_now(*given):
        raise ValueError("reduced now")

    monkeypatch.setenv("PISTON_COSIM_CACHE", str(tmp_path))
    for name in ("reduce_piston", "reduce_block"):
        monkeypatch.setattr(reduce, name, reduced_now)


@pytest.mark.parametrize("label", CASE.variants)
def test_no_variant_needs_a_reduction(no_reduction, label):
    """The key is made of meshes and options: whoever changes them renews the files."""
    try:
        files = reduced_bodies(table(label), FOLDER, quiet)
        prepare(table(label), FOLDER, quiet)
    except Exception as error:
        pytest.fail(f"{label}: {error}; {RENEW}")
    assert {file.parent for file in files.values()} == {SHIPPED}


def test_changed_options_and_mode_shapes_need_a_reduction(no_reduction, tmp_path):
    key = "participants.bodies.build.{}".format
    changes = [
        {key("piston.modes"): 79},
        {key("block.young"): "73 GPa"},
        {key("piston.basis"): "pressure_modes"},
        {key("grid"): [36, 40]},
    ]
    for change in changes:
        with pytest.raises(Exception, match="reduced now"):
            reduced_bodies(table(**change), FOLDER, quiet)
    with pytest.raises(Exception, match=r"piston.reduced now\nblock.reduced now"):
        reduced_bodies(table(), FOLDER, quiet, shapes=True)
    other = tmp_path / "piston.msh.xz"
    other.write_bytes((FOLDER / "block.msh.xz").read_bytes())
    with pytest.raises(Exception, match="piston.reduced now"):
        reduced_bodies(table(**{key("piston.mesh"): str(other)}), FOLDER, quiet)


@pytest.mark.parametrize("label", CASE.variants)
def test_shipped_bodies_are_those_of_the_present_code(label):
    """The arrays of every shipped body agree with those of a new reduction.

    Round-off of another solver or processor changes modes by 1e-12 of the largest value. Shapes
    left out by the modes are rounded to 18 bits and have no unique sign, so their product is
    compared.
    """
    with_modes = table(label)
    shipped = reduced_bodies(with_modes, FOLDER, quiet)
    for name, path in reduced_bodies(with_modes, FOLDER, quiet, shapes=True).items():
        with np.load(path) as reduced, np.load(shipped[name]) as file:
            left_out = {one.name for one in fields(Anatomy)}
            assert set(file.files) == set(reduced.files) - left_out
            for key in set(file.files) - {"seconds", "peak_memory"}:
                got, wanted = file[key], reduced[key]
                tolerance = 1e-9
                if key.startswith("left_"):
                    got, wanted = got @ got.T, wanted @ wanted.T
                    tolerance = 1e-5
                np.testing.assert_allclose(
                    got,
                    wanted,
                    rtol=0,
                    atol=tolerance * np.abs(wanted).max(initial=0.0),
                    err_msg=f"{name} {key}: {RENEW}",
                )
