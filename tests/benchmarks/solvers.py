"""How do other solvers do on the same right-hand side? scipy's with Python's rate, SUNDIALS' CVode with the compiled one."""

from __future__ import annotations

import ctypes as ct
from collections.abc import Callable, Iterator

import fmpy.sundials as sun
import numpy as np
from cases import Case
from evat.model import FloatArray
from fmpy.sundials.libraries import sundials_nvecserial
from scipy.integrate import odeint, solve_ivp

MOST_STEPS = 1_000_000
# z at the checks of each span, for the error; or with dense=False at the ends only, for the time.
Solve = Callable[[Case, float, bool], list[FloatArray]]


def _outputs(case: Case, dense: bool) -> Iterator[tuple[tuple[float, float], FloatArray]]:
    for span in case.spans:
        yield span, case.checks(span) if dense else np.array([span[1]])


def lsoda(case: Case, tolerance: float, dense: bool) -> list[FloatArray]:
    """scipy.integrate.solve_ivp, method LSODA: today's interface."""
    rate, atol = case.rate(), tolerance * case.scale
    return [
        solve_ivp(rate, span, [0.0], "LSODA", t_eval=out if dense else None, rtol=tolerance, atol=atol).y[0]
        for span, out in _outputs(case, dense)
    ]


def odeint_lsoda(case: Case, tolerance: float, dense: bool) -> list[FloatArray]:
    """scipy.integrate.odeint: the same LSODA in its older interface, whose loop is compiled."""
    rate, atol, found = case.rate(), tolerance * case.scale, []
    for span, out in _outputs(case, dense):
        times = np.concatenate([span[:1], out])
        found.append(odeint(rate, [0.0], times, rtol=tolerance, atol=atol, mxstep=MOST_STEPS, tfirst=True)[1:, 0])
    return found


def radau(case: Case, tolerance: float, dense: bool) -> list[FloatArray]:
    """scipy.integrate.solve_ivp, method Radau."""
    rate, atol = case.rate(), tolerance * case.scale
    return [
        solve_ivp(rate, span, [0.0], "Radau", t_eval=out if dense else None, rtol=tolerance, atol=atol).y[0]
        for span, out in _outputs(case, dense)
    ]


class CompiledCVode:
    """CVode of SUNDIALS, which fmpy brings, on the rate in loops.c: no Python runs while it steps."""

    def __init__(self, loops: ct.CDLL) -> None:
        self._rate = ct.cast(loops.rate, sun.CVRhsFn)
        self._data = ct.cast(sundials_nvecserial.N_VGetArrayPointer_Serial, ct.c_void_p)

    def __call__(self, case: Case, tolerance: float, dense: bool) -> list[FloatArray]:
        law, context, found = case.in_c(), sun.SUNContext(), []
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
            row, reached = np.empty(out.size), sun.realtype()
            for place, t in enumerate(out):
                self._check(sun.CVode(memory, t, z, ct.byref(reached), sun.CV_NORMAL))
                row[place] = at[0]
            found.append(row)
            sun.CVodeFree(ct.byref(ct.c_void_p(memory)))
        return found

    @staticmethod
    def _check(status: int) -> None:
        if status < 0:
            raise RuntimeError(f"CVode answered {status}.")


def _user_data(memory: int, law: object) -> int:
    function = sun.libraries.sundials_cvode.CVodeSetUserData
    function.argtypes, function.restype = [ct.c_void_p, ct.c_void_p], ct.c_int
    return int(function(memory, law))


def loosest(solve: Callable[[float], list[FloatArray]], case: Case, error: float) -> float | None:
    """The loosest tolerance, of four a decade, at which the error is reached; None where 1e-11 is not enough."""
    for quarter in range(4, 45):
        tolerance = 10 ** (-quarter / 4)
        if case.error(solve(tolerance)) <= error:
            return tolerance
    return None
