"""What `adibas gestures evaluate` prints of an evaluation."""

from dataclasses import replace

import numpy as np

from adibas.cli.gestures_evaluation import evaluation_lines
from adibas.gestures.evaluation import Evaluation
from adibas.gestures.training import TrainingParams
from adibas.pipeline.gesture_work import Evaluated

RESULT = Evaluation(
    labels=("bend", "clap", "wave hello"),
    is_isolated=False,
    confusion=np.array([[9, 0, 0], [1, 6, 2], [0, 0, 8]]),
    missed=np.array([0, 1, 0]),
    best_right=23,
    hits=np.array([9, 6, 8]),
    n_reported=np.array([10, 6, 12]),
    n_done=np.array([9, 10, 8]),
    begin_errors=np.arange(101.0),
    end_errors=2.0 * np.arange(101.0),
    seconds=60.0,
)


def lines_of(result):
    return evaluation_lines(
        Evaluated("leave-one-subject-out", 3, result, ()), TrainingParams(seed=7)
    )


def test_each_gesture_tells_what_it_was_reported_as_right_first_then_mistakes_by_number():
    table = [line.split("  ") for line in lines_of(RESULT)[-3:]]
    assert [row[0] for row in table] == ["bend", "clap", "wave hello"]
    assert [row[-1] for row in table] == [
        "bend 9",
        "clap 6, wave hello 2, bend 1, nothing 1",
        "wave hello 8",
    ]


def test_rates_stand_below_their_names():
    head, _, clap, _ = lines_of(RESULT)[-4:]
    ends = {name: head.index(name) + len(name) for name in ("Precision", "Recall", "F1", "Eq. 7.7")}
    shown = {name: clap[:end].split()[-1] for name, end in ends.items()}
    assert shown == {"Precision": "1.00", "Recall": "0.60", "F1": "0.75", "Eq. 7.7": "%"}
    assert clap[: ends["Eq. 7.7"]].endswith("60.0 %")


def test_how_far_begins_and_ends_are_off_is_told_of_streams_alone():
    told = "Begins are off by 50.0 frames (median), 95 % by 95.0 at most; ends by 100.0 and 190.0"
    assert told in lines_of(RESULT)
    nothing = np.empty(0)
    isolated = replace(RESULT, is_isolated=True, begin_errors=nothing, end_errors=nothing)
    assert not [line for line in lines_of(isolated) if "Begins" in line]
