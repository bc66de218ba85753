"""The window: one folder per screen, presenters without Qt, and the core beneath them."""

import os

# Before OpenCV is loaded: what it shares out among threads takes less time here than waking them,
# and frames are worked on side by side anyway.
os.environ.setdefault("OPENCV_FOR_THREADS_NUM", "1")
