"""Mass balance of a thin film on a grid: face flows, five-point matrix, exact tangent.

Eq. (E1):  A (f s - c_e) / H_e + sum of outward face flows = 0                  each cell; c_e, H_e of `storage`
Eq. (E2):  q = K (p_a - p_b) + max(T, 0) f_a + min(T, 0) f_b                    flow from cell a to its neighbour b [m3/s]
Eq. (E3):  K = (w/d) 2 g_a g_b / (g_a + g_b),  T = w U (t_a g_b + t_b g_a) / (g_a + g_b)
Eq. (E4):  u > 0: p = u, f = 1;   u <= 0: p = 0, f = 1 + u                      one signed unknown u a cell
Eq. (E5):  q = c_a u_a + c_b u_b + T,  c_a = K or max(T, 0), c_b = -K or min(T, 0)   where (a, b) is full or cavitated
Eq. (E6):  M du = -(dR/ds ds + dR/dt dt + dR/dg dg + dR/dU dU)                  tangent with the matrix M of the step

A cell area [m2], H_e length of the backward Euler step [s] that starts from the content c_e [m], f
film fraction [-], p pressure above cavitation pressure [Pa], w face width, d distance between cell
centres [m], U entrainment velocity at the face, the mean of both cells [m/s]. Per cell: s stored
film [m], t transported film [m], g conductivity [m3/(Pa s)]; for smooth surfaces s = t = h and g =
h^3 / (12 mu).

The face film of Eq. (E3) is that of two half cells of constant thickness in series, so a stepped
film is exact on every grid and a smooth one of second order; it stays near the thinner film where
the film jumps. Film fraction multiplies the same face film upstream, so the flow is continuous when
a cell fills or empties, f >= 0, and the matrix is a column-dominant M-matrix. Its columns for u <=
0 need no scaling: elimination is indifferent to column scale. Edges are half a cell away from the
centre (d/2), with the film of their cell.

Arrays have the shape (n_c, n_a) of the grid; faces (n_c + 1, n_a) across i and (n_c, n_a + 1)
across j. Face i lies between cells i - 1 and i. All functions are pure.

References ---------- [Elrod1981] H. G. Elrod, A cavitation algorithm, J. Lubr. Technol. 103 (1981)
350-354 (the film content as unknown). [Woloszynski2015] T. Woloszynski, P. Podsiadlo, G. W.
Stachowiak, Efficient solution to the cavitation problem in hydrodynamic lubrication, Tribol. Lett.
58 (2015) 18 (the complementarity form).
"""

import numpy as np

from ..master.fmi.compiled import compiled


@compiled(inline="always")
def _face(g_a, g_b, t_a, t_b, velocity, aspect, width):
    """Conductance K and transport T of a face, Eq. (E3)."""
    inverse = 1.0 / (g_a + g_b)
    return aspect * 2.0 * g_a * g_b * inverse, width * velocity * (t_a * g_b + t_b * g_a) * inverse


@compiled
def faces(conductivity_c, conductivity_a, transport, velocity_c, velocity_a, dx, dy, ring):
    """Conductances and transports of all faces, Eq. (E3).

    Parameters
    ----------
    conductivity_c, conductivity_a : ndarray, shape (n_c, n_a)
        Conductivity g in the circumferential and axial direction [m3/(Pa s)], > 0.
    transport : ndarray, shape (n_c, n_a)
        Transported film t [m], > 0.
    velocity_c, velocity_a : ndarray, shape (n_c, n_a)
        Entrainment velocity along i and along j [m/s].
    dx, dy : float
        Cell size along i and j [m].
    ring : bool
        True if i is periodic.

    Returns
    -------
    tuple of ndarray
        K and T across i, shape (n_c + 1, n_a), K and T across j, shape (n_c, n_a + 1) [m3/(Pa s)],
        [m3/s].
    """
    n_c, n_a = transport.shape
    k_c, t_c = np.empty((n_c + 1, n_a)), np.empty((n_c + 1, n_a))
    k_a, t_a = np.empty((n_c, n_a + 1)), np.empty((n_c, n_a + 1))
    for i in range(n_c + 1):
        below, above = (i - 1) % n_c, i % n_c
        if not ring:
            below, above = max(i - 1, 0), min(i, n_c - 1)
        aspect = dy / dx if ring or 0 < i < n_c else 2.0 * dy / dx
        for j in range(n_a):
            velocity = 0.5 * (velocity_c[below, j] + velocity_c[above, j])
            k_c[i, j], t_c[i, j] = _face(
                conductivity_c[below, j],
                conductivity_c[above, j],
                transport[below, j],
                transport[above, j],
                velocity,
                aspect,
                dy,
            )
    for i in range(n_c):
        for j in range(n_a + 1):
            below, above = max(j - 1, 0), min(j, n_a - 1)
            aspect = dx / dy if 0 < j < n_a else 2.0 * dx / dy
            velocity = 0.5 * (velocity_a[i, below] + velocity_a[i, above])
            k_a[i, j], t_a[i, j] = _face(
                conductivity_a[i, below],
                conductivity_a[i, above],
                transport[i, below],
                transport[i, above],
                velocity,
                aspect,
                dx,
            )
    return k_c, t_c, k_a, t_a


@compiled
def assemble(
    full, k_c, t_c, k_a, t_a, stored, content, area_per_step, edge_pressure, edge_fraction, ring
):
    """Five-point matrix and right-hand side of Eq. (E1) for a given pattern of full cells, by Eq.
    (E5).

    Parameters
    ----------
    full : ndarray of bool, shape (n_c, n_a)
        Pattern: True where u is pressure.
    k_c, t_c, k_a, t_a : ndarray
        From `faces`.
    stored, content : ndarray, shape (n_c, n_a)
        Stored film s of a full cell at the end of the step, and content c_e that the step starts
        from [m].
    area_per_step : float
        A / H_e [m2/s]; 0 for a steady film.
    edge_pressure, edge_fraction : ndarray, shape (4,)
        As in `grid.Edges`.
    ring : bool

    Returns
    -------
    stencil : tuple of ndarray, each shape (n_c, n_a)
        centre, south, north, west, east for `blocks`.
    right : ndarray, shape (n_c, n_a)
    """
    n_c, n_a = full.shape
    centre, south, north = np.zeros((n_c, n_a)), np.zeros((n_c, n_a)), np.zeros((n_c, n_a))
    west, east, right = np.zeros((n_c, n_a)), np.zeros((n_c, n_a)), np.empty((n_c, n_a))
    for i in range(n_c):
        for j in range(n_a):
            right[i, j] = area_per_step * (content[i, j] - stored[i, j])
            if not full[i, j]:
                centre[i, j] = area_per_step * stored[i, j]
    for i in range(n_c + 1):
        a, b = (i - 1) % n_c, i % n_c
        if ring and i == n_c:  # the same face as i = 0
            break
        for j in range(n_a):
            k, t = k_c[i, j], t_c[i, j]
            c_a = k if full[a, j] else max(t, 0.0)
            c_b = -k if full[b, j] else min(t, 0.0)
            if ring or 0 < i < n_c:
                centre[a, j] += c_a
                east[a, j] += c_b
                right[a, j] -= t
                centre[b, j] -= c_b
                west[b, j] -= c_a
                right[b, j] += t
            elif i == 0:
                centre[b, j] -= c_b
                right[b, j] += k * edge_pressure[2] + max(t, 0.0) * edge_fraction[2] + min(t, 0.0)
            else:
                centre[a, j] += c_a
                right[a, j] += k * edge_pressure[3] - max(t, 0.0) - min(t, 0.0) * edge_fraction[3]
    for i in range(n_c):
        k, t = k_a[i, 0], t_a[i, 0]
        centre[i, 0] -= -k if full[i, 0] else min(t, 0.0)
        right[i, 0] += k * edge_pressure[0] + max(t, 0.0) * edge_fraction[0] + min(t, 0.0)
        for j in range(1, n_a):
            k, t = k_a[i, j], t_a[i, j]
            c_a = k if full[i, j - 1] else max(t, 0.0)
            c_b = -k if full[i, j] else min(t, 0.0)
            centre[i, j - 1] += c_a
            north[i, j - 1] += c_b
            right[i, j - 1] -= t
            centre[i, j] -= c_b
            south[i, j] -= c_a
            right[i, j] += t
        k, t = k_a[i, n_a], t_a[i, n_a]
        centre[i, n_a - 1] += k if full[i, n_a - 1] else max(t, 0.0)
        right[i, n_a - 1] += k * edge_pressure[1] - max(t, 0.0) - min(t, 0.0) * edge_fraction[1]
    return (centre, south, north, west, east), right


@compiled
def hold(fixed, value, centre, south, north, west, east, right):
    """Replace the balance of fixed cells by u = value; in place.

    Parameters
    ----------
    fixed : ndarray of bool, shape (n_c, n_a)
    value : float
        Signed unknown of fixed cells.
    centre, south, north, west, east, right : ndarray, shape (n_c, n_a)
        From `assemble`.
    """
    for i in range(fixed.shape[0]):
        for j in range(fixed.shape[1]):
            if fixed[i, j]:
                centre[i, j], right[i, j] = 1.0, value
                south[i, j] = north[i, j] = west[i, j] = east[i, j] = 0.0


@compiled(inline="always")
def _flow(k, t, p_a, p_b, f_a, f_b):
    """Face flow, Eq. (E2)."""
    return k * (p_a - p_b) + max(t, 0.0) * f_a + min(t, 0.0) * f_b


@compiled
def outflow(pressure, fraction, k_c, t_c, k_a, t_a, edge_pressure, edge_fraction, ring):
    """Sum of outward face flows of each cell, and the inward flows over the four edges, Eq. (E2).

    Parameters
    ----------
    pressure, fraction : ndarray, shape (n_c, n_a)
        Pressure above cavitation pressure [Pa] and film fraction [-].
    k_c, t_c, k_a, t_a : ndarray
        From `faces`.
    edge_pressure, edge_fraction : ndarray, shape (4,)
    ring : bool

    Returns
    -------
    out : ndarray, shape (n_c, n_a)
        [m3/s].
    edge_flow : ndarray, shape (4,)
        Flow into the film over lower, upper, first, last edge [m3/s].
    gross : float
        Sum of the magnitudes of both terms of Eq. (E2) over the edges [m3/s].
    """
    n_c, n_a = pressure.shape
    out = np.zeros((n_c, n_a))
    edge_flow = np.zeros(4)
    gross = 0.0
    for i in range(n_c):
        q = _flow(
            k_a[i, 0], t_a[i, 0], edge_pressure[0], pressure[i, 0], edge_fraction[0], fraction[i, 0]
        )
        edge_flow[0] += q
        out[i, 0] -= q
        for j in range(1, n_a):
            q = _flow(
                k_a[i, j],
                t_a[i, j],
                pressure[i, j - 1],
                pressure[i, j],
                fraction[i, j - 1],
                fraction[i, j],
            )
            out[i, j - 1] += q
            out[i, j] -= q
        last = n_a - 1
        q = _flow(
            k_a[i, n_a],
            t_a[i, n_a],
            pressure[i, last],
            edge_pressure[1],
            fraction[i, last],
            edge_fraction[1],
        )
        edge_flow[1] -= q
        out[i, last] += q
        gross += k_a[i, 0] * (pressure[i, 0] + edge_pressure[0]) + abs(t_a[i, 0])
        gross += k_a[i, n_a] * (pressure[i, last] + edge_pressure[1]) + abs(t_a[i, n_a])
    last = n_c - 1
    for j in range(n_a):
        for i in range(1, n_c):
            q = _flow(
                k_c[i, j],
                t_c[i, j],
                pressure[i - 1, j],
                pressure[i, j],
                fraction[i - 1, j],
                fraction[i, j],
            )
            out[i - 1, j] += q
            out[i, j] -= q
        if ring:
            q = _flow(
                k_c[0, j],
                t_c[0, j],
                pressure[last, j],
                pressure[0, j],
                fraction[last, j],
                fraction[0, j],
            )
            out[last, j] += q
            out[0, j] -= q
        else:
            q = _flow(
                k_c[0, j],
                t_c[0, j],
                edge_pressure[2],
                pressure[0, j],
                edge_fraction[2],
                fraction[0, j],
            )
            edge_flow[2] += q
            out[0, j] -= q
            q = _flow(
                k_c[n_c, j],
                t_c[n_c, j],
                pressure[last, j],
                edge_pressure[3],
                fraction[last, j],
                edge_fraction[3],
            )
            edge_flow[3] -= q
            out[last, j] += q
            gross += k_c[0, j] * (pressure[0, j] + edge_pressure[2]) + abs(t_c[0, j])
            gross += k_c[n_c, j] * (pressure[last, j] + edge_pressure[3]) + abs(t_c[n_c, j])
    return out, edge_flow, gross


@compiled
def balance(
    pressure,
    deficit,
    faces,
    stored,
    content,
    area_per_step,
    edge_pressure,
    edge_fraction,
    ring,
    open_cells,
):
    """Residual of Eq. (E1) in each cell, content at the end of the step, and the mass imbalance of
    the whole film.

    Parameters
    ----------
    pressure, deficit : ndarray, shape (n_c, n_a)
        Pressure above cavitation pressure [Pa], film fraction - 1 [-].
    faces : tuple of ndarray
        From `faces`.
    stored, content, area_per_step, edge_pressure, edge_fraction, ring
        As in `assemble`.
    open_cells : ndarray of bool, shape (n_c, n_a)
        Cells without a film; what flows out of them counts as inflow over an edge.

    Returns
    -------
    fraction, now, residual : ndarray, shape (n_c, n_a)
        f [-], f s [m], inflow - growth [m3/s].
    edge_flow : ndarray, shape (4,)
        As from `outflow`.
    imbalance : float
        |inflow - growth| / throughput of the film [-].
    """
    fraction = 1.0 + deficit
    out, edge_flow, gross = outflow(pressure, fraction, *faces, edge_pressure, edge_fraction, ring)
    now, residual = np.empty_like(pressure), np.empty_like(pressure)
    total, inflow, throughput, volume = 0.0, 0.0, 0.0, 0.0
    for flow in edge_flow:
        inflow += flow
        throughput += abs(flow)
    for i in range(pressure.shape[0]):
        for j in range(pressure.shape[1]):
            now[i, j] = fraction[i, j] * stored[i, j]
            growth = area_per_step * (stored[i, j] - content[i, j] + deficit[i, j] * stored[i, j])
            residual[i, j] = -out[i, j] - growth
            volume += stored[i, j]
            if open_cells[i, j]:
                residual[i, j] = 0.0
                inflow += out[i, j]
                throughput += abs(out[i, j])
            else:
                total += growth
                throughput += abs(growth)
    # round-off of pressures and film fractions says nothing about a film in which next to nothing
    # moves
    floor = max(1e-3 * gross, 1e-3 * area_per_step * volume, 1e-300)
    return fraction, now, residual, edge_flow, abs(inflow - total) / max(throughput, floor)


@compiled(inline="always")
def _flow_slopes(g_a, g_b, t_a, t_b, velocity_a, velocity_b, aspect, width, p_a, p_b, f_a, f_b):
    """Derivatives of the face flow, Eqs. (E2), (E3), to g_a, g_b, t_a, t_b and to the velocity of
    either cell.
    """
    velocity = 0.5 * (velocity_a + velocity_b)
    upstream = f_a if velocity > 0.0 else f_b
    inverse = 1.0 / (g_a + g_b)
    share_a, share_b = g_a * inverse, g_b * inverse
    moved = width * velocity * upstream
    bend, driven = moved * (t_b - t_a) * inverse, 2.0 * aspect * (p_a - p_b)
    by_g_a, by_g_b = share_b * (share_b * driven + bend), share_a * (share_a * driven - bend)
    return (
        by_g_a,
        by_g_b,
        moved * share_b,
        moved * share_a,
        0.5 * width * upstream * (t_a * share_b + t_b * share_a),
    )


@compiled(inline="always")
def _edge_changes(slopes, by_film, by_velocity, dvelocity, row, i, j):
    """Derivatives of the flow over an edge to film and sliding velocity of its cell, which stands
    on both sides of the face.
    """
    g_a, g_b, t_a, t_b, v = slopes
    film = (g_a + g_b) * by_film[row, i, j] + (t_a + t_b) * by_film[1, i, j]
    velocity = 2.0 * v * dvelocity[i, j]
    if by_velocity.shape[0] > 0:
        velocity += (g_a + g_b) * by_velocity[row, i, j] + (t_a + t_b) * by_velocity[1, i, j]
    return film, velocity


@compiled
def _edge_slopes(
    film_c,
    film_a,
    by_film,
    by_velocity,
    dvelocity_c,
    dvelocity_a,
    pressure,
    fraction,
    dx,
    dy,
    edge_pressure,
    edge_fraction,
    ring,
    centre,
):
    """Add the derivatives of the flows over the edges to the centre of both stencils, shape (2,
    n_c, n_a).
    """
    (g, t, u), n_c, n_a = film_a, *pressure.shape
    for i in range(n_c):
        for edge in range(2):
            j, sign = (
                (0, -1.0) if edge == 0 else (n_a - 1, 1.0)
            )  # inward flow over the lower edge, outward over the upper one
            p, f, q, r = pressure[i, j], fraction[i, j], edge_pressure[edge], edge_fraction[edge]
            p_a, p_b, f_a, f_b = (q, p, r, f) if edge == 0 else (p, q, f, r)
            slopes = _flow_slopes(
                g[i, j],
                g[i, j],
                t[i, j],
                t[i, j],
                u[i, j],
                u[i, j],
                2.0 * dx / dy,
                dx,
                p_a,
                p_b,
                f_a,
                f_b,
            )
            film, velocity = _edge_changes(slopes, by_film, by_velocity, dvelocity_a, 3, i, j)
            centre[0, i, j] += sign * film
            centre[1, i, j] += sign * velocity
    g, t, u = film_c
    for j in range(0 if ring else n_a):
        for edge in range(2):
            i, sign = (0, -1.0) if edge == 0 else (n_c - 1, 1.0)
            p, f, q, r = (
                pressure[i, j],
                fraction[i, j],
                edge_pressure[2 + edge],
                edge_fraction[2 + edge],
            )
            p_a, p_b, f_a, f_b = (q, p, r, f) if edge == 0 else (p, q, f, r)
            slopes = _flow_slopes(
                g[i, j],
                g[i, j],
                t[i, j],
                t[i, j],
                u[i, j],
                u[i, j],
                2.0 * dy / dx,
                dy,
                p_a,
                p_b,
                f_a,
                f_b,
            )
            film, velocity = _edge_changes(slopes, by_film, by_velocity, dvelocity_c, 2, i, j)
            centre[0, i, j] += sign * film
            centre[1, i, j] += sign * velocity


@compiled
def linearise(
    film_c,
    film_a,
    by_film,
    by_velocity,
    dvelocity_c,
    dvelocity_a,
    pressure,
    fraction,
    dx,
    dy,
    area_per_step,
    edge_pressure,
    edge_fraction,
    ring,
):
    """Derivative of the cell balance, Eq. (E1), to film thickness and sliding velocity: two
    five-point stencils.

    What is upstream of a face stays so; at rest the cell before the face counts as downstream of
    the one behind it.

    Parameters
    ----------
    film_c, film_a : tuple of ndarray, each shape (n_c, n_a)
        Conductivity [m3/(Pa s)], transported film [m], entrainment velocity [m/s] along i and along
        j.
    by_film, by_velocity : ndarray, shape (4 or more, n_c, n_a)
        Derivatives of stored film, transported film, conductivity along i and along j to film
        thickness and to sliding velocity; the latter of shape (0, n_c, n_a) if all zero.
    dvelocity_c, dvelocity_a : ndarray, shape (n_c, n_a)
        Derivatives of the entrainment velocity along i and along j to the sliding velocity [-].
    pressure, fraction : ndarray, shape (n_c, n_a)
        Pressure above cavitation pressure [Pa], film fraction [-].
    dx, dy, area_per_step, edge_pressure, edge_fraction, ring
        As in `faces` and `assemble`.

    Returns
    -------
    ndarray, shape (2, 5, n_c, n_a)
        To film and to velocity; centre, south, north, west, east as in `assemble`.
    """
    n_c, n_a = pressure.shape
    stencil = np.empty((2, 5, n_c, n_a))
    stencil[:, 1, :, 0] = stencil[:, 2, :, n_a - 1] = 0.0  # no neighbour beyond an edge
    if not ring:
        stencil[:, 3, 0] = stencil[:, 4, n_c - 1] = 0.0
    g, t, u = film_a
    for i in range(n_c):
        for j in range(n_a - 1):
            g_a, g_b, t_a, t_b, v = _flow_slopes(
                g[i, j],
                g[i, j + 1],
                t[i, j],
                t[i, j + 1],
                u[i, j],
                u[i, j + 1],
                dx / dy,
                dx,
                pressure[i, j],
                pressure[i, j + 1],
                fraction[i, j],
                fraction[i, j + 1],
            )
            stencil[0, 1, i, j + 1] = -g_a * by_film[3, i, j] - t_a * by_film[1, i, j]
            stencil[0, 2, i, j] = g_b * by_film[3, i, j + 1] + t_b * by_film[1, i, j + 1]
            stencil[1, 1, i, j + 1] = -v * dvelocity_a[i, j]
            stencil[1, 2, i, j] = v * dvelocity_a[i, j + 1]
            if by_velocity.shape[0] > 0:
                stencil[1, 1, i, j + 1] -= g_a * by_velocity[3, i, j] + t_a * by_velocity[1, i, j]
                stencil[1, 2, i, j] += (
                    g_b * by_velocity[3, i, j + 1] + t_b * by_velocity[1, i, j + 1]
                )
    g, t, u = film_c
    for i in range(n_c if ring else n_c - 1):
        after = (i + 1) % n_c
        for j in range(n_a):
            g_a, g_b, t_a, t_b, v = _flow_slopes(
                g[i, j],
                g[after, j],
                t[i, j],
                t[after, j],
                u[i, j],
                u[after, j],
                dy / dx,
                dy,
                pressure[i, j],
                pressure[after, j],
                fraction[i, j],
                fraction[after, j],
            )
            stencil[0, 3, after, j] = -g_a * by_film[2, i, j] - t_a * by_film[1, i, j]
            stencil[0, 4, i, j] = g_b * by_film[2, after, j] + t_b * by_film[1, after, j]
            stencil[1, 3, after, j] = -v * dvelocity_c[i, j]
            stencil[1, 4, i, j] = v * dvelocity_c[after, j]
            if by_velocity.shape[0] > 0:
                stencil[1, 3, after, j] -= g_a * by_velocity[2, i, j] + t_a * by_velocity[1, i, j]
                stencil[1, 4, i, j] += (
                    g_b * by_velocity[2, after, j] + t_b * by_velocity[1, after, j]
                )
    for k in range(2):
        for i in range(n_c):
            before, after = (i - 1) % n_c, (i + 1) % n_c
            for j in range(n_a):  # what a cell loses its neighbours win
                stencil[k, 0, i, j] = -(stencil[k, 3, after, j] + stencil[k, 4, before, j])
            for j in range(n_a - 1):
                stencil[k, 0, i, j] -= stencil[k, 1, i, j + 1]
            for j in range(1, n_a):
                stencil[k, 0, i, j] -= stencil[k, 2, i, j - 1]
    _edge_slopes(
        film_c,
        film_a,
        by_film,
        by_velocity,
        dvelocity_c,
        dvelocity_a,
        pressure,
        fraction,
        dx,
        dy,
        edge_pressure,
        edge_fraction,
        ring,
        stencil[:, 0],
    )
    for i in range(n_c):
        for j in range(n_a):
            stencil[0, 0, i, j] += area_per_step * fraction[i, j] * by_film[0, i, j]
            if by_velocity.shape[0] > 0:
                stencil[1, 0, i, j] += area_per_step * fraction[i, j] * by_velocity[0, i, j]
    return stencil


@compiled
def apply_stencils(stencil, dfilm, dvelocity, out):
    """Right-hand sides of Eq. (E6) for changes of film and sliding velocity.

    Parameters
    ----------
    stencil : ndarray, shape (2, 5, n_c, n_a)
        From `linearise`.
    dfilm, dvelocity : ndarray, shape (m, n_c, n_a)
        [m], [m/s].
    out : ndarray, shape (m, n_c, n_a)
        Overwritten [m3/s].
    """
    m, n_c, n_a = dfilm.shape
    row = np.empty(n_a)
    for q in range(m):
        for i in range(n_c):
            before, after = (i - 1) % n_c, (i + 1) % n_c
            for j in range(n_a):
                row[j] = (
                    stencil[0, 0, i, j] * dfilm[q, i, j]
                    + stencil[0, 3, i, j] * dfilm[q, before, j]
                    + stencil[0, 4, i, j] * dfilm[q, after, j]
                )
            for j in range(n_a):
                row[j] += (
                    stencil[1, 0, i, j] * dvelocity[q, i, j]
                    + stencil[1, 3, i, j] * dvelocity[q, before, j]
                    + stencil[1, 4, i, j] * dvelocity[q, after, j]
                )
            for j in range(1, n_a):
                row[j] += (
                    stencil[0, 1, i, j] * dfilm[q, i, j - 1]
                    + stencil[1, 1, i, j] * dvelocity[q, i, j - 1]
                )
            for j in range(n_a - 1):
                row[j] += (
                    stencil[0, 2, i, j] * dfilm[q, i, j + 1]
                    + stencil[1, 2, i, j] * dvelocity[q, i, j + 1]
                )
            for j in range(n_a):
                out[q, i, j] = -row[j]
