"""Faults of a step.

Kernels note a fault by number, cell and up to three numbers. The sentence is made outside.
"""

from ...master.fmi.compiled import compiled
from ...master.fmi.noted import DAMAGED_STATE, OF_A_FAULT, numbers_of, sentences_of
from ...master.fmi.noted import refuse as note
from .grid import Array


class NotConverged(RuntimeError):
    """Step without a solution, or whose solution was not reached.

    The message contains cause, location and size.
    """


FROM_BORE = "oil_supply = bore or bore_and_ring"
EDGES = {"lower": "lower_edge", "upper": "upper_edge", "openings": "openings"}
AXIAL = {edge: EDGES[edge] for edge in ("lower", "upper")}
TOO_LOW = "expected more than {b} m, got {a} m; the contact law ends at -1.5 roughness_rms"
SENTENCES = {
    "overlap": f"film_thickness[{{i}},{{j}}]: {TOO_LOW}",
    "overlap_of_coating": f"film_thickness[{{i}},{{j}}] plus deflection of the coating: {TOO_LOW}",
    "not_finite": "the film solution is not finite, first at [{i},{j}]: film thickness or "
    "viscosity out of all proportion",
    "still_switching": "cavitation did not converge in {a} iterations: {b} cells still switch, "
    "first [{i},{j}] with u = {c}",
    "forces_not_finite": "forces are not finite at [{i},{j}], film_thickness {a} m, "
    "sliding_velocity {b} m/s",
    "overflow": "numbers overflow after a step of {a} s with a friction work of {b} J: film "
    "thickness or step out of all proportion",
    "viscosities_reversed": "viscosity_40: expected more than viscosity_100 = {b} Pa.s, got "
    "{a} Pa.s",
    **{
        f"{edge}_below_cavitation": f"pressure_{name}: expected at least cavitation_pressure = "
        "{b} Pa, got {a} Pa"
        for edge, name in EDGES.items()
    },
    **{
        f"{edge}_partly_filled": f"film_fraction_{name}: expected 1 above cavitation_pressure = "
        f"{{b}} Pa, got {{c}} at pressure_{name} = {{a}} Pa"
        for edge, name in EDGES.items()
    },
    "openings_without_effect": "film_fraction_openings, pressure_openings: expected 1 and 0 Pa "
    "with opening_supply = lower_edge, got {a} and {b} Pa; or set opening_supply = own",
    "no_tangent": "the last step was refused, or there was none: it has no directional derivative",
    "factors_without_roughness": "roughness_rms: expected more than 0 m with flow_factors = "
    "patir_cheng_1978, got 0 m",
    "rounding_without_jfo": "cavitation_rounding: expected 0 Pa with a coating or a "
    "cavitation_model other than jfo, got {a} Pa",
    "rounding_not_found": "cavitation_rounding: the film did not converge in {a} iterations: last "
    "change of its derivatives {b} at [{i},{j}]",
    "deflection_not_found": "deflection of the coating did not converge in {a} iterations: last "
    "change {b} m at [{i},{j}]",
    "film_not_finite": "film_thickness[{i},{j}]: expected a finite value, got {a} m",
    "too_far": "the skirt comes to {a} m from where it started, farther than stroke = {b} m",
    **{
        f"{edge}_not_at_cavitation": f"pressure_{name}: expected cavitation_pressure = {{b}} Pa "
        f"with {FROM_BORE}, got {{a}} Pa"
        for edge, name in AXIAL.items()
    },
    **{
        f"{edge}_fraction_follows": f"film_fraction_{name}: expected 1 with {FROM_BORE}, got {{a}}"
        for edge, name in AXIAL.items()
    },
    "openings_follow": f"opening_supply: expected lower_edge with {FROM_BORE}, got own",
    "from_bore_not_conserving": f"cavitation_model: expected jfo with {FROM_BORE}, got another "
    "model",
    "sector_of_a_skirt": "sector_angle: expected a full revolution for a skirt, got {a} rad",
    "oil_on_a_bearing": "oil_supply: expected edges for a bearing, got bore or bore_and_ring",
    "cut_outs_in_a_sector": "sector_angle: expected {b} rad for a bearing with openings, got "
    "{a} rad",
    "stroke_too_long": "stroke: expected at most {c} m for skirt_length = {b} m in a native FMU, "
    "got {a} m",
    "narrow_steps": "film_thickness: a land or groove is one cell wide, which the grid does not "
    "resolve; use a finer grid, or remove noise of a measured profile by piston-cosim profile "
    "--smooth",
    "beyond_pressure_law": "pressure_viscosity_law: the film pressure exceeds the range of the "
    "law, in which viscosity rises to 1000 times that of low pressure; beyond it the viscosity is "
    "constant",
    "below_pressure_law": "pressure_viscosity_law: expected more than {b} Pa relative to "
    "cavitation_pressure, where roelands_1966 ends, got {a} Pa at [{i},{j}]; use barus_1893 or a "
    "cavitation model other than full_film",
    "other_state": DAMAGED_STATE,
    "cells_without_image": "film_symmetry: expected none for a bearing, for an odd number of cells "
    "around, or for openings that differ from their mirror image, got thrust_plane",
    **{
        f"odd_{name}": f"{name}[{{i}},{{j}}]: expected {{b}} {unit} as in the mirror image with "
        f"film_symmetry = thrust_plane, got {{a}} {unit}; set film_symmetry = none"
        for name, unit in (
            ("film_thickness", "m"),
            ("sliding_velocity", "m/s"),
            ("oil_temperature", "K"),
        )
    },
}
"""Sentences of the faults; {i} and {j} are the cell, {a} to {c} numbers."""
FAULTS = tuple(SENTENCES.values())
FAULT = numbers_of(SENTENCES)


@compiled
def refuse(faults: Array, number: float, i: int, j: int, a: float, b: float, c: float):
    """Note a fault in a cell, counted from 0 here and from 1 in sentences."""
    note(faults, number, i + 1.0, j + 1.0, a, b, c)


@compiled
def count_rows_from(faults: Array, first: int):
    """Add the first row of a grid to the cells of all noted faults."""
    for k in range(int(faults[0])):
        faults[2 + OF_A_FAULT * k] += first


def raise_noted(faults: Array, first: int = 0) -> None:
    """Raise `NotConverged` if a fault is noted, with all sentences; first : row of the grid."""
    if faults[0]:
        count_rows_from(faults, first)
        raise NotConverged("; ".join(sentences_of(faults, FAULTS)))
