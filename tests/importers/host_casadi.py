"""What are the rates of an FMU in CasADi, and their slopes? Arguments: FMU STATES INPUTS; points as JSON, by name, the others at start."""

from __future__ import annotations

import json
import sys
import tempfile
import zipfile

import casadi


def main(fmu: str, states: dict[str, float], inputs: dict[str, float]) -> None:
    with tempfile.TemporaryDirectory() as folder, zipfile.ZipFile(fmu) as packed:
        packed.extractall(folder)
        builder = casadi.DaeBuilder("model", folder, {})
        point = [
            [given.get(name, float(builder.start(name)[0])) for name in names]
            for names, given in ((builder.x(), states), (builder.u(), inputs))
        ]
        rates = builder.create("rates", ["x", "u"], ["ode"])
        slopes = rates.factory("slopes", ["x", "u"], ["jac:ode:u"])
        answered = {
            "states": builder.x(),
            "inputs": builder.u(),
            "rates": casadi.DM(rates(*point)).full().ravel().tolist(),
            "slopes": casadi.DM(slopes(*point)).full().tolist(),
        }
    print("RESULT", json.dumps(answered))


if __name__ == "__main__":
    main(sys.argv[1], json.loads(sys.argv[2]), json.loads(sys.argv[3]))
