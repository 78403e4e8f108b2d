"""Does the FMU follow a measured motion, and does a bad record get a clear answer?"""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from evat import parameter_sets
from evat.files.text import RecordError
from evat.model import ParameterError
from evat.native import kernel
from evat.studies.record import Columns, follow_record, read_record, velocity_from_position
from scipy.optimize import least_squares

DATA = Path(__file__).resolve().parents[3] / "shared" / "data" / "tribometer_5N_hysteresis" / "test_data_2.txt"
COLUMNS = Columns(time="Time [s]", force="Friction [uN]", position="Position [mm]", force_sign=-1)
FITTED = (17.0, 57.0)
needs_data = pytest.mark.skipif(not DATA.is_file(), reason="the tribometer record is not beside this checkout (../shared/data)")


@needs_data
def test_the_fmu_leaves_what_an_independent_study_leaves(fmi2_fmu: Path) -> None:
    """LuGre leaves 11 to 12 % of the force (an independent study with more parameters: 11.4 %), the shipped two-parameter set 12.2 %."""
    parameter_set = parameter_sets.load("tribometer-5n")
    result = follow_record(fmi2_fmu, DATA, COLUMNS, kernel.by_choice(parameter_set.values), parameter_set.effects, between=FITTED)
    assert result.residual_share == pytest.approx(0.1223, abs=0.002)
    assert result.residual_rms == pytest.approx(0.259, abs=0.005)
    assert result.times.size == pytest.approx(40 * 200, abs=60)  # 200 Hz, one sample missing here and there


@needs_data
def test_the_shipped_values_are_the_least_squares_fit() -> None:
    """The set's two numbers come back from the record within the digits that it states."""
    times, velocity, measured = read_record(DATA, COLUMNS, FITTED)
    parameter_set = parameter_sets.load("tribometer-5n")

    def residual(scaled: np.ndarray) -> np.ndarray:
        level = 2.69 * float(scaled[1])
        values = {**parameter_set.values, "kinematics": "external", "sigma0": 3.63e4 * float(scaled[0]), "F_C": level, "F_S": level}
        contact = kernel.Contact({**values, "slip_velocity": float(velocity[0])})
        contact.start(float(times[0]))
        return contact.run(times, {"slip_velocity": velocity}, ["friction_force"])[:, 0] - measured

    fit = least_squares(residual, [0.7, 1.2], diff_step=1e-4)
    assert fit.x == pytest.approx([1, 1], abs=2e-3)


def test_velocity_of_a_parabola_is_exact_inside() -> None:
    """Central slopes over a symmetric window are exact for constant acceleration, also with a sample missing elsewhere."""
    times = np.delete(np.arange(0, 1, 0.005), 60)
    velocity = velocity_from_position(times, 3 * times**2)
    inside = np.r_[2:57, 65 : times.size - 2]
    assert velocity[inside] == pytest.approx(6 * times[inside], rel=1e-9)


def write(path: Path, text: str) -> Path:
    path.write_text(text, encoding="utf-8")
    return path


@pytest.mark.parametrize(
    ("text", "what"),
    [
        ("t [s],x [mm],F [N]\n0,0,1\n1,nan,1\n2,0,1\n3,0,1\n4,0,1\n", "data row 2"),
        ("t [s],x [mm],F [N]\n0,0,1\n2,0,1\n1,0,1\n3,0,1\n4,0,1\n", "increase"),
        ("t [s],x [kg],F [N]\n0,0,1\n1,0,1\n2,0,1\n3,0,1\n4,0,1\n", "kg"),
        ("t [s],y [mm],F [N]\n0,0,1\n1,0,1\n2,0,1\n3,0,1\n4,0,1\n", "no column 'x"),
        ("t [s],x [mm],F [N]\n0,0,1\n1,0,1\n", "at least 5"),
        ("", "numbers"),
    ],
)
def test_a_bad_record_is_named(tmp_path: Path, text: str, what: str) -> None:
    path = write(tmp_path / "bad.csv", text)
    header = "x [kg]" if "kg" in text else "x [mm]"
    with pytest.raises(RecordError, match=what) as caught:
        read_record(path, Columns("t [s]", "F [N]", position=header))
    assert "bad.csv" in str(caught.value) or "samples" in str(caught.value)


def test_no_motion_column_is_named(tmp_path: Path) -> None:
    path = write(tmp_path / "still.csv", "t [s],F [N]\n0,1\n1,1\n")
    with pytest.raises(ParameterError, match="velocity or of the position"):
        read_record(path, Columns("t [s]", "F [N]"))
