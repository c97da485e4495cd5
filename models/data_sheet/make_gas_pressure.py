"""Gas pressure of the data-sheet engine, which its paper does not tabulate: gas_pressure.csv.

It has polytropes with a Wiebe heat release, Eq. (D12) of `piston-cosim new`. Pressure is gauge, and
0 deg is firing top dead centre. Our own choice, which imitates no measured curve.

python -m piston_cosim.models.data_sheet.make_gas_pressure
"""

from pathlib import Path

import numpy as np

from piston_cosim.master.engine.new import PETROL, engine, gas_table

GAIN = 1.9  # factor of combustion on the polytrope [-]

if __name__ == "__main__":
    sizes = {"bore": "110 mm", "stroke": "144 mm", "rod": "223 mm", "compression": 16.0}
    made = engine(sizes | {"intake_pressure": "1 bar"})
    degrees = np.arange(-360.0, 361.0, 2.0)
    text = gas_table(degrees, made.pressure(degrees, GAIN, PETROL))
    (Path(__file__).parent / "gas_pressure.csv").write_text(text)
