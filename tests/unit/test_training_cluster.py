"""Training on a Dask cluster of two workers on this computer, started as a user starts them."""

import copy
import json
import os
import signal
import subprocess
import sys
import time
from concurrent.futures import ThreadPoolExecutor
from contextlib import ExitStack, contextmanager
from dataclasses import replace

import numpy as np
import pytest

from adibas.cli import main
from adibas.errors import LimbError
from adibas.forests.params import ForestParams
from adibas.forests.samples import Memory
from adibas.limbs.training_set import DEPTH, FolderHeader, write_header, write_image
from adibas.pipeline import training_cluster
from adibas.pipeline.limb_training import TrainingRequest, train_model
from adibas.pipeline.training_cluster import open_cluster, pack_counts, unpack_counts

pytest.importorskip("distributed")
PARAMS = ForestParams(
    n_trees=2, max_depth=6, n_images=7, n_pixels=50, n_candidates=12, min_pixels=2
)
QUIET = {**os.environ, "NUMBA_NUM_THREADS": "1"}


@contextmanager
def running(*command):
    process = subprocess.Popen(
        [sys.executable, "-m", *command],
        env=QUIET,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
    )
    try:
        yield process
    finally:
        process.kill()
        process.wait(20)


def until(holds, wait_s=40.0):
    end = time.monotonic() + wait_s
    while not holds():
        assert time.monotonic() < end
        time.sleep(0.05)


@contextmanager
def scheduler(folder):
    """Yield its file and its address."""
    file = folder / "scheduler.json"
    where = ("--host", "127.0.0.1", "--port", "0", "--no-dashboard")
    with running("distributed.cli.dask_scheduler", *where, "--scheduler-file", str(file)):
        until(lambda: file.exists() and file.read_text())
        yield file, json.loads(file.read_text())["address"]


@contextmanager
def cluster(folder):
    """Yield the address and the two workers."""
    from distributed import Client

    with ExitStack() as stack:
        file, address = stack.enter_context(scheduler(folder))
        how = ("--no-nanny", "--no-dashboard", "--nthreads", "1", "--host", "127.0.0.1")
        command = ("distributed.cli.dask_worker", "--scheduler-file", str(file), *how)
        workers = [stack.enter_context(running(*command)) for _ in range(2)]
        with Client(address) as client:
            client.wait_for_workers(2, timeout=40)
        yield address, workers


@pytest.fixture(scope="module")
def two_workers(tmp_path_factory):
    with cluster(tmp_path_factory.mktemp("cluster")) as (address, _):
        yield address


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """Ten noisy steps: what is near is one label, what is far the other."""
    folder = tmp_path_factory.mktemp("set")
    write_header(folder, FolderHeader(("near", "far"), 0.001, 100.0, 100.0, 40.0, 30.0))
    for number in range(10):
        rng = np.random.default_rng(number)
        depth = rng.integers(1500, 2500, (60, 80))
        labels = np.where(depth + rng.integers(-400, 400, depth.shape) < 2000, 1, 2)
        write_image(folder, f"{number:04d}", depth.astype(np.uint16), labels.astype(np.uint8))
    return folder


def quiet(*_told):
    pass


def test_two_workers_grow_the_forest_of_one_machine_to_the_last_bit(two_workers, folder, tmp_path):
    here = TrainingRequest(tmp_path / "here.npz", (folder,), seed=5, params=PARAMS)
    there = replace(here, out=tmp_path / "there.npz", cluster=two_workers)
    wanted, found = (train_model(request, quiet).forest for request in (here, there))
    assert len(wanted.nodes) > 100
    for name in ("roots", "child", "nodes", "leaves"):
        np.testing.assert_array_equal(getattr(found, name), getattr(wanted, name))


def test_each_worker_holds_a_share_of_the_images(two_workers, folder, tmp_path, monkeypatch):
    counted = []
    unpack = training_cluster.unpack_counts

    def noted(packed, shape):
        counted.append(int(unpack(packed, shape)[0].sum()))
        return unpack(packed, shape)

    monkeypatch.setattr(training_cluster, "unpack_counts", noted)
    request = TrainingRequest(tmp_path / "m.npz", (folder,), params=PARAMS, cluster=two_workers)
    train_model(request, quiet)
    assert counted[:2] == [4 * PARAMS.n_pixels, 3 * PARAMS.n_pixels]


def test_the_command_trains_there(two_workers, folder, tmp_path, capsys):
    out = tmp_path / "m.npz"
    small = ["--trees", "1", "--depth", "3", "--pixels", "20", "--out", str(out)]
    assert main(["limbs", "train", str(folder), *small, "--cluster", two_workers]) == 0
    assert "2 labels, 1 tree" in capsys.readouterr().out
    assert out.exists()


def test_images_that_a_worker_cannot_read_are_told(two_workers):
    class Elsewhere:
        labels = ("near", "far")

        def __len__(self):
            return 1

        def read(self, _index):
            raise LimbError("missing")

    with open_cluster(two_workers) as there, pytest.raises(LimbError, match="cannot read the im"):
        there.draw(Elsewhere(), PARAMS, (1, 0), Memory())


def test_a_damaged_image_is_told_as_on_one_machine(two_workers, folder, tmp_path):
    for path in folder.iterdir():
        (tmp_path / path.name).write_bytes(path.read_bytes())
    (tmp_path / f"0004{DEPTH}").write_bytes(b"no picture")
    params = replace(PARAMS, n_images=None)
    request = TrainingRequest(tmp_path / "m.npz", (tmp_path,), params=params, cluster=two_workers)
    with pytest.raises(LimbError, match=r"0004\.depth\.png in .* is damaged"):
        train_model(request, quiet)


def test_an_error_keeps_its_fields_on_the_way_to_another_process():
    error = copy.copy(LimbError("{file} is damaged.", file="a.png"))
    assert isinstance(error, LimbError)
    assert (str(error), error.fields) == ("a.png is damaged.", {"file": "a.png"})


@pytest.mark.parametrize("address", ["", "elsewhere", "tcp://", "tcp://host", "tcp://host:many"])
def test_what_is_no_address_is_told_so(address):
    with pytest.raises(LimbError, match="no address"), open_cluster(address):
        pass


def test_an_address_where_nobody_answers_is_told(monkeypatch, folder, tmp_path):
    monkeypatch.setattr(training_cluster, "ANSWER_S", 0.5)
    request = TrainingRequest(tmp_path / "m.npz", (folder,), cluster="tcp://127.0.0.1:9")
    with pytest.raises(LimbError, match="No Dask cluster answers"):
        train_model(request, quiet)
    assert not list(tmp_path.iterdir())


def test_a_cluster_without_workers_is_told(tmp_path):
    with (
        scheduler(tmp_path) as (_, address),
        pytest.raises(LimbError, match="no workers"),
        open_cluster(address),
    ):
        pass


def test_a_lost_worker_ends_the_training_and_what_is_done_is_kept(folder, tmp_path):
    """Killed in the second tree; the same command then goes on with that tree, here."""
    wanted = train_model(
        TrainingRequest(tmp_path / "w.npz", (folder,), params=PARAMS), quiet
    ).forest
    with cluster(tmp_path) as (address, workers):

        def kill_one(_step, done, _total):
            if done == PARAMS.max_depth + 2:
                workers[0].kill()

        request = TrainingRequest(tmp_path / "m.npz", (folder,), params=PARAMS, cluster=address)
        with pytest.raises(LimbError, match="was lost"):
            train_model(request, kill_one)
    assert (tmp_path / "m.npz.training" / "tree-0.npz").exists()
    found = train_model(replace(request, cluster=""), quiet).forest
    np.testing.assert_array_equal(found.nodes, wanted.nodes)


def test_ctrl_c_ends_the_training_and_the_cluster_is_free_again(two_workers, folder, tmp_path):
    out = tmp_path / "m.npz"
    arguments = ["limbs", "train", str(folder), "--cluster", two_workers]
    arguments += ["--out", str(out), "--trees", "500"]
    program = f"import sys; from adibas.cli import main; sys.exit(main({arguments!r}))"
    with subprocess.Popen(
        [sys.executable, "-c", program], env=QUIET, stderr=subprocess.PIPE, text=True
    ) as process:
        try:
            until((tmp_path / "m.npz.training" / "tree-1.npz").exists)
        finally:
            process.send_signal(signal.SIGINT)
        told = process.communicate(timeout=30)[1]
    assert process.returncode == 1
    assert told.strip().endswith("m.npz.training; the same command goes on from there.")
    assert "Traceback" not in told
    assert not out.exists()
    request = TrainingRequest(tmp_path / "n.npz", (folder,), params=PARAMS, cluster=two_workers)
    with ThreadPoolExecutor(1) as pool:
        pool.submit(train_model, request, quiet).result(60)


@pytest.mark.parametrize("most", [0, 255, 256, 70_000])
def test_counts_come_back_as_they_were(most):
    counts = np.random.default_rng(0).integers(0, most + 1, (3, 4, 5), np.int32)
    counts[0, 0, 0] = most
    packed = pack_counts(counts)
    np.testing.assert_array_equal(unpack_counts(packed, counts.shape), counts)
    assert len(pack_counts(np.zeros((100, 100), np.int32))) < 100
