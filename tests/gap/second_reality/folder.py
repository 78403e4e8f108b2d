"""How does a case reach the disk? As people write records: their units, headers and extra columns; nothing of its truth in it."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.csv as pc
import pyarrow.parquet as pq

from .draw import Case
from .drive import Array

Draw = np.random.Generator
# variable: ((header, unit, factor from SI, offset), ...)
HEADERS: dict[str, tuple[tuple[str, str, float, float], ...]] = {
    "time": (("Time [s]", "s", 1.0, 0.0), ("t", "ms", 1e3, 0.0), ("timestamp_us", "us", 1e6, 0.0)),
    "slip_velocity": (("v_rel [m/s]", "m/s", 1.0, 0.0), ("velocity", "mm/s", 1e3, 0.0), ("speed", "m/min", 60.0, 0.0)),
    "proxy_speed": (("heat_index", "m/s", 1.0, 0.0), ("theta", "m/min", 60.0, 0.0)),
    "contact_temperature": (("T", "degC", 1.0, -273.15), ("temperature [K]", "K", 1.0, 0.0)),
    "normal_load": (("F_N", "N", 1.0, 0.0), ("load", "kN", 1e-3, 0.0)),
    "friction_force": (("F_fric [N]", "N", 1.0, 0.0), ("force", "mN", 1e3, 0.0), ("F_t", "kN", 1e-3, 0.0)),
    "principal_force": (("Fc [N]", "N", 1.0, 0.0), ("F_x", "kN", 1e-3, 0.0)),
    "feed_force": (("Ft [N]", "N", 1.0, 0.0), ("F_y", "kN", 1e-3, 0.0)),
}
TITLES = {"rig": "Friction rig", "axis": "Linear axis", "ellipse": "Elliptical vibration cutting", "means": "Mean cutting forces"}


def number(value: float) -> str:
    """Ten digits, a float to TOML."""
    text = f"{value:.10g}"
    return text if any(mark in text for mark in ".en") else text + ".0"


def _table(name: str, values: Mapping[str, float | str]) -> list[str]:
    def key(text: str) -> str:
        return f'"{text}"' if "." in text else text

    return [f"[{name}]", *(f'{key(k)} = "{v}"' if isinstance(v, str) else f"{key(k)} = {number(v)}" for k, v in values.items()), ""]


def write(folder: Path, case: Case, rng: Draw) -> None:
    world = case.world
    folder.mkdir(parents=True)
    effects = ", ".join(f'"{name}"' for name in world.nominal_effects)
    lines = ["format = 1", f'title = "{TITLES[world.kind.split("/")[0]]}, record {folder.name}"', "", "[nominal]", 'friction = "lugre"']
    lines += [f'kinematics = "{"external" if world.inputs else "internal"}"', f"effects = [{effects}]"]
    lines += _table("nominal.values", {**case.nominal, **world.exact})
    exact = {name: 0.0 for name, value in world.exact.items() if not isinstance(value, str)}
    lines += _table("nominal.relative_sd", {**world.sd, **exact})
    lines += _means(folder, case, rng) if world.means else _trials(folder, case, rng)
    (folder / "experiment.toml").write_text("\n".join(lines).rstrip() + "\n", encoding="utf-8")


def _trials(folder: Path, case: Case, rng: Draw) -> list[str]:
    world = case.world
    names, lines = ["time", *world.inputs, *world.channels], []
    chosen = {name: HEADERS[name][int(rng.integers(len(HEADERS[name])))] for name in names}
    for name in names:
        lines += [f"[signals.{name}]", f'column = "{chosen[name][0]}"', f'unit = "{chosen[name][1]}"']
        if name != "time":
            lines.append(f'role = "{"input" if name in world.inputs else "output"}"')
        lines.append("")
    suffix, sub = (".parquet" if rng.random() < 0.3 else ".csv"), ("data/" if rng.random() < 0.6 else "")
    (folder / sub).mkdir(exist_ok=True)
    order, seen = rng.permutation(len(case.trials)).tolist() if rng.random() < 0.4 else range(len(case.trials)), dict[int, int]()
    for place in order:
        trial = case.trials[place]
        repeat = seen[trial.place] = seen.get(trial.place, 0) + 1
        columns = {"time": trial.times, **trial.inputs, **trial.outputs}
        table = {chosen[name][0]: columns[name] * chosen[name][2] + chosen[name][3] for name in names}
        file = f"{sub}cond{trial.place + 1}_run{repeat}{suffix}"
        save(folder / file, {**table, **trial.beside})
        lines += ["[[trials]]", f'file = "{file}"', f'condition = "cond{trial.place + 1}"']
        if world.per_trial:
            values = ", ".join(f"{n} = {number(world.conditions.values[trial.place][n])}" for n in world.per_trial)
            lines.append(f"values = {{ {values} }}")
        lines.append("")
    return lines


def _means(folder: Path, case: Case, rng: Draw) -> list[str]:
    world, rows = case.world, case.trials
    unit = {name: float(np.sqrt(np.mean([row.true[name][0] ** 2 for row in rows]))) for name in world.channels}
    table: dict[str, Array | list[str]] = {"condition": [f"test {k + 1}" for k in range(len(rows))]}
    for name in world.per_trial:
        table[name] = np.array([world.conditions.values[row.place][name] for row in rows])
    for name in world.channels:
        table[name] = np.array([row.outputs[name][0] for row in rows])
        if case.mean_sd:
            table[name + "_sd"] = np.full(len(rows), case.mean_sd[name] * unit[name])
    save(folder / "means.csv", table)
    return ["[means]", 'file = "means.csv"', ""]


def save(path: Path, table: Mapping[str, Array | list[str]]) -> None:
    """Eight digits; CSV or Parquet by the name."""

    def rounded(column: Array | list[str]) -> pa.Array:
        return pa.array(column if isinstance(column, list) else [float(f"{value:.8g}") for value in column.tolist()])

    columns = pa.table({name: rounded(column) for name, column in table.items()})
    if path.suffix == ".parquet":
        pq.write_table(columns, path)
    else:
        pc.write_csv(columns, path, pc.WriteOptions(quoting_style="needed"))
