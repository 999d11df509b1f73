"""Types of arrays, by what their entries are."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
"""Real values."""
Complex = NDArray[np.complex128]
"""Complex values."""
Indices = NDArray[np.int64]
"""Numbers of nodes, rows, degrees of freedom or instants."""
Mask = NDArray[np.bool_]
"""True for those that are chosen."""
States = NDArray[np.int8]
"""`SurfaceState` of nodes: open, stick, slip forward, slip in reverse."""
