"""Posture and movement of people, measured with an inexpensive depth camera."""

import os

# Read when numpy is imported. Several threads over small matrices wait for one another most of the
# time, and the last digit of a result would depend on how many cores there are.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

__version__ = "0.1.0"
