"""Sealed MCAP: each frame's chunk, the description and the times are sealed; sizes remain.

`docs/recording-format.md` describes the layout.
"""

import base64
import binascii
import json
import struct
from dataclasses import dataclass
from typing import BinaryIO

import numpy as np
import zstandard

from adibas.arrays import IntArray
from adibas.recordings import mcap_records as mcap
from adibas.recordings.mcap_index import McapIndex
from adibas.recordings.mcap_records import Message, PackedChunk
from adibas.recordings.ports import MAX_TIMESTAMP_NS
from adibas.recordings.reading import DamagedError
from adibas.recordings.seal import PayloadSeal, SealError

FORMAT = "adibas-sealed-recording"
VERSION = "1"
INFO, END, TABLE = "info", "end", "table"
HEAD_CHANNEL, FRAME_CHANNEL = 1, 2
ENCODING = "adibas-sealed"
HEAD_FIELDS = struct.Struct("<QQ")
TABLE_COLUMNS = 2
N_BEFORE_HEAD = mcap.PREFIX.size + mcap.CHUNK_FIELDS.size + 4 + 8
"""Bytes of an uncompressed chunk before its first message."""
MAX_SEALED_HEAD = 256


@dataclass(frozen=True, slots=True)
class FrameHead:
    """What a list of frames needs of each."""

    sequence: int
    timestamp_ns: int


def _channel(number: int, topic: str) -> bytes:
    fields = struct.pack("<HH", number, 0) + mcap.text(topic) + mcap.text(ENCODING)
    return mcap.record(mcap.CHANNEL, fields + mcap.text_map({}))


REGISTRY = mcap.Registry(
    schemas=b"",
    channels=_channel(HEAD_CHANNEL, "/head") + _channel(FRAME_CHANNEL, "/frame"),
    n_schemas=0,
    n_channels=2,
)


def is_sealed(info_texts: dict[str, str]) -> bool:
    """Tell a sealed recording by the texts in its first metadata record."""
    return info_texts.get("format") == FORMAT


def seal_texts(seal: PayloadSeal, name: str, texts: dict[str, str]) -> dict[str, str]:
    """Return `texts` sealed for the place `name`, as texts for a metadata record."""
    sealed = seal.seal(name, json.dumps(texts).encode())
    return {"format": FORMAT, "version": VERSION, "sealed": _as_text(sealed)}


def seal_end(seal: PayloadSeal, texts: dict[str, str], heads: list[FrameHead]) -> dict[str, str]:
    """Return the end's `texts` and a table of all frames, sealed, as texts of a metadata record."""
    rows = np.array([(head.sequence, head.timestamp_ns) for head in heads], "<i8")
    steps = np.diff(rows.reshape(-1, TABLE_COLUMNS), axis=0, prepend=0)
    table = zstandard.ZstdCompressor(level=1).compress(steps.tobytes())
    sealed = seal_texts(seal, END, texts)
    return sealed | {"n_frames": str(len(heads)), "table": _as_text(seal.seal(TABLE, table))}


def seal_chunk(seal: PayloadSeal, index: int, head: FrameHead, packed: PackedChunk) -> PackedChunk:
    """Return frame `index` as an uncompressed chunk of two sealed messages."""
    pieces = (
        (HEAD_CHANNEL, "head", HEAD_FIELDS.pack(head.sequence, head.timestamp_ns)),
        (FRAME_CHANNEL, "frame", packed.content),
    )
    messages = [
        Message(channel, index, index, index, seal.seal(f"{name}/{index}", payload))
        for channel, name, payload in pieces
    ]
    return mcap.pack_chunk(messages, None)


def open_chunk(seal: PayloadSeal, index: int, messages: list[Message]) -> list[Message]:
    """Return the messages of frame `index` out of those of a sealed chunk.

    Raises
    ------
    DamagedError
        They were sealed under another key or for another frame, or were changed since.
    """
    sealed = {message.channel: message.data for message in messages}
    if FRAME_CHANNEL not in sealed:
        raise DamagedError("a chunk without a sealed frame")
    content = seal.open(f"frame/{index}", sealed[FRAME_CHANNEL])
    return mcap.messages_of(mcap.unpack_chunk(content))


def open_index(seal: PayloadSeal, index: McapIndex, file: BinaryIO) -> None:
    """Fill `index` with what is sealed in `file`: description, end, numbers and times.

    Raises
    ------
    SealError
        The recording is not sealed, was sealed under another key, or its end was changed.
    """
    index.info_texts = _open_texts(seal, INFO, index.info_texts)
    if index.sequences is not None:
        _open_heads(seal, index, file)
        return
    end = index.end_texts
    index.end_texts = _open_texts(seal, END, end)
    n_frames = len(index.starts)
    if index.end_texts.get("n_frames") != str(n_frames):
        raise SealError("frames were added or removed")
    index.times_ns = _open_table(seal, end.get("table", ""), n_frames)[:, 1].tolist()


def _open_texts(seal: PayloadSeal, name: str, texts: dict[str, str]) -> dict[str, str]:
    if not is_sealed(texts) or texts.get("version") != VERSION:
        raise SealError("not sealed, or by a later version")
    opened = json.loads(seal.open(name, _from_text(texts.get("sealed", ""))))
    return {str(key): str(value) for key, value in opened.items()}


def _open_table(seal: PayloadSeal, text: str, n_frames: int) -> IntArray:
    """Return (n_frames, 2) numbers and times."""
    packed = seal.open(TABLE, _from_text(text))
    steps = mcap.unpack_zstd(packed, n_frames * TABLE_COLUMNS * 8) if n_frames else b""
    rows: IntArray = np.frombuffer(steps, "<i8").reshape(-1, TABLE_COLUMNS).cumsum(axis=0)
    return rows


def _open_heads(seal: PayloadSeal, index: McapIndex, file: BinaryIO) -> None:
    """Take numbers and times of a cut file from its frames; the first bad one ends it."""
    heads: list[FrameHead] = []
    for number, start in enumerate(index.starts):
        try:
            heads.append(_read_head(seal, number, file, start))
        except DamagedError:
            index.n_lost_bytes = file.seek(0, 2) - start
            break
    del index.starts[len(heads) :]
    index.sequences = [head.sequence for head in heads]
    index.times_ns = [min(head.timestamp_ns, MAX_TIMESTAMP_NS) for head in heads]


def _read_head(seal: PayloadSeal, number: int, file: BinaryIO, start: int) -> FrameHead:
    file.seek(start + N_BEFORE_HEAD)
    prefix = file.read(mcap.PREFIX.size)
    length = mcap.check_opcode(prefix, mcap.MESSAGE)
    if length > MAX_SEALED_HEAD:
        raise DamagedError("a head is too long")
    sealed = file.read(length)[mcap.MESSAGE_FIELDS.size :]
    return FrameHead(*HEAD_FIELDS.unpack(seal.open(f"head/{number}", sealed)))


def _as_text(data: bytes) -> str:
    return base64.b64encode(data).decode()


def _from_text(text: str) -> bytes:
    try:
        return base64.b64decode(text, validate=True)
    except (binascii.Error, ValueError) as error:
        raise SealError("a sealed text is damaged") from error
