"""How fast the calibration wizard's live picture is."""

from benchmarks.calibration_wizard import rows

__all__ = ["rows"]
