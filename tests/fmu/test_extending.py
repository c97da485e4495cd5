"""The changes that CONTRIBUTING describes need the files that it names, for Python and native FMUs.

Each is made in a copy of the package, which a new process runs.
"""

import json
import os
import re
import shutil
import subprocess
import sys

import numpy as np
import pytest

from ..command import script
from .test_installed import FILES, PARTS, ROOT

VISCOSITY_LAW = {
    "fmu_ehd/laws/oil.py": [
        ('"walther_1931", "two_point")', '"walther_1931", "two_point", "reynolds_1886")'),
        (
            "    return x.viscosity + 0.0 * temperature\n",
            "    if kind == VISCOSITY_LAWS.reynolds_1886:\n"
            "        return x.viscosity * np.exp(-0.03 * (temperature - ZERO_CELSIUS))\n"
            "    return x.viscosity + 0.0 * temperature\n",
        ),
    ]
}
CAVITATION_MODEL = {
    "fmu_ehd/laws/cavitation.py": [
        (
            '    "full_film": Cavitation(False, False, False),\n',
            '    "full_film": Cavitation(False, False, False),\n'
            '    "clipped": Cavitation(False, True, True),\n',
        )
    ]
}
OUTPUT = {
    "fmu_ehd/state.py": [
        (
            "    stored_energy: Annotated[",
            '    twice_the_power: Annotated[float, "W", 100.0]\n    "Twice the friction power."\n'
            "    stored_energy: Annotated[",
        )
    ],
    "fmu_ehd/step.py": [
        (
            "        stored_energy=",
            "        twice_the_power=2.0 * acting.powers.friction,\n        stored_energy=",
        )
    ],
}
COUPLING_METHOD = {
    "master/coupling/methods/__init__.py": [
        ('"constant", "explicit")', '"constant", "explicit", "picard")'),
        ("from .quasi_newton", "from .picard import Picard\nfrom .quasi_newton"),
        (
            '    if coupling.method == "explicit":\n',
            '    if coupling.method == "picard":\n        return Picard()\n'
            '    if coupling.method == "explicit":\n',
        ),
    ]
}
PICARD = '''
import numpy as np
from .solution import Solution


class Picard:
    """Fixed-point iteration without relaxation."""

    def memory(self):
        return None

    def solve(self, macro_step, guess, memory=None):
        at = macro_step.evaluate(guess)
        history = [macro_step.interface.measure(at.residual, at.outputs)]
        while history[-1] > 1.0:
            at = macro_step.evaluate(np.where(macro_step.interface.feedback, at.outputs, at.used))
            history.append(macro_step.interface.measure(at.residual, at.outputs))
        return Solution(at.used, tuple(history), len(history) - 1, 0)
'''
COMMAND_OPTION = {
    "master/commands/list.py": [
        ("def command():\n", "def command(titles: bool = True):\n"),
        (
            '    Example: piston-cosim list\n    """\n',
            "    Example: piston-cosim list\n\n"
            "    Parameters\n    ----------\n    titles : bool\n        Show the titles.\n"
            '    """\n',
        ),
        ('tree.get("title", "")', 'tree.get("title", "") if titles else ""'),
    ]
}

SPRING = re.search(r"(?ms)^```python\n(.*?)^```$", (ROOT / "CONTRIBUTING.md").read_text())[1]
"""Force element between two bodies, as CONTRIBUTING has it."""
MAGNET = '''
"""Magnet on the thrust side that pulls the piston in one half of the revolution."""

from dataclasses import dataclass

import numpy as np

from ...master.fmi.compiled import compilable
from .element import ForceElement, PointForce, PointMotion, declared


@dataclass(frozen=True)
class MagnetParameters:
    magnet_force: float = declared("N", 0.0, -1e4, 1e4)
    "Force of the magnet; 0: no magnet."
    magnet_reach: float = declared("m", 1e-3, 1e-4, 1.0)
    "Distance of the magnet."


@compilable
def magnet_force(p: MagnetParameters, at: PointMotion) -> PointForce:
    share = p.magnet_reach / (p.magnet_reach - at.x)
    strength = p.magnet_force * (1 + np.cos(at.crank_angle)) / 2
    return PointForce(strength * share**2 - 0.5 * at.vx, 0.0, 0.0)


@compilable
def magnet_change(p: MagnetParameters, at: PointMotion, by: PointMotion) -> PointForce:
    share = p.magnet_reach / (p.magnet_reach - at.x)
    strength = p.magnet_force * (1 + np.cos(at.crank_angle)) / 2
    change = 2 * strength * share**3 / p.magnet_reach * by.x - 0.5 * by.vx
    return PointForce(change, 0.0, 0.0)


MAGNET = ForceElement(MagnetParameters, magnet_force, magnet_change)
'''
BUSHINGS = '''
"""Joints of a floating pin: bushings instead of films in piston and rod."""

from dataclasses import dataclass

from ...master.fmi.compiled import compilable
from .element import ForceElement, PointForce, PointMotion, declared


@dataclass(frozen=True)
class BushingParameters:
    bushing_stiffness: float = declared("N/m", 0.0, 0.0, 1e9)
    "Stiffness of the bushings."
    bushing_damping: float = declared("N.s/m", 0.0, 0.0, 1e6)
    "Damping of the bushings."


@compilable
def bushing_force(p: BushingParameters, at: PointMotion) -> PointForce:
    k, d = p.bushing_stiffness, p.bushing_damping
    moment = -1e-4 * (k * at.angle + d * at.spin)
    return PointForce(-k * at.x - d * at.vx, -k * at.y - d * at.vy, moment)


@compilable
def bushing_change(p: BushingParameters, at: PointMotion, by: PointMotion) -> PointForce:
    return bushing_force(p, by)


BOSSES, EYE = (
    ForceElement(BushingParameters, bushing_force, bushing_change, acts="pin", reacts=body)
    for body in ("piston", "rod")
)
'''
SLIDER = '''
"""Small end that slides along the rod, on a spring with damper."""

from dataclasses import dataclass

from ...master.fmi.compiled import compilable
from .element import ForceElement, PointForce, PointMotion, declared


@dataclass(frozen=True)
class SliderParameters:
    slider_stiffness: float = declared("N/m", 0.0, 0.0, 1e9)
    "Stiffness of the slider of the small end."
    slider_damping: float = declared("N.s/m", 0.0, 0.0, 1e6)
    "Damping of the slider of the small end."


@compilable
def slider_force(p: SliderParameters, at: PointMotion) -> PointForce:
    return PointForce(0.0, -p.slider_stiffness * at.y - p.slider_damping * at.vy, 0.0)


@compilable
def slider_change(p: SliderParameters, at: PointMotion, by: PointMotion) -> PointForce:
    return slider_force(p, by)


SLIDER = ForceElement(
    SliderParameters, slider_force, slider_change, reacts="rod", frees={"rod_stretch": (0.0, 1.0)}
)
'''
FORCE_ELEMENTS = {
    "fmu_mfbd/force_elements/__init__.py": [
        (
            "import LAND_CONTACT\n",
            "import LAND_CONTACT\n"
            "from .bushings import BOSSES, EYE\n"
            "from .magnet import MAGNET\n"
            "from .slider import SLIDER\n"
            "from .torsion_spring import TORSION_SPRING\n",
        ),
        ("(LAND_CONTACT,)", "(LAND_CONTACT, MAGNET, SLIDER, TORSION_SPRING, BOSSES, EYE)"),
    ]
}

FILM = """
import json, sys
import numpy as np
from pathlib import Path
from piston_cosim.master.fmi.builder import build_fmu
from piston_cosim.master.fmi.builder_native import build_native_fmu
from piston_cosim.master.fmi.compiler import this_platform
from piston_cosim.master.participants.fmi2 import FmuParticipant

folder = Path(sys.argv[1])
here = [this_platform()]
files = {
    "python": build_fmu("fmu_ehd", {"grid": [12, 10]}, folder, print),
    "native": build_native_fmu("fmu_ehd", {"grid": [12, 10]}, folder, print, platforms=here),
}
angle = 2 * np.pi * (np.arange(12) + 0.5) / 12
rise = (np.arange(10) - 4.5) / 10
film = 2e-5 * (1 + 0.5 * np.cos(angle)[:, None]) * (1 + 0.4 * rise)
runs = json.loads(sys.argv[2])
found = {}
for kind, path in files.items():
    for name, given in runs.items():
        one = FmuParticipant("film", path)
        chosen = {
            key: one.fields[key].choices[value] if isinstance(value, str) else value
            for key, value in given.items()
        }
        one.start(chosen | {"film_thickness": film, "sliding_velocity": film * 0 + 5.0}, 0.0, 1.0)
        one.step(0.0, 1e-4)
        found[f"{kind} {name}"] = {
            key: np.asarray(one.get(key)).tolist()
            for key in ("pressure", "friction_power", "twice_the_power")
        }
        one.close()
print("FOUND", json.dumps(found))
"""

BODIES = """
import json, sys
import numpy as np
from pathlib import Path
from piston_cosim.master.fmi.builder import build_fmu
from piston_cosim.master.fmi.builder_native import build_native_fmu
from piston_cosim.master.fmi.compiler import this_platform
from piston_cosim.master.participants.fmi2 import FmuParticipant

folder, given, kind = Path(sys.argv[1]), json.loads(sys.argv[2]), sys.argv[3]
rigid = {"mass": "1.39 kg", "centre": ["0 mm", "26.5 mm"], "inertia": "0.003 kg*m^2"}
build = {
    "grid": [8, 6],
    "piston": {
        "rigid": rigid | {"radius": "54.95 mm"},
        "skirt_lower": "-45.5 mm",
        "skirt_upper": "37.3 mm",
        "pin_offset": "0 mm",
    },
    "block": {"rigid": {"radius": "55 mm"}, "bore_lower": "90 mm", "bore_upper": "360 mm"},
}
pin = {"grid": [12, 4], "boss_length": "25 mm", "small_end_length": "36 mm"}
joints = {"tied": {}, "floating": {"floating_pin": pin}, "sliding": {"slides": ["rod_stretch"]}}
outputs = {}
for joint, runs in given.items():
    own = build | joints[joint]
    if kind == "native":
        path = build_native_fmu("fmu_mfbd", own, folder, print, platforms=[this_platform()])
    else:
        path = build_fmu("fmu_mfbd", own, folder, print)
    for name, (values, steps) in runs.items():
        bodies = FmuParticipant("bodies", path)
        bodies.start(values, 0.0, 1.0)
        rows = []
        for k in range(steps):
            bodies.step(k * 1e-4, 1e-4)
            scalars = [one for one, v in bodies.fields.items() if not v.shape and "_" in one]
            rows.append({one: float(np.ravel(bodies.get(one))[0]) for one in scalars})
        outputs[name] = {one: [row[one] for row in rows] for one in rows[0]}
        bodies.close()
print("FOUND", json.dumps(outputs))
"""


def changed(folder, *changes):
    """Copy the package into a folder and make changes; return the environment that runs it."""
    package = folder / "piston_cosim"
    package.mkdir()
    without = shutil.ignore_patterns("__pycache__", "*.so", "build")
    for name in FILES:
        shutil.copy(ROOT / name, package)
    for name in PARTS:
        shutil.copytree(ROOT / name, package / name, ignore=without)
    for change in changes:
        for name, edits in change.items():
            text = (package / name).read_text()
            for old, new in edits:
                assert text.count(old) == 1, f"{name}: {old!r} stands there {text.count(old)} times"
                text = text.replace(old, new)
            (package / name).write_text(text)
    return os.environ | {"PYTHONPATH": str(folder)}


@pytest.mark.slow
def test_law_cavitation_model_and_output_in_both_films(tmp_path):
    environment = changed(tmp_path, VISCOSITY_LAW, CAVITATION_MODEL, OUTPUT)
    hot = {"oil_temperature_lower_edge": 313.15, "oil_temperature_upper_edge": 313.15}
    runs = {
        "law": hot | {"viscosity_law": "reynolds_1886", "viscosity": 0.1},
        "constant": hot | {"viscosity_law": "constant", "viscosity": 0.1 * np.exp(-0.03 * 40.0)},
        "clipped": {"cavitation_model": "clipped"},
        "reynolds": {"cavitation_model": "reynolds"},
    }
    told = script(FILM, tmp_path, json.dumps(runs), env=environment)
    found = json.loads(told.partition("FOUND ")[2])
    for kind in ("python", "native"):
        law, constant = found[f"{kind} law"], found[f"{kind} constant"]
        # one exp of the C library or of numpy, another one of the test: round-off of 1e-15 each
        np.testing.assert_allclose(law["pressure"], constant["pressure"], rtol=1e-12)
        assert np.max(law["pressure"]) > 1e3
        assert found[f"{kind} clipped"]["pressure"] == found[f"{kind} reynolds"]["pressure"]
        assert law["twice_the_power"] == 2.0 * law["friction_power"] != 0.0


def test_coupling_method_and_command_option(tmp_path):
    environment = changed(tmp_path, COUPLING_METHOD, COMMAND_OPTION)
    (tmp_path / "piston_cosim/master/coupling/methods/picard.py").write_text(PICARD)
    summary = tmp_path / "summary.json"
    run = ["run", "two_mass_oscillator", "--set", "time.stop=0.05 s", "--no-plots"]
    run += ["--set", "coupling.method=picard", "--set", "coupling.predictor=0"]
    commands = [[*run, "--summary-json", str(summary)], ["list", "--no-titles"]]
    for command in commands:
        whole = [sys.executable, "-m", "piston_cosim", *command]
        done = subprocess.run(whole, env=environment, cwd=tmp_path, capture_output=True, text=True)
        assert done.returncode == 0, done.stdout + done.stderr
    assert "two_mass_oscillator" in done.stdout
    assert "order of" not in done.stdout  # of its title
    assert json.loads(summary.read_text())["mean_iterations"] > 1.0


ENGINE = {
    "crank_radius": 0.072,
    "rod_length": 0.223,
    "rod_mass": 1.7,
    "rod_inertia": 0.017,
    "rod_centre": 0.072,
    "pin_mass": 0.5,
    "crank_speed": 0.0,
}
STILL = {
    "magnet": {
        "magnet_force": 50.0,
        "magnet_reach": 1e-3,
        "start_crank_angle": 1.0,
        "start_lateral_displacement": 20e-6,
        "ring_side_force": -50.0 * (1 + np.cos(1.0)) / 2 / 0.98**2,
    },
    "spring": {
        "spring_stiffness": 2e3,
        "start_rocking_angle": 1e-3,
        "ring_moment": 2.0,
        "ring_side_force": 2.0 / ENGINE["rod_length"],
    },
}
"""Equilibria: the rings balance the magnet, or the spring, whose reaction on the rod pushes A."""
MOVING = {
    "magnet_force": 50.0,
    "spring_stiffness": 2e3,
    "spring_damping": 0.5,
    "crank_speed": 100.0,
    "start_rocking_angle": 1e-3,
}
STRETCHED = {"slider_stiffness": 1e6, "slider_damping": 2e3, "gas_pressure": 1e4}
STRETCHING = {"slider_stiffness": 1e6, "gas_pressure": 1e6, "crank_speed": 100.0}
STRETCHING |= {"start_crank_angle": 0.9, "pin_friction_coefficient": 0.0}
BUSHED = {"bushing_stiffness": 1e7, "bushing_damping": 5e3, "gas_pressure": 1e4}


@pytest.mark.parametrize("kind", ["python", pytest.param("native", marks=pytest.mark.slow)])
def test_load_of_a_body_force_between_two_and_joints(kind, tmp_path):
    """Each is one file and its entries: magnet, torsion spring, bushings of the pin, and a slider.

    At rest they balance given forces. In motion the power of the magnet is its force times its
    velocity. Python runs without compilation.
    """
    environment = changed(tmp_path, FORCE_ELEMENTS)
    texts = {"magnet": MAGNET, "torsion_spring": SPRING, "bushings": BUSHINGS, "slider": SLIDER}
    for name, text in texts.items():
        (tmp_path / f"piston_cosim/fmu_mfbd/force_elements/{name}.py").write_text(text)
    resting = {name: ENGINE | one for name, one in STILL.items()}
    alone = {f"{name} alone": one | {"ring_side_force": 0.0} for name, one in resting.items()}
    moving = ENGINE | MOVING
    turning = {"moving": moving, "pulled": moving | {"spring_stiffness": 0.0}}
    runs = {
        "tied": {name: (one, 4) for name, one in (resting | alone | turning).items()},
        "floating": {"bushings": (ENGINE | BUSHED, 300)},
        "sliding": {"upright": (ENGINE | STRETCHED, 300), "stretching": (ENGINE | STRETCHING, 30)},
    }
    interpreted = {"NUMBA_DISABLE_JIT": "1"} if kind == "python" else {}
    printed = script(BODIES, tmp_path, json.dumps(runs), kind, env=environment | interpreted)
    outputs = json.loads(printed.split("FOUND ")[1])
    for name, one in STILL.items():
        for key in ("lateral_displacement", "rocking_angle"):
            # positions of 0.3 m leave 1e-16 m of a displacement
            start = one.get(f"start_{key}", 0.0)
            np.testing.assert_allclose(outputs[name][key], start, rtol=1e-9, atol=1e-14)
        rates, free = (
            np.array([of_run["lateral_velocity"], of_run["rocking_velocity"]])
            for of_run in (outputs[name], outputs[f"{name} alone"])
        )
        assert np.abs(rates).max() < 1e-9 * np.abs(free).max()
    x, v, angle, power = (
        np.array(outputs["pulled"][key])
        for key in ("lateral_displacement", "lateral_velocity", "crank_angle", "element_power")
    )
    force = 25.0 * (1 + np.cos(angle)) * (1e-3 / (1e-3 - x)) ** 2 - 0.5 * v
    np.testing.assert_allclose(power, force * v, rtol=1e-9)
    assert np.all(np.abs(power) > 1e-6)
    tilts = (outputs[name]["rocking_velocity"] for name in ("moving", "pulled"))
    assert np.abs(np.subtract(*tilts)).max() > 1e-3
    gas = BUSHED["gas_pressure"] * np.pi * 0.055**2
    at_end = {key: value[-1] for key, value in outputs["bushings"].items()}
    for key, wanted in (
        ("pin_displacement_y", gas / BUSHED["bushing_stiffness"]),
        ("small_end_displacement_y", -gas / BUSHED["bushing_stiffness"]),
        ("pin_force_y", gas),
        ("small_end_force_y", -gas),
    ):
        # after 27 time constants, 2 m/c with 1.39 kg on half of the damping
        assert at_end[key] == pytest.approx(wanted, rel=1e-9)
    of_slider = outputs["upright"]["rod_stretch"][-1], outputs["upright"]["piston_position"][-1]
    rest = -gas / STRETCHED["slider_stiffness"]
    upright = ENGINE["crank_radius"] + ENGINE["rod_length"] + rest
    assert of_slider == pytest.approx((rest, upright), rel=1e-9)  # after 40 time constants
    stretch, y, x, angle, force_x, force_y = (
        np.array(outputs["stretching"][key])
        for key in (
            "rod_stretch",
            "piston_position",
            "lateral_displacement",
            "crank_angle",
            "pin_force_x",
            "pin_force_y",
        )
    )
    rod = np.array([x, y]) + ENGINE["crank_radius"] * np.array([np.sin(angle), -np.cos(angle)])
    length = ENGINE["rod_length"] + stretch
    np.testing.assert_allclose(np.hypot(*rod), length, rtol=1e-14)
    along = (rod * [force_x, force_y]).sum(axis=0) / length
    np.testing.assert_allclose(along, -STRETCHING["slider_stiffness"] * stretch, rtol=1e-9)
    assert np.abs(stretch).max() > 1e-3
