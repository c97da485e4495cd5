"""From reduced bodies (.npz) and parameters to the model that runs."""

import numpy as np

from ..geometry.film import Skirt, bore_splines
from ..geometry.grid import cell_centres
from ..geometry.modal_field import modal_field
from ..geometry.profile import (
    barrel,
    fourier_bore,
    linear_growth,
    ovality,
    table_shape,
    tilt_about_x,
)
from .floating_frame import FlexibleBody
from .instant import Block, System
from .model import Crank, PistonInBore
from .pin_friction import PinFriction
from .quasi_static import StaticModes, standing
from .slider_crank import Mechanism


def damping(omega, bands, mass_factor, stiffness_factor):
    """Modal damping by frequency bands, and Rayleigh's two terms besides.

    Eq. (V1):  D = 2 zeta omega + a + b omega^2      zeta the ratio of the band that omega/(2 pi) lies in

    Parameters
    ----------
    omega : ndarray, shape (k,)
        [rad/s]
    bands : sequence of (float, float)
        Frequency from which on it holds [Hz], rising, the first 0, and ratio [-] of each.
    mass_factor, stiffness_factor : float
        a [1/s], b [s].

    Returns
    -------
    ndarray, shape (k,)
        [rad/s]
    """
    begin, ratio = np.array(bands).T
    zeta = ratio[np.searchsorted(2 * np.pi * begin, omega, side="right") - 1]
    return 2 * zeta * omega + mass_factor + stiffness_factor * omega**2  # Eq. (V1)


def damping_bands(p, options):
    """The bands of the build table, else the two of the parameters."""
    return options["damping_bands"] or [
        (0.0, p["damping_ratio"]),
        (p["damping_transition_frequency"], p["high_frequency_damping_ratio"]),
    ]


def faults(p, piston, block, options):
    """Sentences about parameters that do not fit each other: rod too short, skirt leaving the
    bore.
    """
    offset = abs(options["piston"]["pin_offset"] - p["crank_offset"])
    reach = p["rod_length"] ** 2 - (p["crank_radius"] + offset) ** 2
    if reach <= 0.0:
        return [
            f"rod_length = {p['rod_length']:g} m: must exceed crank_radius plus the offsets, "
            f"{p['crank_radius'] + offset:g} m"
        ]
    out = []
    if p["crank_free"] and options["speed"]:
        out.append(
            "crank_free = 1: must be 0 with a table of crank speed ([speed] in the build table)"
        )
    if p["rod_centre"] > p["rod_length"]:
        out.append(
            f"rod_centre = {p['rod_centre']:g} m: must lie within rod_length = {p['rod_length']:g} m"
        )
    turn = np.linspace(0.0, 2 * np.pi, 721)
    A = p["crank_radius"] * np.cos(turn) + np.sqrt(
        p["rod_length"] ** 2
        - (options["piston"]["pin_offset"] - p["crank_offset"] + p["crank_radius"] * np.sin(turn))
        ** 2
    )
    low, high = A.min() + piston["skirt_lower"], A.max() + piston["skirt_upper"]
    if low < block["heights"][0] or high > block["heights"][-1]:
        out.append(
            f"crank_radius, rod_length: the skirt travels from {low:g} to {high:g} m above the crank axis, "
            f"the bore reaches from "
            f"{block['heights'][0]:g} to {block['heights'][-1]:g} m"
        )
    if piston["radius"] >= block["radius"]:
        out.append(
            f"piston mesh: skirt radius {piston['radius']:g} m is not smaller than the bore radius {block['radius']:g} m"
        )
    return out


def symmetry(body):
    """Symmetry classes of a reduced body's modes, None where it has no two planes of symmetry."""
    return (
        body["kind"]
        if body["kind"].size == body["omega"].size and body["kind"].min(initial=0) >= 0
        else None
    )


def bore_shape(heights, angle, options, p):
    """Widening of the undeformed bore on the table of its modes, (c, s) [m]: measured, by Fourier
    orders, by heat.
    """
    shape = fourier_bore(options["block"]["orders"], angle)[:, None]
    shape = shape + linear_growth(
        heights, heights[0], heights[-1], p["bore_growth_lower"], p["bore_growth_upper"]
    )
    return shape + sum(table_shape(table, angle, heights) for table in options["block"]["profiles"])


def parted(piston, strong, limit):
    """The piston with the modes up to `limit` [rad/s], and the faster ones, which follow
    statically; `strong`: see `damping`.
    """
    omega, k = piston["omega"], np.count_nonzero(piston["omega"] <= limit)
    shares = (
        piston["T"][:, :k],
        piston["b"][:k],
        piston["B"][:k, :k],
        piston["g"][:k],
        piston["G"][:k, :k],
    )
    body = FlexibleBody(
        float(piston["mass"]),
        piston["S"],
        float(piston["I0"]),
        *map(np.ascontiguousarray, shares),
        omega[:k] ** 2,
        damping(omega[:k], *strong),
    )
    rest = (piston["T"][:, k:], piston["b"][k:], piston["g"][k:])
    return body, StaticModes(omega[k:] ** 2, *map(np.ascontiguousarray, rest))


def assemble(piston, block, options, p):
    """The model.

    Parameters
    ----------
    piston, block : mapping of ndarray
        Reduced bodies, see `reduction`.
    options : dict
        Of the build (SI).
    p : dict
        Parameters by name (SI), see `variables.parameters`.

    Returns
    -------
    PistonInBore
    """
    strong = damping_bands(p, options), p["rayleigh_mass_factor"], p["rayleigh_stiffness_factor"]
    low, high, offset = (
        float(piston["skirt_lower"]),
        float(piston["skirt_upper"]),
        options["piston"]["pin_offset"],
    )
    angle, height = cell_centres(*options["grid"], low, high)
    gap = (
        p["radial_clearance"]
        + barrel(height, low, high, p["barrel"])
        + ovality(angle, p["ovality"])[:, None]
    )
    gap = gap - linear_growth(height, low, high, p["skirt_growth_lower"], p["skirt_growth_upper"])
    gap = gap + tilt_about_x(angle, height, p["pin_tilt"])
    gap = gap + sum(table_shape(table, angle, height) for table in options["piston"]["profiles"])
    radius = float(block["radius"])
    values = (
        piston[name].reshape(*options["grid"], len(piston["omega"])) for name in ("radial", "axial")
    )
    skirt = Skirt(
        angle, height, gap, radius, offset, *(modal_field(v, symmetry(piston)) for v in values)
    )
    limit = 2 * np.pi * p["quasi_static_frequency"]
    body, body_static = parted(piston, strong, limit)
    friction = PinFriction(
        p["pin_friction_coefficient"] * p["pin_radius"],
        p["pin_friction_speed"],
        p["pin_friction_damping"],
    )
    mechanism = Mechanism(
        p["crank_radius"],
        p["rod_length"],
        offset - p["crank_offset"],
        p["rod_mass"],
        p["rod_inertia"],
        p["rod_centre"] / p["rod_length"],
        p["pin_mass"],
        friction,
    )
    bore = bore_splines(
        block["heights"],
        block["radial"],
        block["axial"],
        symmetry(block),
        bore_shape(block["heights"], angle, options, p),
    )
    omega, k = block["omega"], np.count_nonzero(block["omega"] <= limit)
    system = System(
        body,
        body_static,
        Block(omega[:k] ** 2, damping(omega[:k], *strong)),
        standing(omega[k:] ** 2),
        mechanism,
        skirt,
        bore,
        np.ascontiguousarray(piston["gas_force"]),
    )
    crank = Crank(bool(p["crank_free"]), p["crank_inertia"], p["load_torque"], options["speed"])
    return PistonInBore(system, crank, np.pi * radius**2, p["spectral_radius"], options["gas"])
