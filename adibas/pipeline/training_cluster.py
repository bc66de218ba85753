"""Trees that are grown on a Dask cluster: each worker has a share of the images.

The one part of the program that opens a connection for training, and only to the address that the
user gives. Workers count what every candidate makes of their pixels; the counts are added up here,
where splits are chosen. Sums of whole numbers do not depend on who counted what: the forest is the
same as on one machine, to the last bit.

Images are read by the workers, from the folder that they all see under the same path.
"""

import importlib.util
import logging
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from dataclasses import replace
from typing import TYPE_CHECKING, Any
from urllib.parse import urlsplit

import numpy as np
import zstandard

from adibas import __version__
from adibas.arrays import AnyArray, Float32Array, Int32Array, IntArray
from adibas.errors import AdibasError, LimbError
from adibas.forests.params import ForestParams
from adibas.forests.samples import Memory, PixelSample, TrainingImages
from adibas.forests.training import CountedPixels

if TYPE_CHECKING:
    from distributed import Client

ANSWER_S = 10.0
"""How long a scheduler may take to answer, at first and later."""
LOOK_S = 2.0
"""How often it is asked, during a count, whether all workers are still there."""
LOGGERS = ("distributed", "distributed.client", "distributed.gc", "tornado", "tornado.application")
"""What Dask writes to the screen."""


class Share:
    """The pixels of one worker: lives there, and is called from here."""

    def __init__(
        self,
        images: TrainingImages,
        params: ForestParams,
        seed: tuple[int, int],
        memory: Memory,
        share: tuple[int, int],
    ) -> None:
        self._sample = PixelSample(images, params, seed, memory, share)

    def label_counts(self) -> IntArray:
        """Return the (L,) drawn pixels of each label."""
        return self._sample.label_counts()

    def count(
        self,
        group: IntArray,
        grown: tuple[Int32Array, Float32Array],
        candidates: tuple[Float32Array, Float32Array],
        shape: tuple[int, ...],
    ) -> bytes:
        """Return the packed counts of a group of nodes."""
        counts = np.zeros(shape, np.int32)
        # What a message brought is read-only, for which the loops were not compiled.
        mine = grown[0].copy(), grown[1].copy()
        tried = candidates[0].copy(), candidates[1].copy()
        self._sample.count(group, mine, tried, counts)
        return pack_counts(counts)


def pack_counts(counts: Int32Array) -> bytes:
    """Return counts in few bytes: most are zero, and small numbers need no four bytes."""
    kind = np.min_scalar_type(int(counts.max(initial=0)))
    packed = zstandard.compress(counts.astype(kind).tobytes(), 1)
    return kind.str.encode() + b" " + packed


def unpack_counts(packed: bytes, shape: tuple[int, ...]) -> AnyArray:
    """Return what `pack_counts` has packed."""
    kind, payload = packed.split(b" ", 1)
    plain: AnyArray = np.frombuffer(zstandard.decompress(payload), np.dtype(kind.decode()))
    return plain.reshape(shape)


class Cluster:
    """Workers that were there when training began; if one is lost, training stops."""

    def __init__(self, client: "Client", address: str) -> None:
        self._client, self._address = client, address
        self._workers = sorted(_answered(address, client.nthreads))
        if not self._workers:
            raise LimbError(
                "The cluster at {address} has no workers. Start some, then give the command again.",
                address=address,
            )
        versions = _answered(address, lambda: client.run(_version))
        if set(versions.values()) != {__version__}:
            raise LimbError(
                "The workers at {address} must have ADiBAS {version}, as this computer has. "
                "Install it there.",
                address=address,
                version=__version__,
            )

    def draw(
        self, images: TrainingImages, params: ForestParams, seed: tuple[int, int], memory: Memory
    ) -> CountedPixels:
        """Let the workers draw a tree's pixels: the same that `PixelSample` draws here.

        Raises
        ------
        LimbError
            A worker does not see the images, or is lost; the pixels' methods say so too.
        """
        sees = _answered(self._address, lambda: self._client.run(_sees, images))
        for worker, is_seen in sees.items():
            if not is_seen:
                raise LimbError(
                    "The worker {worker} cannot read the images. Write to a folder that all "
                    "computers of the cluster have under the same path.",
                    worker=worker,
                )
        n_images = params.n_images or len(images)
        n_batch = _batch_of(n_images, len(self._workers), memory.n_batch_images)
        shared = replace(memory, n_batch_images=n_batch)
        shares = [
            self._client.submit(
                Share,
                *(images, params, seed, shared, (place, len(self._workers))),
                actor=True,
                pure=False,
                workers=[worker],
                allow_other_workers=False,
            )
            for place, worker in enumerate(self._workers)
        ]
        return _SharedPixels([self._wait(share.result) for share in shares], self._wait)

    def _wait(self, result: Callable[[float], Any]) -> Any:
        """Return a result, and look now and then whether somebody is still working on it."""
        while True:
            try:
                return result(LOOK_S)
            except TimeoutError:
                self._check_workers()
            except AdibasError:
                raise
            except (OSError, RuntimeError) as error:  # lost, on the way there or back
                raise self._lost() from error

    def _check_workers(self) -> None:
        there = _answered(self._address, self._client.nthreads)
        if not set(self._workers) <= set(there):
            raise self._lost()

    def _lost(self) -> LimbError:
        return LimbError(
            "A worker at {address} was lost. Give the same command again: trees that were finished "
            "are kept.",
            address=self._address,
        )


class _SharedPixels:
    """The pixels of a tree, spread over the workers."""

    def __init__(self, shares: list[Any], wait: Callable[[Callable[[float], Any]], Any]) -> None:
        self._shares, self._wait = shares, wait

    def label_counts(self) -> IntArray:
        """Return the (L,) drawn pixels of each label."""
        asked = [share.label_counts() for share in self._shares]
        counts: IntArray = np.sum([self._wait(one.result) for one in asked], axis=0)
        return counts

    def count(
        self,
        group: IntArray,
        grown: tuple[Int32Array, Float32Array],
        candidates: tuple[Float32Array, Float32Array],
        counts: Int32Array,
    ) -> None:
        """Add up what all workers count."""
        asked = [share.count(group, grown, candidates, counts.shape) for share in self._shares]
        for one in asked:
            counts += unpack_counts(self._wait(one.result), counts.shape)


@contextmanager
def open_cluster(address: str) -> Iterator[Cluster]:
    """Connect to the scheduler at `address`, such as ``tcp://10.0.0.7:8786``.

    Raises
    ------
    LimbError
        Dask is not installed, nobody answers, or there are no workers that can do the work.
    """
    if importlib.util.find_spec("distributed") is None:
        raise LimbError(
            "Training on a cluster needs Dask, which is not installed. Install ADiBAS with its "
            "extra: pip install 'adibas[train]'"
        )
    if not _is_address(address):
        raise LimbError(
            "{address} is no address of a Dask scheduler. Give it as tcp://COMPUTER:PORT or "
            "tls://COMPUTER:PORT.",
            address=address,
        )
    client = _answered(address, lambda: _connect(address))
    try:
        yield Cluster(client, address)
    finally:
        with suppress(OSError, TimeoutError):
            client.close(timeout=LOOK_S)


def _is_address(address: str) -> bool:
    try:
        parts = urlsplit(address)
        return parts.scheme in {"tcp", "tls"} and bool(parts.hostname) and parts.port is not None
    except ValueError:  # of a port that is no number
        return False


def _connect(address: str) -> "Client":
    import dask

    # Their own lines on the screen would stand between ours; what fails is told in words, and
    # Tornado's speak of a wait that Ctrl-C has ended. Children have levels of their own.
    dask.config.set({"logging": dict.fromkeys(LOGGERS, "critical")})
    from distributed import Client

    for name in LOGGERS:  # of another connection before
        logging.getLogger(name).setLevel(logging.CRITICAL)
    return Client(address, timeout=ANSWER_S)  # type: ignore[no-untyped-call]


def _answered(address: str, ask: Callable[[], Any]) -> Any:
    try:
        return ask()
    except (OSError, ValueError, RuntimeError) as error:
        raise LimbError(
            "No Dask cluster answers at {address}. Check the address and that its scheduler runs.",
            address=address,
        ) from error


def _batch_of(n_images: int, n_workers: int, most: int) -> int:
    """Return how many images a batch has, so that every worker gets some."""
    return min(most, max(1, -(-n_images // n_workers)))


def _version() -> str:
    return __version__


def _sees(images: TrainingImages) -> bool:
    try:
        images.read(len(images) - 1)
    except AdibasError:
        return False
    return True
