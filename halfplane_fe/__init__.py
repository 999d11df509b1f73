"""The independent referent: a plane-strain finite-element contact model, condensed to the interface."""

from halfplane_fe.fields import BodyFields, Snapshot, fields
from halfplane_fe.path import check_admissible
from halfplane_fe.settings import SolverSettings
from halfplane_fe.solve import FiniteElementSolution, solve

__all__ = ["BodyFields", "FiniteElementSolution", "Snapshot", "SolverSettings", "check_admissible", "fields", "solve"]
