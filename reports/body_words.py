"""Moved to reports.comparison."""

from reports.comparison.metrics import are_half_planes, coupled
from reports.comparison.words import bodies_in_words, idealisation, shape_words, unlike_materials

__all__ = ["are_half_planes", "coupled", "bodies_in_words", "idealisation", "shape_words", "unlike_materials"]
