"""Hertz line contact by ContactMechanics: runs in an interpreter that has it (make peers), not in ours.

python performance_peer_contactmechanics.py '{"modulus": E*, "radius": R, "load": P, "period": L, "points": n}' ANSWER.npz
"""

import json
import sys
import time
from importlib.metadata import version

import numpy as np

begun = time.process_time()
from ContactMechanics import PeriodicFFTElasticHalfSpace  # noqa: E402
from ContactMechanics.Systems import NonSmoothContactSystem  # noqa: E402
from SurfaceTopography import UniformLineScan  # noqa: E402

imported, asked = time.process_time() - begun, json.loads(sys.argv[1])
begun = time.process_time()
# by hand
n, period = asked["points"], asked["period"]
x = (np.arange(n) + 0.5) * period / n - period / 2
surface = UniformLineScan(-(x**2) / (2 * asked["radius"]), period, periodic=True)
system = NonSmoothContactSystem(PeriodicFFTElasticHalfSpace((n,), asked["modulus"], (period,)), surface=surface)
found = system.minimize_proxy(external_force=asked["load"], pentol=1e-12)
pressure = found.jac * n / period
# so far
seconds = time.process_time() - begun
if not found.success:
    sys.exit(found.message)
np.savez(sys.argv[2], x=x, p=pressure, seconds=seconds, imported=imported, version=version("ContactMechanics"))
