"""Hertz line contact by tamaas: runs in an interpreter that has it (make peers), not in ours.

python performance_peer_tamaas.py '{"modulus": E*, "radius": R, "load": P, "period": L, "points": n}' ANSWER.npz
"""

import json
import sys
import time

import numpy as np

begun = time.process_time()
import tamaas  # noqa: E402

imported, asked = time.process_time() - begun, json.loads(sys.argv[1])
begun = time.process_time()
# by hand
n, period = asked["points"], asked["period"]
x = (np.arange(n) + 0.5) * period / n - period / 2
model = tamaas.ModelFactory.createModel(tamaas.model_type.basic_1d, [period], [n])
model.E, model.nu = asked["modulus"], 0.0
solver = tamaas.PolonskyKeerRey(model, -(x**2) / (2 * asked["radius"]), 1e-12)
solver.max_iter = 10_000
solver.solve(asked["load"] / period)
pressure = np.array(model.traction).ravel()
# so far
seconds = time.process_time() - begun
np.savez(sys.argv[2], x=x, p=pressure, seconds=seconds, imported=imported, version=tamaas.__version__)
