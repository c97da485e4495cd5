"""Faults of bodies, build options and parameters that do not fit each other."""

from collections.abc import Mapping, Sequence
from typing import Any

from ...master.fmi.noted import none_yet, sentences_of
from .assembly import ReducedBodies, fit_of
from .build_options import BuildOptions
from .contradictions import FAULT, FAULTS, check
from .parameters import ELEMENT_PARAMETERS, Parameters, settings_of
from .thermal_growth import wall_faults

LARGEST_OFFSET = 0.5
"""Largest offset of the pin, by the skirt radius: our own choice, many times that of engines."""


def faults(
    bodies: ReducedBodies,
    options: BuildOptions,
    parameters: Parameters,
    own: Sequence[Any] = (),
    radii: Mapping[str, float] | None = None,
) -> list[str]:
    """Return sentences about parameters that do not fit each other.

    `own` are as of `model_of`. `radii` are those of flexible shells [m], by surface. Default: those
    of `bodies`.
    """
    offset, most = options.piston.pin_offset, LARGEST_OFFSET * bodies.piston.radius
    if abs(offset) > most:
        got = f"expected at most {1e3 * most:.4g} mm on both sides, got {1e3 * offset:.4g} mm"
        return [f"build.piston.pin_offset: {got}, a share of the skirt radius"]
    noted = none_yet()
    lacks_gas = parameters.gas_source == "table" and not options.gas
    fit = fit_of(bodies, options, bodies.radii() if radii is None else radii)
    check(fit, settings_of(parameters, *own), lacks_gas, noted)
    out = sentences_of(noted, FAULTS)
    if noted[1] == FAULT.rod_too_short and out:
        return out
    if options.in_space and parameters.crank_free:
        out.append("crank_free: expected 0 with motion in space, got 1")
    modes = len(bodies.block.omega) + len(bodies.piston.omega)
    for one in own if options.in_space else ():
        if not isinstance(one, ELEMENT_PARAMETERS):
            continue
        name, value = next(iter(vars(one).items()))
        if value:
            out.append(f"{name}: expected 0 with motion in space, got {value:g}")
    if options.in_space and modes:
        out.append(f"motion_in_space: expected rigid bodies, got {modes} modes")
    return out + body_faults(bodies, options)


def body_faults(bodies: ReducedBodies, options: BuildOptions) -> list[str]:
    """Return sentences about reduced bodies that do not fit each other or the pin."""
    piston, block, bosses, _ = bodies
    out = []
    modes = len(piston.omega)
    if options.floating_pin and modes and not bosses:
        out.append(
            "floating_pin: expected a rigid piston or one with modes for its bosses, "
            f"got {modes} modes"
        )
    if piston.radius >= block.radius:
        out.append(
            f"piston: expected a skirt radius below the bore radius, {block.radius:g} m, got "
            f"{piston.radius:g} m"
        )
    return out + wall_faults(options, piston, block)
