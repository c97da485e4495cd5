"""Main results of a run in ten lines: film, forces, motion and oil."""

from typing import NamedTuple

from .measures import Measures

FILM, BODIES = "film", "bodies"
LINES = (
    ("minimum film", FILM, ["minimum_film_thickness_m"], ""),
    ("maximum pressure", FILM, ["maximum_pressure_pa"], ""),
    ("pressure peak", FILM, ["peak_distance_rad"], "; "),
    ("friction", "", ["mean_friction_power_w", "friction_mean_effective_pressure_pa"], ", "),
    ("asperity contact", FILM, ["contact_share", "contact_area"], ", "),
    ("side force", BODIES, ["side_force_n", "side_force_demand_n"], "; "),
    ("slap", BODIES, ["slap_energy_j"], ""),
    (
        "lateral motion",
        BODIES,
        ["minimum_lateral_displacement_m", "maximum_lateral_displacement_m"],
        " to ",
    ),
    ("rocking angle", BODIES, ["minimum_rocking_angle_rad", "maximum_rocking_angle_rad"], " to "),
    ("oil", FILM, ["oil_throughput_m3"], ""),
)
"""Name of a line, whose participants have one, its measures, and the text between them."""


class Headline(NamedTuple):
    """Name of a result and its text."""

    name: str
    said: str


def headlines(table: Measures) -> list[Headline]:
    """Return the lines of a run, none without a piston and its film."""
    if not table.films or not table.bodies:
        return []
    owners = {FILM: table.films, BODIES: table.bodies, "": [""]}
    found = []
    for name, kind, keys, between in LINES:
        for owner in owners[kind]:
            known = [one for one in table.all if one.owner == owner and one.key in keys]
            said = between.join(one.text for one in known)
            alone = len(owners[kind]) == 1
            found.append(Headline(name if alone else f"{name}, {owner}", said))
    return [line for line in found if line.said]
