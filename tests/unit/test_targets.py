"""What markers look like comes back from a session as it was."""

import json

import numpy as np
import pytest

from adibas.errors import MarkerError
from adibas.markers.color_model import ColorModel
from adibas.markers.led import LedParams
from adibas.pipeline.targets import target_from_document, target_to_document


def kept(target):
    return target_from_document(json.loads(json.dumps(target_to_document(target))))


def test_colours_come_back_exactly():
    surround = np.array([[40.1, 2.0, 3.3]])
    model = ColorModel(np.array([[50.1, -40.2, 30.3], [1.0, 2.0, 3.0]]), 14.5, {"k": 2}, surround)
    back = kept(model)
    np.testing.assert_array_equal(back.centroids_lab, model.centroids_lab)
    np.testing.assert_array_equal(back.surround_lab, surround)
    assert (back.threshold, back.source) == (14.5, {"k": 2})


def test_leds_come_back_with_their_brightness():
    assert kept(LedParams(least_brightness=88.0)) == LedParams(least_brightness=88.0)


@pytest.mark.parametrize(
    "document",
    [
        {},
        {"format": "adibas-leds"},
        {"format": "adibas-leds", "version": 2, "least_brightness": 60},
        {"format": "adibas-leds", "version": 1, "least_brightness": "bright"},
        {"format": "adibas-leds", "version": 1, "least_brightness": None},
        {"format": "adibas-colours", "version": 1, "centroids_lab": [], "threshold": 9},
        {"format": "adibas-colours", "version": 9},
        {"format": "adibas-colours", "version": 1, "centroids_lab": [[1, 2, 10**400]]},
    ],
)
def test_a_damaged_document_is_told_in_words(document):
    with pytest.raises(MarkerError, match="Learn their colour again"):
        target_from_document(document)
