"""How do other solvers do on the same right-hand side? scipy's with Python's rate, SUNDIALS' CVode with the compiled one.

All are held to the kernel's own longest step, a twentieth of a cycle: without it the multistep methods, in stiff sliding, leap over whole
reversals at any tolerance (z of the wrong sign, on the sinusoid of regularised/copper).
"""

from __future__ import annotations

import ctypes as ct
from collections.abc import Callable, Iterator
from typing import Protocol

import fmpy.sundials as sun
import numpy as np
from cases import PERIOD, Case
from evat.model import FloatArray
from fmpy.sundials.libraries import sundials_nvecserial
from scipy.integrate import odeint, solve_ivp

MOST_STEPS = 1_000_000
LONGEST = PERIOD / 20  # s


class Solve(Protocol):
    """A solver at a tolerance: z at the checks of each span, for the error; or with dense=False at its end only, for the time."""

    def __call__(self, case: Case, tolerance: float, dense: bool) -> list[FloatArray]: ...


def _outputs(case: Case, dense: bool) -> Iterator[tuple[tuple[float, float], FloatArray]]:
    for span in case.spans:
        yield span, case.checks(span) if dense else np.array([span[1]])


def _ivp(method: str, case: Case, tolerance: float, dense: bool) -> list[FloatArray]:
    options = {"rtol": tolerance, "atol": tolerance * case.scale, "max_step": LONGEST}
    rate = case.rate()
    return [solve_ivp(rate, span, [0.0], method, t_eval=out if dense else None, **options).y[0] for span, out in _outputs(case, dense)]


def lsoda(case: Case, tolerance: float, dense: bool) -> list[FloatArray]:
    """scipy.integrate.solve_ivp, method LSODA: today's interface."""
    return _ivp("LSODA", case, tolerance, dense)


def radau(case: Case, tolerance: float, dense: bool) -> list[FloatArray]:
    """scipy.integrate.solve_ivp, method Radau."""
    return _ivp("Radau", case, tolerance, dense)


def odeint_lsoda(case: Case, tolerance: float, dense: bool) -> list[FloatArray]:
    """scipy.integrate.odeint: the same LSODA in its older interface, whose loop is compiled."""
    rate, atol, rows = case.rate(), tolerance * case.scale, []
    for span, out in _outputs(case, dense):
        times = np.concatenate([span[:1], out])
        rows.append(odeint(rate, [0.0], times, rtol=tolerance, atol=atol, mxstep=MOST_STEPS, hmax=LONGEST, tfirst=True)[1:, 0])
    return rows


class CompiledCVode:
    """CVode of SUNDIALS, which fmpy brings, on the rate in loops.c: no Python runs while it steps."""

    def __init__(self, loops: ct.CDLL) -> None:
        self._rate = ct.cast(loops.rate, sun.CVRhsFn)
        self._data = ct.cast(sundials_nvecserial.N_VGetArrayPointer_Serial, ct.c_void_p)

    def __call__(self, case: Case, tolerance: float, dense: bool) -> list[FloatArray]:
        law, context, rows = case.in_c(), sun.SUNContext(), []
        law.data = self._data
        self._check(sun.SUNContext_Create(sun.SUN_COMM_NULL, ct.byref(context)))
        for (begin, _), out in _outputs(case, dense):
            z, atol = sun.N_VNew_Serial(1, context), sun.N_VNew_Serial(1, context)
            at, scale = sun.NV_DATA_S(z), sun.NV_DATA_S(atol)
            at[0], scale[0] = 0.0, tolerance * case.scale
            memory = sun.CVodeCreate(sun.CV_BDF, context)
            self._check(sun.CVodeInit(memory, self._rate, begin, z))
            self._check(_user_data(memory, ct.byref(law)))
            self._check(sun.CVodeSVtolerances(memory, tolerance, atol))
            matrix = sun.SUNDenseMatrix(1, 1, context)
            solver = sun.SUNLinSol_Dense(z, matrix, context)
            self._check(sun.CVodeSetLinearSolver(memory, solver, matrix))
            self._check(sun.CVodeSetMaxNumSteps(memory, MOST_STEPS))
            self._check(sun.CVodeSetMaxStep(memory, LONGEST))
            row, reached = np.empty(out.size), sun.realtype()
            for place, t in enumerate(out):
                self._check(sun.CVode(memory, t, z, ct.byref(reached), sun.CV_NORMAL))
                row[place] = at[0]
            rows.append(row)
            sun.CVodeFree(ct.byref(ct.c_void_p(memory)))
        return rows

    @staticmethod
    def _check(status: int) -> None:
        if status < 0:
            raise RuntimeError(f"CVode answered {status}.")


def _user_data(memory: int, law: object) -> int:
    function = sun.libraries.sundials_cvode.CVodeSetUserData
    function.argtypes, function.restype = [ct.c_void_p, ct.c_void_p], ct.c_int
    return int(function(memory, law))


def loosest(error_of: Callable[[float], float], error: float, *, a_decade: int = 4) -> float | None:
    """The loosest tolerance, of so many a decade, at which the error is reached and not by luck: the two next tighter ones reach it too.

    None where 1e-11 is not enough.
    """
    reached: list[float] = []
    for step in range(a_decade, 11 * a_decade + 1):
        tolerance = 10 ** (-step / a_decade)
        reached = [*reached, tolerance] if error_of(tolerance) <= error else []
        if len(reached) == 3:
            return reached[0]
    return None
