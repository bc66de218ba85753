"""The window: one folder per screen, presenters without Qt, and the core beneath them."""

import os

# Before OpenCV is loaded: between two pictures its threads would spin, for half of what drawing
# costs, instead of sleeping.
for _who in ("WORKER", "MAIN"):
    os.environ.setdefault(f"OPENCV_THREAD_POOL_ACTIVE_WAIT_{_who}", "0")
