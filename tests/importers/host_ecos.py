"""What does a system show in Ecos, at its own times? Arguments: SSP STEP STOP EVERY PORT..."""

from __future__ import annotations

import json
import sys

from ecospy import EcosSimulation


def main(ssp: str, step: float, stop: float, every: int, ports: list[str]) -> None:
    with EcosSimulation(ssp_path=ssp, step_size=step) as simulation:
        simulation.init(parameter_set="default")
        times, rows = [], []
        for _ in range(0, round(stop / step), every):
            simulation.step(every)
            times.append(simulation.get_time())
            rows.append([simulation.get_real(port.replace(".", "::")) for port in ports])
        simulation.terminate()
    print("RESULT", json.dumps({"times": times, "columns": {port: [row[place] for row in rows] for place, port in enumerate(ports)}}))


if __name__ == "__main__":
    main(sys.argv[1], float(sys.argv[2]), float(sys.argv[3]), int(sys.argv[4]), sys.argv[5:])
