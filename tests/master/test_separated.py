"""Separated files of spreadsheets of several countries give the same rows."""

import pytest

from piston_cosim.master.fmi.separated import read_rows

WANTED = [(1, ["angle [deg]", "p [bar]"]), (2, ["-360", "0.5"]), (3, ["1e2", "-1.25e-3"])]


@pytest.mark.parametrize(
    "text",
    [
        "angle [deg],p [bar]\n-360,0.5\n1e2,-1.25e-3\n",
        "angle [deg];p [bar]\n-360;0,5\n1e2;-1,25e-3\n",  # decimal commas
        "angle [deg]\tp [bar]\r\n-360\t0,5\r\n1e2\t-1,25e-3\r\n",
        "\N{ZERO WIDTH NO-BREAK SPACE}angle [deg];p [bar]\n-360;0.5\n1e2;-1.25e-3\n\n",
    ],
)
def test_separator_decimal_comma_and_byte_order_mark(text, tmp_path):
    path = tmp_path / "table.csv"
    path.write_bytes(text.encode())
    assert read_rows(path) == WANTED


def test_blanks_and_comments(tmp_path):
    path = tmp_path / "table.txt"
    path.write_text("# angle; pressure\n\n-360   0,5\n1e2  1\n")
    assert read_rows(path) == [(3, ["-360", "0.5"]), (4, ["1e2", "1"])]
