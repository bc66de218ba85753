"""Plays one stream of an .oni file with the real OpenNI2 and saves what it gives.

Run as a program of its own, because the library may hang or crash: FILE.oni STREAM OUT.npz.
"""

import sys
import time

import numpy as np
from openni import openni2

from adibas.sensors.openni2_device import PLAYER_SETTLES_S
from adibas.sensors.openni2_library import find_library_folder

SECONDS_TO_WAIT = 0.5
MAX_ROUNDS = 60


def main(path: str, name: str, out: str) -> None:
    """Play the stream `name` (depth, color or ir) of `path` until every frame was seen.

    The player drops frames that are not fetched in time, and even frame by frame it runs ahead of
    a fast reader: so the file is played again and again.
    """
    openni2.initialize(str(find_library_folder()))
    seen = {}
    for _ in range(MAX_ROUNDS):
        n_frames, pixel_format = play_once(path, name, seen)
        if len(seen) == n_frames:
            break
    images = np.array([seen[number][1] for number in sorted(seen)])
    times_us = [seen[number][0] for number in sorted(seen)]
    np.savez(out, images=images, times_us=times_us, numbers=sorted(seen), format=pixel_format)


def play_once(path: str, name: str, seen: dict) -> tuple[int, int]:
    """Add the frames of one round to `seen`; return their number and the pixel format."""
    device = openni2.Device(path.encode())
    device.playback.set_repeat_enabled(False)
    stream = getattr(device, f"create_{name}_stream")()
    mode = stream.get_video_mode()
    n_frames = stream.get_number_of_frames()
    stream.start()
    number = 0
    while number < n_frames and openni2.wait_for_any_stream([stream], SECONDS_TO_WAIT):
        frame = stream.read_frame()
        number = frame.frameIndex
        seen[number] = (frame.timestamp, to_array(frame, name).copy())
    stream.stop()
    time.sleep(PLAYER_SETTLES_S)
    stream.close()
    device.close()
    return n_frames, mode.pixelFormat.value


def to_array(frame: object, name: str) -> np.ndarray:
    """Return the image in `frame`; a view."""
    if name == "color":
        buffer = frame.get_buffer_as_uint8()
        return np.frombuffer(buffer, np.uint8).reshape(frame.height, frame.width, 3)
    return np.frombuffer(frame.get_buffer_as_uint16(), np.uint16).reshape(frame.height, frame.width)


if __name__ == "__main__":
    main(*sys.argv[1:])
