"""A colour is learned from clicks as the thesis says (6.1-6.3)."""

import json

import numpy as np
import pytest
from scipy import ndimage
from scipy.cluster.vq import kmeans2

from adibas.errors import MarkerError
from adibas.markers.color_files import preview, read_colors, write_colors
from adibas.markers.color_model import (
    ColorModel,
    LearningParams,
    distance_to_centroids,
    grow_region,
    learn_colors,
    surround_of,
)
from adibas.markers.lab import WHITE_D65_XYZ, XYZ_FROM_SRGB, rgb_to_lab

PARAMS = LearningParams()


def lab_by_the_book(color_rgb):
    """CIE 15:2004 and IEC 61966-2-1, written out."""
    encoded = color_rgb / 255.0
    linear = np.where(encoded <= 0.04045, encoded / 12.92, ((encoded + 0.055) / 1.055) ** 2.4)
    t = linear @ XYZ_FROM_SRGB.T / WHITE_D65_XYZ
    f = np.where(t > (6 / 29) ** 3, np.cbrt(t), t / (3 * (6 / 29) ** 2) + 4 / 29)
    x, y, z = np.moveaxis(f, -1, 0)
    return np.stack([116 * y - 16, 500 * (x - y), 200 * (y - z)], axis=-1)


def test_colours_are_the_cie_s():
    levels = np.array([0, 1, 9, 10, 11, 60, 127, 128, 200, 254, 255], np.uint8)
    grid = np.stack(np.meshgrid(levels, levels, levels), axis=-1).reshape(1, -1, 3)
    np.testing.assert_allclose(rgb_to_lab(grid), lab_by_the_book(grid), atol=1e-3)
    np.testing.assert_allclose(
        rgb_to_lab(np.full((1, 1, 3), 255, np.uint8)), [[[100, 0, 0]]], atol=0.02
    )


def test_a_region_is_the_connected_component_of_colours_near_the_seed():
    rng = np.random.default_rng(3)
    for _ in range(20):
        lab = (rng.normal(size=(23, 31, 3)) * 6).astype(np.float32)
        row, column = rng.integers(23), rng.integers(31)
        sensitivity = 14.0
        near = np.linalg.norm(lab - lab[row, column], axis=2) < sensitivity
        labels, _ = ndimage.label(near)
        expected = labels == labels[row, column]
        region = grow_region(lab, (column, row), sensitivity)
        np.testing.assert_array_equal(region, expected)


def test_a_region_does_not_leak_along_a_gradient():
    lab = np.zeros((3, 100, 3), np.float32)
    lab[..., 0] = np.arange(100)
    region = grow_region(lab, (0, 1), 10.0)
    assert region[:, :10].all()
    assert not region[:, 10:].any()


@pytest.mark.parametrize("seed", [(-1, 0), (0, 3), (31.0, 1), (float("1e9"), 0)])
def test_a_click_outside_the_picture_is_told(seed):
    with pytest.raises(MarkerError, match="outside the picture"):
        grow_region(np.zeros((3, 31, 3), np.float32), seed, 5.0)


def test_k_means_finds_clusters_as_tight_as_scipy_s():
    rng = np.random.default_rng(5)
    centres = np.array([[50.0, -40, 30], [30, -20, 10], [70, -30, 40]])
    pixels = np.concatenate([c + rng.normal(size=(200, 3)) for c in centres])
    model = learn_colors(pixels, np.random.default_rng(0), PARAMS, {})
    ours = (distance_to_centroids(pixels, model.centroids_lab) ** 2).sum()
    theirs, _ = kmeans2(pixels, centres, minit="matrix")
    assert ours <= (distance_to_centroids(pixels, theirs) ** 2).sum() * (1 + 1e-9)
    assert (distance_to_centroids(centres, model.centroids_lab) < 0.3).all()


def test_learning_is_repeatable_for_a_seed():
    pixels = np.random.default_rng(7).normal(size=(300, 3)) * 10
    models = [learn_colors(pixels, np.random.default_rng(1), PARAMS, {}) for _ in range(2)]
    np.testing.assert_array_equal(models[0].centroids_lab, models[1].centroids_lab)


def test_one_flat_pixel_makes_one_centroid_and_the_least_threshold():
    model = learn_colors(np.array([[50.0, 1, 2]] * 9), np.random.default_rng(0), PARAMS, {})
    np.testing.assert_array_equal(model.centroids_lab, [[50.0, 1, 2]])
    assert model.threshold == PARAMS.least_threshold


def test_a_wide_colour_gets_a_wider_threshold_up_to_a_limit():
    rng = np.random.default_rng(2)

    def threshold(spread):
        pixels = rng.normal(size=(500, 3)) * spread
        return learn_colors(pixels, np.random.default_rng(0), PARAMS, {}).threshold

    assert PARAMS.least_threshold < threshold(6.0) < threshold(200.0) == PARAMS.greatest_threshold


def test_learned_colours_come_back_from_the_disk_exactly(tmp_path):
    model = ColorModel(np.array([[50.1, -40.2, 30.3]]), 14.5, {"seeds": [[1, 2]]})
    write_colors(tmp_path / "colours.json", model)
    document = json.loads((tmp_path / "colours.json").read_text())
    assert (document["format"], document["version"]) == ("adibas-colours", 1)
    back = read_colors(tmp_path / "colours.json")
    np.testing.assert_array_equal(back.centroids_lab, model.centroids_lab)
    assert (back.threshold, back.source) == (14.5, {"seeds": [[1, 2]]})


GOOD = {"format": "adibas-colours", "version": 1, "centroids_lab": [[1, 2, 3]], "threshold": 9}


@pytest.mark.parametrize(
    "document",
    [
        [],
        GOOD | {"format": "x"},
        GOOD | {"version": 2},
        GOOD | {"centroids_lab": []},
        GOOD | {"centroids_lab": [[1, 2]]},
        GOOD | {"centroids_lab": [[1, 2, "x"]]},
        GOOD | {"centroids_lab": [[1, 2, float("nan")]]},
        GOOD | {"threshold": 0},
        GOOD | {"threshold": None},
        GOOD | {"threshold": 10**400},
        GOOD | {"centroids_lab": [[1, 2, 10**400]]},
    ],
)
def test_a_file_without_colours_is_told_in_words(tmp_path, document):
    path = tmp_path / "colours.json"
    path.write_text(json.dumps(document))
    with pytest.raises(MarkerError, match="holds no learned colours"):
        read_colors(path)


@pytest.mark.parametrize(
    "changes",
    [
        {"threshold": 1e308},
        {"threshold": 400.1},
        {"centroids_lab": [[1, 2, 1e308]]},
        {"centroids_lab": [[50, 2, 3], [-16, 2, 3]]},
        {"centroids_lab": [[102, 2, 3]]},
        {"centroids_lab": [[50, -129, 3]]},
        {"surround_lab": [[50, 2, 3], [50, 2, -1e200]]},
    ],
)
def test_numbers_that_are_no_colours_are_told_in_words(tmp_path, changes):
    path = tmp_path / "colours.json"
    path.write_text(json.dumps(GOOD | changes))
    with pytest.raises(MarkerError, match=r"numbers that are no colours.*at most 400\."):
        read_colors(path)


def test_all_colours_of_a_screen_can_be_read_back(tmp_path):
    levels = np.arange(0, 256, 15, dtype=np.uint8)
    color_rgb = np.stack(np.meshgrid(levels, levels, levels), axis=-1).reshape(1, -1, 3)
    lab = rgb_to_lab(color_rgb)[0].astype(float)
    write_colors(tmp_path / "colours.json", ColorModel(lab, 400.0, {}, lab.copy()))
    np.testing.assert_array_equal(read_colors(tmp_path / "colours.json").centroids_lab, lab)


@pytest.mark.parametrize("content", [b"{", b"\xff\xfe", b"[" * 100_000])
def test_a_damaged_file_is_told_in_words(tmp_path, content):
    (tmp_path / "colours.json").write_bytes(content)
    with pytest.raises(MarkerError, match="holds no learned colours"):
        read_colors(tmp_path / "colours.json")


def test_a_missing_file_is_told_in_words(tmp_path):
    with pytest.raises(MarkerError, match="cannot be read"):
        read_colors(tmp_path / "colours.json")


def test_the_preview_keeps_what_was_taken_and_dims_the_rest():
    color_rgb = np.full((2, 2, 3), 200, np.uint8)
    taken = np.array([[True, False], [False, False]])
    picture = preview(color_rgb, taken)
    assert (picture[0, 0] == 200).all()
    assert (picture[~taken] == 70).all()


@pytest.mark.parametrize("parts", [(np.zeros((0, 3)), 1.0), (np.zeros((1, 3)), -1.0)])
def test_a_colour_model_without_sense_is_a_programming_error(parts):
    with pytest.raises(ValueError, match=r"centroids|threshold"):
        ColorModel(*parts)


def test_a_centroid_mixed_with_the_skin_about_the_marker_is_not_pure():
    marker, skin = np.array([46.0, -33.0, 36.0]), np.array([58.0, 20.0, 34.0])
    centroids = np.array([marker, 0.8 * marker + 0.2 * skin, 0.4 * marker + 0.6 * skin])
    model = ColorModel(centroids, 12.0, surround_lab=skin[None])
    np.testing.assert_array_equal(model.pure_centroids_lab(), centroids[:2])
    unknown = ColorModel(centroids, 12.0)
    np.testing.assert_array_equal(unknown.pure_centroids_lab(), centroids)


def test_the_surround_of_a_region_is_what_lies_about_it_beyond_its_rim():
    lab = np.zeros((60, 60, 3), np.float32)
    lab[...] = (60, 20, 30)
    lab[24:34, 24:34] = (50, -10, 30)
    lab[26:32, 26:32] = (45, -35, 35)
    region = grow_region(lab, (28, 28), 10.0)
    np.testing.assert_allclose(surround_of(lab, region), (60, 20, 30))
    assert surround_of(lab, np.ones((60, 60), bool)) is None


def test_the_surround_of_the_learned_regions_is_kept_on_the_disk(tmp_path):
    path = tmp_path / "colours.json"
    model = ColorModel(np.array([[46.0, -33.0, 36.0]]), 12.0, {}, np.array([[58.0, 20.0, 34.0]]))
    write_colors(path, model)
    np.testing.assert_array_equal(read_colors(path).surround_lab, model.surround_lab)


def test_a_surround_that_is_no_number_is_refused():
    with pytest.raises(ValueError, match="finite surrounds"):
        ColorModel(np.array([[46.0, -33.0, 36.0]]), 12.0, {}, np.array([[np.nan, 20.0, 34.0]]))
