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
from adibas.recordings.association import MAX_DIFFERENCE_NS, NEIGHBOURS, associate
from adibas.recordings.tum_lists import ListedImage, format_list, read_list
from adibas.recordings.tum_regular import parse_regular
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
        ". depth/a.png",
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
    assert list(read_list(path, "rgb.txt")) == [ListedImage(time_ns, "a.png")]
    shutil.rmtree(path)


def test_times_in_other_notations_are_read(tmp_path):
    (tmp_path / "rgb.txt").write_text("1.5e3 a.png\n+2.25 b.png\n3. c.png\n")
    times_ns = read_list(tmp_path, "rgb.txt").times_ns
    np.testing.assert_array_equal(times_ns, [1_500_000_000_000, 2_250_000_000, 3_000_000_000])


def test_a_file_that_is_listed_twice_keeps_its_place_and_gets_the_last_time(tmp_path):
    (tmp_path / "rgb.txt").write_text("1.0 a.png\n2.0 b.png\n3.0 a.png\n")
    assert list(read_list(tmp_path, "rgb.txt")) == [
        ListedImage(3_000_000_000, "a.png"),
        ListedImage(2_000_000_000, "b.png"),
    ]


number_parts = st.sampled_from(["", "0", "7", "13", "9223372036", "9999999999", "0123456789", "x"])
list_times = st.one_of(
    st.decimals(0, 9_223_372_037, places=6).map(str),
    st.builds("{}.{}".format, number_parts, number_parts),
    st.sampled_from(["5", "1e3", "+2.5", "-1.0", "#3.0", "1.2.3", "٣.0", "1_0.0", ".5", "3."]),
)
list_names = st.text("ab./#-", min_size=1, max_size=8) | st.sampled_from(
    ["rgb/1.5.png", "a..b", "../a", "/a", "a/..", "C:a", "a\\b", "a\0", "é.png", "a b", "a\x7f"]
)
regular_lines = st.builds("{:.6f} rgb/{}.png".format, st.floats(0, 2e9), st.integers(0, 99))
list_lines = regular_lines | st.builds(
    "{}{}{}".format, list_times, st.sampled_from([" "] * 5 + ["  ", "\t", "\x0b"]), list_names
)
comments = st.sampled_from(["# times: files", "#", "# é", "# a\x0b1.0 b.png", "# a\r1.0 c.png"])
line_ends = st.sampled_from(["\n"] * 8 + ["\r\n", "\r", "\n\n", " \n"])
list_texts = st.builds(
    lambda head, lines, end: "\n".join([*head, ""]) * bool(head) + end.join(lines),
    st.lists(comments, max_size=3),
    st.lists(list_lines | regular_lines | comments, max_size=6),
    line_ends,
)


def lines_or_complaint(path, text):
    (path / "rgb.txt").write_bytes(text.encode())
    try:
        return list(read_list(path, "rgb.txt"))
    except RecordingError as error:
        return str(error)


@given(list_texts, st.sampled_from(["", "\n", "\r\n"]))
def test_a_regular_list_says_the_same_as_with_a_blank_line_that_makes_it_irregular(
    tmp_path_factory, text, end
):
    path = tmp_path_factory.mktemp("list")
    assert parse_regular((text + "\n \n").encode()) is None
    assert lines_or_complaint(path, text + end) == lines_or_complaint(path, text + "\n \n")
    shutil.rmtree(path)


@pytest.mark.parametrize("text", [DEPTH_LIST.replace("\n\n", "\n"), COLOR_LIST, "", "1. a", "#"])
@pytest.mark.parametrize("line_end", ["\n", "\r\n"])
def test_lists_of_programs_are_read_all_at_once(tmp_path, text, line_end):
    times_ns, names = parse_regular(text.replace("\n", line_end).encode())
    assert len(times_ns) == len(names) == len(lines_or_complaint(tmp_path, text + "\n \n"))


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


def one_after_another(depth_ns, color_ns):
    """Take the near pairs one by one, the nearest first; only the next neighbours count."""
    order = sorted(range(len(color_ns)), key=lambda j: color_ns[j])
    candidates = []
    for i, time_ns in enumerate(depth_ns):
        n_before = sum(other < time_ns for other in color_ns)
        near = order[max(n_before - NEIGHBOURS, 0) : n_before + NEIGHBOURS]
        candidates += [(abs(time_ns - color_ns[j]), i, j) for j in near]
    chosen = {}
    for difference_ns, i, j in sorted(candidates):
        if difference_ns <= MAX_DIFFERENCE_NS and i not in chosen and j not in chosen.values():
            chosen[i] = j
    pairs = [(i, chosen.get(i, -1)) for i in range(len(depth_ns))]
    pairs += [(-1, j) for j in range(len(color_ns)) if j not in chosen.values()]
    return sorted(pairs, key=lambda pair: color_ns[pair[1]] if pair[0] < 0 else depth_ns[pair[0]])


def associated(depth_ns, color_ns):
    pairs = associate(np.array(depth_ns, np.int64), np.array(color_ns, np.int64))
    return [tuple(pair) for pair in pairs.tolist()]


times = st.lists(st.integers(0, 12).map(lambda n: n * 7_000_000), max_size=12, unique=True)
any_times = st.lists(st.integers(0, 12).map(lambda n: n * 5_000_000), max_size=12)


@given(times, times)
def test_images_are_paired_as_by_brute_force_and_used_once(depth_ns, color_ns):
    pairs = associated(depth_ns, color_ns)
    assert {i: j for i, j in pairs if i >= 0 and j >= 0} == nearest_first(depth_ns, color_ns)
    assert sorted(i for i, _ in pairs if i >= 0) == list(range(len(depth_ns)))
    assert sorted(j for _, j in pairs if j >= 0) == list(range(len(color_ns)))


@given(any_times, any_times)
def test_images_of_equal_times_are_paired_as_one_after_another(depth_ns, color_ns):
    assert associated(depth_ns, color_ns) == one_after_another(depth_ns, color_ns)


@pytest.mark.parametrize("jitter_ns", [1_000_000, 15_000_000, 40_000_000])
def test_long_lists_are_paired_as_one_after_another(jitter_ns):
    rng = np.random.default_rng(jitter_ns)
    steps_ns = 10**9 + np.arange(300) * 33_333_333
    depth_ns, color_ns = (
        (steps_ns + rng.integers(-jitter_ns, jitter_ns, 300))[rng.random(300) < 0.9].tolist()
        for _ in range(2)
    )
    assert associated(depth_ns, color_ns) == one_after_another(depth_ns, color_ns)


def test_the_last_time_there_is_has_neighbours_too():
    last_ns = 2**63 - 1
    assert associated([last_ns], [last_ns - 5, last_ns]) == [(-1, 0), (0, 1)]


def test_a_line_taken_out_of_a_list_takes_the_image_out_of_the_recording(tmp_path):
    frames = make_frames(4)
    write_frames(create_recording(tmp_path / "a", INFO), frames)
    lines = (tmp_path / "a" / "depth.txt").read_text().splitlines(keepends=True)
    (tmp_path / "a" / "depth.txt").write_text("".join(lines[:-1]))
    with open_recording(tmp_path / "a") as reader:
        assert len(reader) == 4
        assert_same_frame(reader.read(2), frames[2])
        assert reader.read(3).depth_raw is None


ONE_FRAME = {"sequence": [7], "timestamp_ns": [5], "depth": ["depth/b.png"], "color": [None]}


def noted(**changes):
    return json.dumps({"frames": ONE_FRAME | {"infrared": [None]} | changes})


def test_notes_pair_their_images_and_the_rest_is_paired_by_time(folder):
    (folder / "adibas.json").write_text(noted(color=["rgb/c.png"], infrared=["gone.png"]))
    with open_recording(folder) as reader:
        frames = list(reader)
    assert [frame.sequence for frame in frames] == [7, 1, 2, 3]
    assert [frame.timestamp_ns for frame in frames] == [
        1305031453_404816000,
        1305031453_374112000,
        1305031453_391690000,
        1305031453_436000000,
    ]
    colors = [frame.color_timestamp_ns for frame in frames]
    assert colors[:1] + colors[2:] == [1305031453_500000000, 1305031453_391690000, None]


def test_noted_frames_of_which_nothing_is_left_are_left_out(folder):
    (folder / "adibas.json").write_text(noted(depth=["gone.png"]))
    with open_recording(folder) as reader:
        assert [reader.read(i).sequence for i in range(len(reader))] == [0, 1, 2, 3]


@pytest.mark.parametrize(
    "notes",
    [
        "{",
        "[]",
        "[" * 100_000,
        '{"frames": [[1]]}',
        '{"frames": {}}',
        noted(sequence=[0, 1]),
        noted(sequence=[-1]),
        noted(sequence=[2**32]),
        noted(sequence=[0.0]),
        noted(sequence=[None]),
        noted(timestamp_ns=[2**63]),
        noted(timestamp_ns=[10**30]),
        noted(timestamp_ns="1"),
        noted(color=[1]),
        noted(depth=[["a"]]),
        noted(infrared=None),
    ],
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
