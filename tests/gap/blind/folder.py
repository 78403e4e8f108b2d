"""How does a case reach the disk? As an experiment's folder, in units and headers as people use them; nothing of its truth in it."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.csv as pc
import pyarrow.parquet as pq
from radau import Array
from rigs import Setup
from world import Channels

Draw = np.random.Generator

# variable: ((header, unit, factor from SI, offset), ...)
HEADERS: dict[str, tuple[tuple[str, str, float, float], ...]] = {
    "time": (("t [s]", "s", 1.0, 0.0), ("time", "s", 1.0, 0.0), ("t_us", "us", 1e6, 0.0), ("Time (ms)", "ms", 1e3, 0.0)),
    "slip_velocity": (("v", "mm/s", 1e3, 0.0), ("slip [m/s]", "m/s", 1.0, 0.0), ("vel", "m/min", 60.0, 0.0)),
    "proxy_speed": (("theta", "m/s", 1.0, 0.0), ("Theta_eq", "m/min", 60.0, 0.0)),
    "contact_temperature": (("T_c", "degC", 1.0, -273.15), ("temp [K]", "K", 1.0, 0.0)),
    "uncut_thickness": (("h [um]", "um", 1e6, 0.0), ("h", "mm", 1e3, 0.0)),
    "normal_load": (("Fn", "N", 1.0, 0.0), ("N [kN]", "kN", 1e-3, 0.0)),
    "friction_force": (("F", "N", 1.0, 0.0), ("F_t [mN]", "mN", 1e3, 0.0), ("friction", "kN", 1e-3, 0.0)),
    "principal_force": (("Fp", "N", 1.0, 0.0), ("Fx [kN]", "kN", 1e-3, 0.0)),
    "feed_force": (("Ff", "N", 1.0, 0.0), ("Fy [kN]", "kN", 1e-3, 0.0)),
}


def number(value: float) -> str:
    """Ten digits, a float to TOML."""
    text = f"{value:.10g}"
    return text if any(mark in text for mark in ".en") else text + ".0"


def _value(value: float | str) -> str:
    return f'"{value}"' if isinstance(value, str) else number(value)


def _table(name: str, values: Mapping[str, float | str]) -> list[str]:
    def key(text: str) -> str:
        return f'"{text}"' if "." in text else text

    return [f"[{name}]", *(f"{key(k)} = {_value(v)}" for k, v in values.items()), ""]


def write(folder: Path, title: str, setup: Setup, nominal: Mapping[str, float], trials: list[tuple[str, int, Channels]], rng: Draw) -> None:
    """trials: name of the condition, its place among the scenes, and the recorded channels; or for means one entry per condition, with
    standard deviations under `<channel>_sd`."""
    world = setup.world
    folder.mkdir(parents=True)
    lines = ["format = 1", f'title = "{title}"', "", "[nominal]", 'friction = "lugre"']
    lines += [f'kinematics = "{"internal" if world.kind in ("ellipse", "means") else "external"}"']
    lines += [f"effects = [{', '.join(f'{chr(34)}{name}{chr(34)}' for name in world.nominal_effects)}]"]
    lines += _table("nominal.values", {**nominal, **setup.exact})
    exact = {name: 0.0 for name, value in setup.exact.items() if not isinstance(value, str)}
    lines += _table("nominal.relative_sd", {**setup.relative_sd, **exact})
    for channel in world.channels:  # these rigs differ from trial to trial, and have no error that all trials share
        lines += _table(f"setup_sd.{channel}", dict.fromkeys(("gain", "zero", "clock"), 0.0))
    if world.means:
        lines += _means(folder, world.channels, setup, trials)
    else:
        lines += _trials(folder, setup, trials, rng)
    (folder / "experiment.toml").write_text("\n".join(lines).rstrip() + "\n", encoding="utf-8")


def _trials(folder: Path, setup: Setup, trials: list[tuple[str, int, Channels]], rng: Draw) -> list[str]:
    world, lines = setup.world, []
    names = ["time", *setup.inputs, *world.channels]
    chosen = {name: HEADERS[name][int(rng.integers(len(HEADERS[name])))] for name in names}
    for name in names:
        header, unit, _, _ = chosen[name]
        lines += [f"[signals.{name}]", f'column = "{header}"', f'unit = "{unit}"']
        if name != "time":
            lines.append(f'role = "{"input" if name in setup.inputs else "output"}"')
        lines.append("")
    suffix, sub = (".parquet" if rng.random() < 0.3 else ".csv"), ("trials/" if rng.random() < 0.7 else "")
    (folder / sub).mkdir(exist_ok=True)
    blur = float(rng.uniform(2e-4, 5e-4)) if rng.random() < 0.25 else 0.0
    seen: dict[str, int] = {}
    for condition, place, recorded in trials:
        scene = world.scenes[place]
        repeat = seen[condition] = seen.get(condition, -1) + 1
        columns: dict[str, Array] = {"time": scene.times}
        for name in setup.inputs:
            clean = scene.signals[name](scene.times)
            columns[name] = clean + blur * float(np.std(clean)) * rng.standard_normal(clean.size)
            if name in ("proxy_speed", "normal_load"):
                columns[name] = np.maximum(columns[name], 0.0)
        columns |= recorded
        table = {}
        for name in names:
            header, _, factor, offset = chosen[name]
            table[header] = columns[name] * factor + offset
        file = f"{sub}{condition}_{'abcdefgh'[repeat]}{suffix}"
        save(folder / file, table)
        lines += ["[[trials]]", f'file = "{file}"', f'condition = "{condition}"']
        if setup.per_trial:
            values = ", ".join(f"{name} = {number(scene.values[name])}" for name in setup.per_trial)
            lines.append(f"values = {{ {values} }}")
        lines.append("")
    return lines


def _means(folder: Path, channels: tuple[str, ...], setup: Setup, trials: list[tuple[str, int, Channels]]) -> list[str]:
    scenes = [setup.world.scenes[place] for _, place, _ in trials]
    table = {name: np.array([scene.values[name] for scene in scenes]) for name in setup.per_trial}
    for channel in channels:
        for name in (channel, channel + "_sd"):
            table[name] = np.array([float(recorded[name][0]) for _, _, recorded in trials])
    save(folder / "means.csv", table)
    return ["[means]", 'file = "means.csv"', ""]


def save(path: Path, table: Mapping[str, Array]) -> None:
    """Nine digits; CSV or Parquet by the name."""
    rounded = {name: np.array([float(f"{value:.9g}") for value in column.tolist()]) for name, column in table.items()}
    columns = pa.table({name: pa.array(column) for name, column in rounded.items()})
    if path.suffix == ".parquet":
        pq.write_table(columns, path)
    else:
        pc.write_csv(columns, path, pc.WriteOptions(quoting_style="needed"))
