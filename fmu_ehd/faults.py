"""Faults of a step.

Kernels note a fault by number, cell and up to three numbers. The sentence is made outside.
"""

from ..master.fmi.compiled import compiled
from ..master.fmi.noted import DAMAGED_STATE, sentences_of
from ..master.fmi.noted import refuse as note
from .balance.grid import Array
from .laws.cavitation import NotConverged

FROM_BORE = "oil_supply = bore or bore_and_ring"
FAULTS = (
    "film_thickness[{i},{j}] = {a} m, and nowhere above 0 m: there is no film",
    "the film solution is not finite, first at [{i},{j}]: film thickness or viscosity out of all "
    "proportion",
    "cavitation did not converge in {a} iterations: {b} cells still switch, first [{i},{j}] with "
    "u = {c}",
    "forces are not finite at [{i},{j}], film_thickness {a} m, sliding_velocity {b} m/s",
    "viscosity_40: expected more than viscosity_100 = {b} Pa.s, got {a} Pa.s",
    "pressure_lower_edge: expected at least cavitation_pressure = {b} Pa, got {a} Pa",
    "film_fraction_lower_edge: expected 1 above cavitation_pressure = {b} Pa, got {c} at "
    "pressure_lower_edge = {a} Pa",
    "pressure_upper_edge: expected at least cavitation_pressure = {b} Pa, got {a} Pa",
    "film_fraction_upper_edge: expected 1 above cavitation_pressure = {b} Pa, got {c} at "
    "pressure_upper_edge = {a} Pa",
    "film_fraction_openings, pressure_openings: expected 1 and 0 Pa with opening_supply = "
    "lower_edge, got {a} and {b} Pa; or set opening_supply = own",
    "the last step was refused, or there was none: it has no directional derivative",
    "pressure_openings: expected at least cavitation_pressure = {b} Pa, got {a} Pa",
    "film_fraction_openings: expected 1 above cavitation_pressure = {b} Pa, got {c} at "
    "pressure_openings = {a} Pa",
    "roughness_rms: expected more than 0 m with flow_factors = patir_cheng_1978, got 0 m",
    "deflection of the coating did not converge in {a} iterations: last change {b} m at [{i},{j}]",
    "film_thickness[{i},{j}]: expected a finite value, got {a} m",
    "the skirt comes to {a} m from where it started, farther than stroke = {b} m",
    *(
        f"pressure_{edge}_edge: expected cavitation_pressure = {{b}} Pa with {FROM_BORE}, got "
        f"{{a}} Pa"
        for edge in ("lower", "upper")
    ),
    *(
        f"film_fraction_{edge}_edge: expected 1 with {FROM_BORE}, got {{a}}"
        for edge in ("lower", "upper")
    ),
    f"opening_supply: expected lower_edge with {FROM_BORE}, got own",
    f"cavitation_model: expected jfo with {FROM_BORE}, got another model",
    "sector_angle: expected a full revolution for a skirt, got {a} rad",
    "oil_supply: expected edges for a bearing, got bore or bore_and_ring",
    "sector_angle: expected {b} rad for a bearing with cut-outs, got {a} rad",
    "stroke: expected at most {c} m for skirt_length = {b} m in a native FMU, got {a} m",
    "film_thickness: a land or groove is one cell wide, which the grid does not resolve; use a "
    "finer grid or a smoother profile",
    "pressure_viscosity_law: the film pressure exceeds the range of the law, in which viscosity "
    "rises to 1000 times that of low pressure; beyond it the viscosity is constant",
    DAMAGED_STATE,
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
    CUT_OUTS_IN_A_SECTOR,
    STROKE_TOO_LONG,
    NARROW_STEPS,
    BEYOND_PRESSURE_LAW,
    OTHER_STATE,
) = map(float, range(len(FAULTS)))  # numba compiles a kernel anew for every literal integer


@compiled
def refuse(faults: Array, number: float, i: int, j: int, a: float, b: float, c: float):
    """Note a fault in a cell, counted from 0 here and from 1 in sentences."""
    note(faults, number, i + 1.0, j + 1.0, a, b, c)


def raise_noted(faults: Array) -> None:
    """Raise `NotConverged` where a fault is noted, with all their sentences."""
    if faults[0]:
        raise NotConverged("; ".join(sentences_of(faults, FAULTS)))
