"""Build the three FMUs and engine.ssp in a folder, with changes of the piston's case.

python make.py FOLDER [KEY=VALUE ...]
"""

import sys
from pathlib import Path

from piston_cosim.master.case.checked import check_case
from piston_cosim.master.case.export import export_fmu
from piston_cosim.master.case.reading import find_case, read_tree
from piston_cosim.master.case.ssp import export_ssp
from piston_cosim.master.case.system import open_system
from piston_cosim.master.commands.common import parse_change
from piston_cosim.master.fmi.builder import build_fmu_of_file

HERE = Path(__file__).parent


def make(folder, changes=()):
    """Build the FMUs; return the path of the SSP."""
    folder.mkdir(parents=True, exist_ok=True)
    piston = find_case("numerical_example")
    case = check_case(read_tree(piston, changes), piston)
    parts = {
        "piston": export_fmu(case, piston.parent, print),
        "gas_pressure": build_fmu_of_file(f"{HERE}/gas_pressure.py:GasPressure", {}),
        "crankshaft": build_fmu_of_file(f"{HERE}/crankshaft.py:Crankshaft", {}),
    }
    for name, fmu in parts.items():
        (folder / f"{name}.fmu").write_bytes(fmu.read_bytes())
    tree = read_tree(HERE / "system.toml")
    export_ssp(
        tree,
        open_system(check_case(tree, HERE / "system.toml"), folder, print),
        folder / "engine.ssp",
    )
    return folder / "engine.ssp"


if __name__ == "__main__":
    print(make(Path(sys.argv[1]), [parse_change(text) for text in sys.argv[2:]]))
