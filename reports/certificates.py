"""Moved to reports.comparison."""

from reports.comparison.laws import LIMIT, PRINTED, Certificate, certificates

__all__ = ["LIMIT", "PRINTED", "Certificate", "certificates"]
