"""TUM RGB-D folders, as the benchmark and others write them, and as nobody should."""

import json
import shutil
from dataclasses import replace

import cv2
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from adibas.calibration.files import write_calibration
from adibas.errors import AdibasError, RecordingError
from adibas.recordings import create_recording, open_recording
from adibas.recordings.association import MAX_DIFFERENCE_NS, associate
from adibas.recordings.tum_lists import ListedImage, format_list, read_list
from tests.unit.recorded_frames import (
    CALIBRATION,
    INFO,
    assert_same_frame,
    make_frames,
    write_frames,
)

DEPTH_LIST = """# depth maps
# file: 'rgbd_dataset_freiburg1_xyz.bag'
# timestamp filename
1305031453.374112 depth/a.png
1305031453.404816 depth/b.png

1305031453.436000 depth/c.png
"""
COLOR_LIST = """# color images
1305031453.359684 rgb/a.png
1305031453.391690 rgb/b.jpg
1305031453.500000 rgb/c.png
"""


@pytest.fixture
def folder(tmp_path):
    """A folder as the benchmark has it: 16-bit PNG and two kinds of colour."""
    path = tmp_path / "xyz"
    for name in ("depth", "rgb"):
        (path / name).mkdir(parents=True)
    (path / "depth.txt").write_text(DEPTH_LIST)
    (path / "rgb.txt").write_text(COLOR_LIST)
    for i, name in enumerate("abc"):
        depth = np.full((6, 8), 5000 * (i + 1), np.uint16)
        cv2.imwrite(str(path / "depth" / f"{name}.png"), depth)
    for i, name in enumerate(("a.png", "b.jpg", "c.png")):
        cv2.imwrite(str(path / "rgb" / name), np.full((12, 16, 3), 40 * i, np.uint8))
    return path


def test_the_benchmark_pairs_are_read_with_its_scale(folder):
    with open_recording(folder) as reader:
        assert reader.info.depth_unit_m == 1 / 5000
        assert reader.info.calibration is None
        frames = list(reader)
    assert [frame.timestamp_ns for frame in frames] == [
        1305031453_374112000,
        1305031453_404816000,
        1305031453_436000000,
        1305031453_500000000,
    ]
    colors = [frame.color_timestamp_ns for frame in frames]
    assert colors == [1305031453_359684000, 1305031453_391690000, None, 1305031453_500000000]
    assert [frame.depth_raw is None for frame in frames] == [False, False, False, True]
    assert frames[0].depth_raw[0, 0] == 5000
    assert [frame.sequence for frame in frames] == [0, 1, 2, 3]


def test_the_calibration_beside_tells_the_unit(folder):
    write_calibration(folder / "calibration.json", replace(CALIBRATION, depth_unit_m=0.001))
    with open_recording(folder) as reader:
        assert reader.info.depth_unit_m == 0.001
        assert reader.info.calibration is not None


@pytest.mark.parametrize("missing", ["rgb.txt", "depth.txt"])
def test_either_list_may_be_missing(folder, missing):
    (folder / missing).unlink()
    with open_recording(folder) as reader:
        frames = list(reader)
    assert len(frames) == 3
    assert all((frame.color is None) == (missing == "rgb.txt") for frame in frames)
    assert all((frame.depth_raw is None) == (missing == "depth.txt") for frame in frames)


@pytest.mark.parametrize(
    "line",
    [
        "1.0 ../secret.png",
        "1.0 /etc/hostname",
        "1.0 depth/../../secret.png",
        "1.0 C:\\secret.png",
        "1.0",
        "now depth/a.png",
        "-1 depth/a.png",
        "nan depth/a.png",
        "inf depth/a.png",
        "1e400 depth/a.png",
        "99999999999999999999999 depth/a.png",
        "٣.0 depth/a.png",
    ],
)
def test_a_line_that_makes_no_sense_or_leaves_the_folder_is_refused(folder, line):
    (folder / "depth.txt").write_text(f"# depth\n{line}\n")
    with pytest.raises(RecordingError, match=r"xyz/depth.txt cannot be read: line 2"):
        open_recording(folder)


def test_a_link_out_of_the_folder_is_refused(folder):
    secret = folder.parent / "secret.png"
    shutil.copy(folder / "depth" / "a.png", secret)
    (folder / "depth" / "a.png").unlink()
    (folder / "depth" / "a.png").symlink_to(secret)
    with open_recording(folder) as reader, pytest.raises(RecordingError, match="link out of"):
        reader.read(0)


@pytest.mark.parametrize("content", [b"", b"no picture", b"\x89PNG\r\n\x1a\n" + bytes(40)])
def test_a_damaged_image_is_named_and_the_others_are_read(folder, content):
    (folder / "depth" / "b.png").write_bytes(content)
    with open_recording(folder) as reader:
        with pytest.raises(RecordingError, match="Frame 1 of xyz is damaged"):
            reader.read(1)
        assert reader.read(2).depth_raw[0, 0] == 15000


def test_eight_bit_depth_is_refused_instead_of_taken_for_millimetres(folder):
    cv2.imwrite(str(folder / "depth" / "a.png"), np.full((6, 8), 200, np.uint8))
    with open_recording(folder) as reader, pytest.raises(RecordingError, match="Frame 0"):
        reader.read(0)


def test_a_huge_depth_image_is_refused_before_memory_is_taken(folder):
    png = bytearray((folder / "depth" / "a.png").read_bytes())
    png[16:24] = b"\x00\x01\x00\x00" * 2
    (folder / "depth" / "a.png").write_bytes(png)
    with open_recording(folder) as reader, pytest.raises(RecordingError, match="Frame 0"):
        reader.read(0)


def test_a_missing_image_is_named(folder):
    (folder / "rgb" / "a.png").unlink()
    with open_recording(folder) as reader, pytest.raises(AdibasError, match=r"a.png"):
        reader.read(0)


@given(st.integers(0, 2**63 - 1))
def test_times_pass_through_the_list_without_a_rounding(tmp_path_factory, time_ns):
    path = tmp_path_factory.mktemp("list")
    (path / "rgb.txt").write_text(format_list("t", [ListedImage(time_ns, "a.png")]))
    assert read_list(path, "rgb.txt") == [ListedImage(time_ns, "a.png")]
    shutil.rmtree(path)


def test_times_in_other_notations_are_read(tmp_path):
    (tmp_path / "rgb.txt").write_text("1.5e3 a.png\n+2.25 b.png\n3. c.png\n")
    assert [image.time_ns for image in read_list(tmp_path, "rgb.txt")] == [
        1_500_000_000_000,
        2_250_000_000,
        3_000_000_000,
    ]


def nearest_first(depth_ns, color_ns):
    """Brute force over all pairs."""
    pairs = sorted(
        (abs(d - c), i, j)
        for i, d in enumerate(depth_ns)
        for j, c in enumerate(color_ns)
        if abs(d - c) <= MAX_DIFFERENCE_NS
    )
    chosen = {}
    for _, i, j in pairs:
        if i not in chosen and j not in chosen.values():
            chosen[i] = j
    return chosen


times = st.lists(st.integers(0, 12).map(lambda n: n * 7_000_000), max_size=12, unique=True)


@given(times, times)
def test_images_are_paired_as_by_brute_force_and_used_once(depth_ns, color_ns):
    pairs = associate(np.array(depth_ns, np.int64), np.array(color_ns, np.int64))
    both = {i: j for i, j in pairs if i is not None and j is not None}
    assert both == nearest_first(depth_ns, color_ns)
    assert sorted(i for i, _ in pairs if i is not None) == list(range(len(depth_ns)))
    assert sorted(j for _, j in pairs if j is not None) == list(range(len(color_ns)))


def test_a_line_taken_out_of_a_list_takes_the_image_out_of_the_recording(tmp_path):
    frames = make_frames(4)
    write_frames(create_recording(tmp_path / "a", INFO), frames)
    lines = (tmp_path / "a" / "depth.txt").read_text().splitlines(keepends=True)
    (tmp_path / "a" / "depth.txt").write_text("".join(lines[:-1]))
    with open_recording(tmp_path / "a") as reader:
        assert len(reader) == 4
        assert_same_frame(reader.read(2), frames[2])
        assert reader.read(3).depth_raw is None


@pytest.mark.parametrize(
    "notes",
    ["{", "[]", '{"frames": [[1]]}', '{"frames": [[-1, 0, null, null, null]]}', "[" * 100_000],
)
def test_damaged_notes_are_told(folder, notes):
    (folder / "adibas.json").write_text(notes)
    with pytest.raises(RecordingError, match=r"adibas.json is damaged"):
        open_recording(folder)


def test_a_folder_that_is_not_empty_is_not_overwritten(folder):
    with pytest.raises(RecordingError, match="exists already"):
        create_recording(folder, INFO)


def test_nothing_is_seen_of_an_unfinished_folder(tmp_path):
    writer = create_recording(tmp_path / "a", INFO)
    writer.write(make_frames(1)[0])
    assert [item for item in tmp_path.iterdir() if not item.name.startswith(".")] == []
    writer.close()
    assert [item.name for item in tmp_path.iterdir()] == ["a"]
    assert json.loads((tmp_path / "a" / "adibas.json").read_text())["depth_unit_m"] == "0.0001"


def test_real_images_of_others_are_read_as_opencv_reads_them(real_data, tmp_path):
    source = real_data / "open3d_rgbd"
    path = tmp_path / "room"
    shutil.copytree(source / "color", path / "color")
    shutil.copytree(source / "depth", path / "depth")
    numbers = range(5)
    (path / "rgb.txt").write_text("".join(f"{i}.001 color/{i:05d}.jpg\n" for i in numbers))
    (path / "depth.txt").write_text("".join(f"{i}.000 depth/{i:05d}.png\n" for i in numbers))
    write_calibration(path / "calibration.json", replace(CALIBRATION, depth_unit_m=0.001))
    with open_recording(path) as reader:
        assert len(reader) == 5
        for i, frame in enumerate(reader):
            depth = cv2.imread(str(path / "depth" / f"{i:05d}.png"), cv2.IMREAD_UNCHANGED)
            np.testing.assert_array_equal(frame.depth_raw, depth)
            assert frame.color.payload == (path / "color" / f"{i:05d}.jpg").read_bytes()
