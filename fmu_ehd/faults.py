"""What a step is refused for: kernels note it by number, cell and up to three numbers; the sentence
is made outside.
"""

import numpy as np

from ..master.fmi.compiled import compiled
from .cavitation import NotConverged
from .grid import Array

FROM_BORE = "oil_supply = bore or bore_and_ring"
FAULTS = (
    "film_thickness[{i},{j}] = {a} m, and nowhere above 0 m: there is no film",
    "the film solution is not finite, first at [{i},{j}]: film thickness or viscosity out of all "
    "proportion",
    "cavitation did not converge in {a} iterations: {b} cells still switch, first [{i},{j}] with "
    "u = {c}",
    "forces are not finite at [{i},{j}], film_thickness {a} m, sliding_velocity {b} m/s",
    "viscosity_40 = {a} Pa.s: must be above viscosity_100 = {b} Pa.s",
    "pressure_lower_edge = {a} Pa: must not be below cavitation_pressure = {b} Pa",
    "film_fraction_lower_edge = {c} (unit 1) at pressure_lower_edge = {a} Pa: what is only partly "
    "filled must be at cavitation_pressure = {b} Pa, or filled to 1",
    "pressure_upper_edge = {a} Pa: must not be below cavitation_pressure = {b} Pa",
    "film_fraction_upper_edge = {c} (unit 1) at pressure_upper_edge = {a} Pa: what is only partly "
    "filled must be at cavitation_pressure = {b} Pa, or filled to 1",
    "film_fraction_openings = {a} (unit 1), pressure_openings = {b} Pa with opening_supply = "
    "lower_edge: without effect, leave them at 1 and 0 Pa or choose opening_supply = own",
    "the last step was refused, or there was none: it has no directional derivative",
    "pressure_openings = {a} Pa: must not be below cavitation_pressure = {b} Pa",
    "film_fraction_openings = {c} (unit 1) at pressure_openings = {a} Pa: what is only partly "
    "filled must be at cavitation_pressure = {b} Pa, or filled to 1",
    "flow_factors = patir_cheng_1978: needs roughness_rms > 0 m",
    "deflection of the coating did not converge in {a} iterations: last change {b} m at [{i},{j}]",
    "film_thickness[{i},{j}] = {a} m: must be finite",
    "the skirt comes to {a} m from where it started, farther than stroke = {b} m",
    *(
        f"pressure_{edge}_edge = {{a}} Pa with {FROM_BORE}: an edge that oil may not fill must be "
        "at cavitation_pressure = {b} Pa"
        for edge in ("lower", "upper")
    ),
    *(
        f"film_fraction_{edge}_edge = {{a}} with {FROM_BORE}: follows from the oil on the bore, "
        "leave it at 1"
        for edge in ("lower", "upper")
    ),
    f"opening_supply = own with {FROM_BORE}: what cut-outs give follows from the oil on the bore",
    f"cavitation_model = reynolds, gumbel or full_film with {FROM_BORE}: needs jfo",
    "sector_angle = {a} rad: a skirt is a ring, only a bearing can be a sector",
    "oil_supply on a bearing: from the bore it is known for a skirt alone, choose edges",
    "flow_factors = patir_cheng_1978 on a bearing: known for a skirt alone, choose none",
    "sector_angle = {a} rad with cut-outs: those of a bearing need the full turn, {b} rad",
    "stroke = {a} m: on skirt_length = {b} m a native FMU has room for {c} m",
)
"""Sentences of the faults, by number; {i} and {j} are the cell, {a} to {c} numbers."""
(
    NO_FILM,
    NOT_FINITE,
    STILL_SWITCHING,
    FORCES_NOT_FINITE,
    VISCOSITIES_REVERSED,
    LOWER_BELOW_CAVITATION,
    LOWER_PARTLY_FILLED,
    UPPER_BELOW_CAVITATION,
    UPPER_PARTLY_FILLED,
    OPENINGS_WITHOUT_EFFECT,
    NO_TANGENT,
    OPENINGS_BELOW_CAVITATION,
    OPENINGS_PARTLY_FILLED,
    FACTORS_WITHOUT_ROUGHNESS,
    DEFLECTION_NOT_FOUND,
    FILM_NOT_FINITE,
    TOO_FAR,
    LOWER_NOT_AT_CAVITATION,
    UPPER_NOT_AT_CAVITATION,
    LOWER_FRACTION_FOLLOWS,
    UPPER_FRACTION_FOLLOWS,
    OPENINGS_FOLLOW,
    FROM_BORE_NOT_CONSERVING,
    SECTOR_OF_A_SKIRT,
    OIL_ON_A_BEARING,
    FACTORS_ON_A_BEARING,
    CUT_OUTS_IN_A_SECTOR,
    STROKE_TOO_LONG,
) = map(float, range(len(FAULTS)))  # numba compiles a kernel anew for every literal integer
MOST_FAULTS = 12
OF_A_FAULT = 6  # number of the sentence, i, j, a, b, c
ROOM = 1 + MOST_FAULTS * OF_A_FAULT  # numbers: how many, then each


@compiled
def refuse(faults: Array, number: float, i: int, j: int, a: float, b: float, c: float):
    """Note a fault."""
    count = int(faults[0])
    if count < MOST_FAULTS:
        first = 1 + OF_A_FAULT * count
        faults[first] = number
        faults[first + 1] = i + 1
        faults[first + 2] = j + 1
        faults[first + 3] = a
        faults[first + 4] = b
        faults[first + 5] = c
        faults[0] = count + 1


def sentences_of(faults: Array) -> list[str]:
    """The sentence of each fault that is noted."""
    noted = faults[1:].reshape(MOST_FAULTS, OF_A_FAULT)[: int(faults[0])].tolist()
    return [
        FAULTS[int(number)].format(i=int(i), j=int(j), a=f"{a:g}", b=f"{b:g}", c=f"{c:g}")
        for number, i, j, a, b, c in noted
    ]


def raise_noted(faults: Array) -> None:
    """Raise `NotConverged` where a fault is noted, with all their sentences."""
    if faults[0]:
        raise NotConverged("; ".join(sentences_of(faults)))


def none_yet() -> Array:
    """Room for faults."""
    return np.zeros(ROOM)
