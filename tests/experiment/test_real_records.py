"""What do the effects leave of two measured records, and is it what others have published? A tribometer and a positioning drive.

The fits run here, through the component, in a second each; the frozen values beside them are what they end on from either start.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path

import numpy as np
import pytest
from evat.native.kernel import Contact
from evat.studies.record import Columns, read_record
from scipy.io import loadmat
from scipy.optimize import least_squares
from scipy.signal import butter, decimate, filtfilt

DATA = Path(__file__).resolve().parents[3] / "shared" / "data"
TRIBOMETER = DATA / "tribometer_5N_hysteresis" / "test_data_2.txt"
EMPS = DATA / "emps" / "DATA_EMPS.mat"
needs_tribometer = pytest.mark.skipif(not TRIBOMETER.is_file(), reason="the tribometer record is not beside this checkout (../shared/data)")
needs_emps = pytest.mark.skipif(not EMPS.is_file(), reason="the EMPS record is not beside this checkout (../shared/data)")

Force = Callable[[Mapping[str, float]], np.ndarray]


def friction_along(times: np.ndarray, velocity: np.ndarray, on: Sequence[str]) -> Force:
    """Measured friction force for values of LuGre with one force level, no bristle damping."""

    def force(values: Mapping[str, float]) -> np.ndarray:
        fixed: dict[str, float | str] = {"kinematics": "external", "friction_law": "lugre", "sigma1": 0.0, "relative_tolerance": 1e-5}
        contact = Contact({**fixed, **values, "F_S": values["F_C"], "slip_velocity": float(velocity[0])}, on)
        contact.start(float(times[0]))
        friction: np.ndarray = contact.run(times, {"slip_velocity": velocity}, ["measured_friction_force"])[:, 0]
        return friction

    return force


def fitted(residual: Callable[[Mapping[str, float]], np.ndarray], start: Mapping[str, float]) -> dict[str, float]:
    """Least squares over the named values, each in units of its start."""
    names, scale = list(start), np.array(list(start.values()))
    solution = least_squares(lambda share: residual(dict(zip(names, share * scale, strict=True))), np.ones(len(names)), diff_step=1e-4)
    return dict(zip(names, (solution.x * scale).tolist(), strict=True))


def share_of(residual: np.ndarray, whole: np.ndarray) -> float:
    return float(np.linalg.norm(residual) / np.linalg.norm(whole))


# Tribometer: 5 N, strokes of 0.23 mm to and fro, 17 to 57 s. An independent study left 11.4 % with LuGre and 5.4 % with an elasto-plastic
# stop. Both come back here, by two parameters each, once the zero of the force is free: it is off by 0.096 N, 4.5 % of the force, which no
# friction law that is odd in the slip can take up. Without that, 12.2 % and 7.0 % are left.

ZERO, GATE, LEAN, BREAK_AWAY = "sensor_offset.friction_force", "elasto_plastic", "direction_asymmetry.a", "elasto_plastic.break_away"
SHARP = {BREAK_AWAY: 0.99}  # a stop: a spring up to the friction force, and no further

frozen_lugre = {"sigma0": 3.6279e4, "F_C": 2.6894}
frozen_lugre_zeroed = {"sigma0": 3.6360e4, "F_C": 2.6862, ZERO: 0.09645}
frozen_stop_zeroed = {"sigma0": 4.0306e4, "F_C": 2.3337, ZERO: 0.09497}
frozen_gate = {"sigma0": 4.0826e4, "F_C": 2.3642, BREAK_AWAY: 0.6633}
frozen_gate_zeroed = {"sigma0": 4.0884e4, "F_C": 2.3635, BREAK_AWAY: 0.6643, ZERO: 0.09500}
frozen_gate_leaning = {"sigma0": 4.0949e4, "F_C": 2.3664, BREAK_AWAY: 0.6451, LEAN: 0.04301}

OFFSET = ("sensor_offset",)
TRIBOMETER_FITS = {
    "LuGre": ((), frozen_lugre, {}, 0.1223),
    "LuGre, zero free": (OFFSET, frozen_lugre_zeroed, {}, 0.1135),
    "stop, zero free": ((GATE, *OFFSET), frozen_stop_zeroed, SHARP, 0.0543),
    "gate": ((GATE,), frozen_gate, {}, 0.0680),
    "gate, zero free": ((GATE, *OFFSET), frozen_gate_zeroed, {}, 0.0511),
    "gate, leaning": ((GATE, "direction_asymmetry"), frozen_gate_leaning, {}, 0.0496),
}
INDEPENDENT = {"LuGre, zero free": 0.114, "stop, zero free": 0.054}


@pytest.fixture(scope="module")
def tribometer() -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Times, slip velocity, friction force."""
    columns = Columns(time="Time [s]", force="Friction [uN]", position="Position [mm]", force_sign=-1)
    return read_record(TRIBOMETER, columns, (17.0, 57.0))


@needs_tribometer
@pytest.mark.parametrize("name", TRIBOMETER_FITS)
def test_the_tribometer_record_is_left_with_what_was_found(name: str, tribometer: tuple[np.ndarray, np.ndarray, np.ndarray]) -> None:
    """From a start that is 25 % off in everything. A sharp gate makes the sum of squares rough: a ten thousandth of the force."""
    times, velocity, measured = tribometer
    on, frozen, fixed, left = TRIBOMETER_FITS[name]
    force = friction_along(times, velocity, on)
    best = fitted(lambda values: force({**values, **fixed, "sigma2": 0.0}) - measured, {key: 0.75 * value for key, value in frozen.items()})
    residual = {
        key: share_of(force({**values, **fixed, "sigma2": 0.0}) - measured, measured) for key, values in (("fit", best), ("frozen", frozen))
    }
    assert residual["fit"] == pytest.approx(left, abs=2e-4)
    assert residual["fit"] == pytest.approx(INDEPENDENT.get(name, left), abs=6e-4)  # its last digit
    assert residual["frozen"] == pytest.approx(residual["fit"], abs=1e-4)
    assert best == pytest.approx(frozen, rel=2e-2)  # the least known, the shape of the gate


@needs_tribometer
def test_the_force_of_the_tribometer_has_no_zero_of_its_own(tribometer: tuple[np.ndarray, np.ndarray, np.ndarray]) -> None:
    """Whole cycles of a motion that is its own mirror image: the mean force is the offset that the fits find, within a tenth."""
    times, velocity, measured = tribometer
    cycles = (times >= 17.0) & (times < 17.0 + 4 * 9)  # nine of 4 s
    assert abs(velocity[cycles].mean()) < 1e-2 * np.abs(velocity).mean()
    assert measured[cycles].mean() == pytest.approx(frozen_gate_zeroed[ZERO], rel=0.1)


# EMPS: a drive on one axis, M q'' + friction = gain * voltage. Published (Janot, Gautier and Brunot 2019): M 95.11 kg, viscous 203.5 N s/m,
# Coulomb 20.39 N, offset -3.16 N, 4.08 % of the force left; 3.11 % with friction that differs between the two ways. As in the scripts that
# come with the record the position goes forth and back through a Butterworth filter of order 4 at 100 Hz. How far the record is thinned
# before the comparison is not told, and matters: unthinned 4.4 % and 3.6 % are left, of every 25th sample 3.5 % and 2.3 %. Every 10th
# leaves 4.02 % and 3.04 %, and nothing that was tried (ends, filters, order of thinning and sign) left the printed digits and parameters.

frozen_drive = {"M": 95.23, "sigma2": 203.58, "F_C": 20.377, ZERO: -3.190}
frozen_drive_leaning = {"M": 95.27, "sigma2": 203.76, "F_C": 20.356, LEAN: -0.0125, "direction_asymmetry.a_viscous": -0.1802}
BRISTLES = 1e7  # N/m: a break-away way of 2 um, at 20 um a sample as good as a jump; the fit with it free ends on 0.8e7


class Drive:
    """The record, and what a set of values leaves of its force."""

    def __init__(self) -> None:
        record = loadmat(EMPS)
        force = record["vir"].ravel() * record["gtau"].item()
        position = filtfilt(*butter(4, 100, fs=1000), record["qm"].ravel())
        self.times = np.arange(force.size) / 1000
        self.velocity = np.gradient(position, 1e-3)
        self.acceleration = np.gradient(self.velocity, 1e-3)
        self.force = self.thinned(force)

    @staticmethod
    def thinned(signal: np.ndarray) -> np.ndarray:
        samples: np.ndarray = decimate(signal, 10)[25:-25]  # the filters' ends off
        return samples

    def residual(self, on: Sequence[str]) -> Force:
        friction = friction_along(self.times, self.velocity, on)

        def left(values: Mapping[str, float]) -> np.ndarray:
            own = {name: value for name, value in values.items() if name != "M"}
            model: np.ndarray = values["M"] * self.acceleration + friction({"sigma0": BRISTLES, **own})
            missing: np.ndarray = self.thinned(model) - self.force
            return missing

        return left

    def by_signs(self, *friction: np.ndarray) -> float:
        """Share that is left where friction is a sum of columns: the published way, linear least squares."""
        columns = np.column_stack([self.thinned(column) for column in (self.acceleration, *friction)])
        return share_of(columns @ np.linalg.lstsq(columns, self.force, rcond=None)[0] - self.force, self.force)


@pytest.fixture(scope="module")
def drive() -> Drive:
    return Drive()


@needs_emps
def test_the_published_identification_of_the_drive_comes_back(drive: Drive) -> None:
    """With sgn(q') as published, within 2 % of the printed 4.08 % and 3.11 %: 4.02 % and 3.04 %."""
    v, ahead, back = drive.velocity, drive.velocity > 0, drive.velocity < 0
    assert drive.by_signs(v, np.sign(v), np.ones_like(v)) == pytest.approx(0.0408, rel=0.02)
    assert drive.by_signs(v * ahead, v * back, 1.0 * ahead, 1.0 * back) == pytest.approx(0.0311, rel=0.025)


@needs_emps
@pytest.mark.parametrize(
    ("on", "frozen", "left"),
    [(OFFSET, frozen_drive, 0.0394), (("direction_asymmetry",), frozen_drive_leaning, 0.0294)],
    ids=["symmetric", "leaning"],
)
def test_the_contact_follows_the_drive_a_little_better(on: tuple[str, ...], frozen: dict[str, float], left: float, drive: Drive) -> None:
    """The same, with the contact's friction for sgn(q'): each is a tenth of a per cent lower, since bristles do not jump at the turns. From
    a start 20 % off."""
    residual = drive.residual(on)
    best = fitted(residual, {key: 0.8 * value for key, value in frozen.items()})
    assert share_of(residual(best), drive.force) == pytest.approx(left, abs=1e-4)
    assert share_of(residual(frozen), drive.force) == pytest.approx(left, abs=1e-4)
    assert best == pytest.approx(frozen, rel=1e-2)
    assert best["M"] == pytest.approx(95.1089, rel=3e-3)  # the published values
    assert best["sigma2"] == pytest.approx(203.5034, rel=3e-3)
    assert best["F_C"] == pytest.approx(20.3935, rel=3e-3)


@needs_emps
def test_the_drive_leans_in_its_viscous_friction(drive: Drive) -> None:
    """Where it slides, a share a of the Coulomb force and an offset are one and the same: alone, a finds the published -3.16 N again and
    leaves as much as an offset does. What is gained beyond it is viscous: 18 % less ahead, 18 % more back, and then hardly any a."""
    residual = drive.residual(("direction_asymmetry",))
    alone = fitted(residual, {**{key: frozen_drive[key] for key in ("M", "sigma2", "F_C")}, LEAN: -0.1})
    assert alone[LEAN] * alone["F_C"] == pytest.approx(-3.1648, rel=0.02)
    assert share_of(residual(alone), drive.force) == pytest.approx(0.0394, abs=2e-4)
    assert abs(frozen_drive_leaning[LEAN] * frozen_drive_leaning["F_C"]) < 0.1 * 3.1648
