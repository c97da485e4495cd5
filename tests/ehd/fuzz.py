"""Random calls with random values, most of them senseless, on the lubrication slave.

Every call must return; a step that is refused must leave the state as it was, to the bit; a step
that is taken must give finite forces, a state whose bytes are accepted, and a film fraction between
0 and 1 unless film, velocity or pressure are beyond all sense.
"""

import json

import numpy as np

from piston_cosim.fmu_ehd.build import prepare
from piston_cosim.fmu_ehd.slave import Ehd

STRANGE = (0.0, -0.0, 1.0, -1.0, 1e-300, 1e300, -1e300, 1e12, -1e12, np.nan, np.inf, -np.inf)


def made_slave(folder, **build):
    """Return a slave of build options that reads and writes its files in a folder."""
    options, files = prepare(build, folder, print)
    assert files == []
    (folder / "build.json").write_text(json.dumps(options))
    return Ehd(instance_name="film", resources=str(folder))


class Fuzz:
    """A slave under fire.

    Parameters
    ----------
    seed : int
    folder : pathlib.Path
        For its resources.
    """

    def __init__(self, seed, folder):
        self.rng = np.random.default_rng(seed)
        self.folder, self.taken, self.refused, self.saved = folder, 0, 0, []
        self.renew()

    def renew(self):
        """Replace the slave; a third of the new ones have strange parameters."""
        inputs = ["pressure_upper_edge", "oil_temperature"]
        self.slave = made_slave(self.folder, grid=[6, 5], inputs=inputs)
        self.slave.log = lambda *arguments: None
        laws = {
            "viscosity_law": ("constant", "vogel_1921"),
            "pressure_viscosity_law": ("none", "barus_1893", "roelands_1966"),
            "shear_thinning_law": ("none", "cross_1965"),
            "flow_factors": ("none", "patir_cheng_1978"),
            "cavitation_model": ("jfo", "reynolds", "gumbel", "full_film"),
        }
        for name, choices in laws.items():
            number = int(self.rng.integers(1, len(choices) + 1))
            self.slave.set_integer([self.slave.first_references[name]], [number])
        self.slave.views["roughness_rms"][...] = 1e-6
        if self.rng.random() < 0.3:  # mostly refused
            self.set_values()
        self.slave.exit_initialization_mode()
        self.saved = []

    def value(self):
        """Return a plausible or a strange number."""
        return (
            float(self.rng.choice(STRANGE))
            if self.rng.random() < 0.3
            else 10.0 ** self.rng.uniform(-8.0, 6.0)
        )

    def set_values(self):
        """Set any values of consecutive references.

        Parameters are set only before initialisation, as the standard demands.
        """
        free = (
            0
            if self.slave.state is None and self.slave.fault is None
            else self.slave.references["film_thickness"]
        )
        first = int(self.rng.integers(free, len(self.slave.real)))
        last = min(first + int(self.rng.integers(1, 40)), len(self.slave.real))
        self.slave.set_real(list(range(first, last)), [self.value() for _ in range(first, last)])

    def set_film(self):
        """Set a plausible film and velocity, sometimes with one strange element."""
        film = 10.0 ** self.rng.uniform(-7.0, -4.0) * self.rng.uniform(-0.2, 1.0, (6, 5))
        if self.rng.random() < 0.1:
            film[tuple(self.rng.integers(5, size=2))] = self.value()
        self.slave.views["film_thickness"][...] = film
        self.slave.views["sliding_velocity"][...] = self.rng.uniform(-20.0, 20.0)
        self.slave.views["oil_temperature"][...] = self.rng.uniform(300.0, 450.0)
        self.slave.views["pressure_upper_edge"][...] = self.rng.choice([0.0, 1e5])

    def step(self):
        """Take a step of plausible or strange size."""
        if self.rng.random() < 0.7:
            self.set_film()
        before = (
            self.slave._fmu_state_to_bytes(self.slave._get_fmu_state())
            if self.slave.state is not None
            else None
        )
        size = 10.0 ** self.rng.uniform(-7.0, -3.0) if self.rng.random() < 0.8 else self.value()
        if self.slave.do_step(0.0, size):
            self.taken += 1
            slave = self.slave
            slave._fmu_state_from_bytes(slave._fmu_state_to_bytes(slave._get_fmu_state()))
            views = self.slave.views
            assert (
                np.isfinite(views["nodal_pressure_force"]).all()
                and np.isfinite(views["nodal_friction_force"]).all()
            )
            if (
                views["maximum_pressure"] < 1e12
                and views["film_thickness"].max() < 1.0
                and np.abs(views["sliding_velocity"]).max() < 1e6
            ):  # beyond, the round-off of flows fills a cell
                assert (
                    -1e-9 <= views["film_fraction"].min()
                    and views["film_fraction"].max() <= 1.0 + 1e-9
                )
            return
        self.refused += 1
        if before is not None:
            assert self.slave._fmu_state_to_bytes(self.slave._get_fmu_state()) == before

    def read(self):
        """Any run of references, the products of the directional derivative among them."""
        first = int(self.rng.integers(len(self.slave.real)))
        self.slave.get_real(list(range(first, min(first + 40, len(self.slave.real)))))

    def save_and_restore(self):
        """Keep the state, or go back to a kept one, half of the time through its bytes."""
        if not self.saved or self.rng.random() < 0.5:
            self.saved = [*self.saved[-4:], self.slave._get_fmu_state()]
            return
        state = self.saved[int(self.rng.integers(len(self.saved)))]
        if self.rng.random() < 0.5:
            state = self.slave._fmu_state_from_bytes(self.slave._fmu_state_to_bytes(state))
        self.slave._set_fmu_state(state)

    def run(self, calls):
        """So many calls."""
        work = (
            self.set_values,
            self.set_film,
            self.step,
            self.step,
            self.read,
            self.save_and_restore,
        )
        for _ in range(calls):
            if self.rng.random() < 0.005:
                self.renew()
            work[int(self.rng.integers(len(work)))]()
