"""Writes a folder of examples of gestures: joints over time, and when each gesture was done.

Three simulated people jump and clap, each twice. With real people `adibas pose RECORDING --out
NAME.joints.csv` gives the joints, and whoever watches the recording writes events.csv.
"""

import csv
import sys
from pathlib import Path

import numpy as np

from adibas.data.skeleton_track import track_of
from adibas.recordings.joints_csv import write_joints_csv
from adibas.simulation.body import load_body_model
from adibas.simulation.gestures import perform
from adibas.simulation.patient import SHAPES

RATE_HZ = 15.0
PLAN = ("idle", "jump", "idle", "clap", "idle", "jump", "idle", "clap", "idle")
PLACE_M = np.array([0.0, 0.0, 2.5])


def write_examples(folder: Path, n_people: int = 3) -> None:
    """Write NAME.joints.csv of each person, and one events.csv."""
    folder.mkdir(parents=True, exist_ok=True)
    rows = [("recording", "label", "begin_s", "end_s", "subject")]
    for person in range(n_people):
        body = load_body_model().shaped(SHAPES[person])
        joints_m = []
        for turn, label in enumerate(PLAN):
            gesture = perform(label, seed=100 * person + turn)
            begin_s = len(joints_m) / RATE_HZ
            times_s = np.arange(0.0, gesture.duration_s, 1.0 / RATE_HZ).tolist()
            joints_m += [body.posed(gesture.pose(one)).joints_m + PLACE_M for one in times_s]
            if label != "idle":
                end_s = (len(joints_m) - 1) / RATE_HZ
                rows.append((f"p{person}", label, f"{begin_s:.3f}", f"{end_s:.3f}", f"p{person}"))
        track = track_of(np.arange(len(joints_m)) / RATE_HZ, np.array(joints_m))
        write_joints_csv(folder / f"p{person}.joints.csv", [track])
    with (folder / "events.csv").open("w", newline="", encoding="utf-8") as file:
        csv.writer(file).writerows(rows)


if __name__ == "__main__":
    write_examples(Path(sys.argv[1]))
