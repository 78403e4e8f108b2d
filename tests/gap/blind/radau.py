"""How do the bristles of the benchmark's contact move? Radau IIA of order 3 over a fixed fine grid, the whole record at once.

The bristle equation dz/dt = v - a z is linear, so a step is an affine map of z, and a record is a chain of them. The two-stage Radau IIA
method (Hairer and Wanner 1996, IV.8) damps the stiff part at high slip speed. Laws that are not linear in z go to scipy's LSODA or to the
classical Runge-Kutta method, one step after the other.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[np.float64]

NODES = (1 / 3, 1.0)


def affine_steps(width: Array, rate: Array, drive: Array) -> tuple[Array, Array, Array, Array]:
    """z at both nodes as factor * z(start) + shift: factor and shift at node 1, then at node 2. rate, drive: shape (steps, 2)."""
    h, a_1, a_2, u_1, u_2 = width, rate[:, 0], rate[:, 1], drive[:, 0], drive[:, 1]
    m_11, m_12, m_21, m_22 = 1 + 5 / 12 * h * a_1, -h * a_2 / 12, 0.75 * h * a_1, 1 + 0.25 * h * a_2
    r_1, r_2 = h * (5 / 12 * u_1 - u_2 / 12), h * (0.75 * u_1 + 0.25 * u_2)
    determinant = m_11 * m_22 - m_12 * m_21
    factor = ((m_22 - m_12) / determinant, (m_11 - m_21) / determinant)
    shift = ((m_22 * r_1 - m_12 * r_2) / determinant, (m_11 * r_2 - m_21 * r_1) / determinant)
    return factor[0], shift[0], factor[1], shift[1]


def chain(factor: Array, shift: Array, first: float = 0.0) -> Array:
    """z after each of the steps z -> factor z + shift, from `first`: blocks side by side, then joined."""
    count = factor.size
    length = max(1, int(np.sqrt(count)))
    blocks = -(-count // length)
    rest = blocks * length - count
    A = np.append(factor, np.ones(rest)).reshape(blocks, length).T.copy()  # a step of all blocks lies side by side
    B = np.append(shift, np.zeros(rest)).reshape(blocks, length).T.copy()
    for n in range(1, length):
        B[n] += A[n] * B[n - 1]
        A[n] *= A[n - 1]
    at_start = np.empty(blocks)
    z = first
    for k, (a, b) in enumerate(zip(A[-1].tolist(), B[-1].tolist(), strict=True)):
        at_start[k] = z
        z = a * z + b
    return (A * at_start + B).T.ravel()[:count]


def linear(width: Array, rate: Array, drive: Array, fresh: npt.NDArray[np.bool_], held: npt.NDArray[np.bool_]) -> Array:
    """z at both nodes of each step. fresh: the step begins with z = 0; held: out of contact at its end, z = 0 there."""
    f_1, s_1, f_2, s_2 = affine_steps(width, rate, drive)
    lost = held | fresh
    z_2 = chain(np.where(lost, 0.0, f_2), np.where(held, 0.0, s_2))
    before = np.concatenate([[0.0], z_2[:-1]])
    before[fresh] = 0.0
    z_1 = np.where(held, 0.0, f_1 * before + s_1)
    return np.stack([z_1, z_2], axis=1)


def marched(
    width: Sequence[float],
    fresh: Sequence[bool],
    held: Sequence[bool],
    rate: Callable[[int, float, float], float],
    most: Sequence[float],
) -> Array:
    """z at the end of each step for dz/dt = rate(step, share of the step, z), by the classical Runge-Kutta method.

    most[k] bounds |d rate/dz| in step k; steps are cut so that the method is stable and accurate there.
    """
    z, states = 0.0, np.zeros(len(width))
    for k, h in enumerate(width):
        if fresh[k]:
            z = 0.0
        if held[k]:
            z = 0.0
            continue
        parts = int(h * most[k] / 0.6) + 1
        d, share = h / parts, 1.0 / parts
        for n in range(parts):
            s = n * share
            k_1 = rate(k, s, z)
            k_2 = rate(k, s + 0.5 * share, z + 0.5 * d * k_1)
            k_3 = rate(k, s + 0.5 * share, z + 0.5 * d * k_2)
            k_4 = rate(k, s + share, z + d * k_3)
            z += d / 6 * (k_1 + 2 * k_2 + 2 * k_3 + k_4)
        states[k] = z
    return states


def settle(width: Array, rate: Array, drive: Array, first: float) -> Array:
    """y at both nodes for dy/dt = drive - rate y from `first`; no contact is lost."""
    f_1, s_1, f_2, s_2 = affine_steps(width, rate, drive)
    y_2 = chain(f_2, s_2, first)
    before = np.concatenate([[first], y_2[:-1]])
    return np.stack([f_1 * before + s_1, y_2], axis=1)
