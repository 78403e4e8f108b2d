"""What does a system show in libcosim (Open Simulation Platform), at its own times? Arguments: FOLDER STEP STOP EVERY PORT..."""

from __future__ import annotations

import json
import sys

from libcosimpy.CosimExecution import CosimExecution
from libcosimpy.CosimObserver import CosimObserver


def main(folder: str, step: float, stop: float, every: int, ports: list[str]) -> None:
    nanos = round(step * 1e9)
    execution = CosimExecution.from_ssp_file(ssp_path=folder, step_size=nanos)
    observer = CosimObserver.create_last_value()
    execution.add_observer(observer=observer)
    places = []
    for port in ports:
        component, _, variable = port.partition(".")
        slave = execution.slave_index_from_instance_name(component)
        (reference,) = (v.reference for v in execution.slave_variables(slave) if v.name.decode() == variable and v.type == 0)
        places.append((slave, reference))
    times, rows = [], []
    for n in range(0, round(stop / step), every):
        if not execution.simulate_until(target_time=(n + every) * nanos):
            sys.exit(f"libcosim stopped at step {n}")
        times.append(execution.status().current_time / 1e9)
        rows.append([observer.last_real_values(slave_index=slave, variable_references=[reference])[0] for slave, reference in places])
    print("RESULT", json.dumps({"times": times, "columns": {port: [row[place] for row in rows] for place, port in enumerate(ports)}}))


if __name__ == "__main__":
    main(sys.argv[1], float(sys.argv[2]), float(sys.argv[3]), int(sys.argv[4]), sys.argv[5:])
