"""What every camera offers to the rest of the program, and how a camera describes itself."""

from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal, Protocol, Self

from adibas.texts import Message, message

if TYPE_CHECKING:  # the window knows the options before it needs any array
    from adibas.data.frames import SensorFrame, SourceInfo

StreamName = Literal["depth", "color", "infrared"]
STREAM_TEXTS: dict[StreamName, Message] = {
    "depth": message("depth"),
    "color": message("colour"),
    "infrared": message("infrared"),
}

READ_TIMEOUT_S = 5.0
"""A live sensor gives a frame every 1/30 s; some need 2-3 s to start their projector."""


@dataclass(frozen=True, slots=True)
class VideoMode:
    """One way in which a sensor can deliver one of its streams.

    Attributes
    ----------
    stream : str
        ``depth``, ``color`` or ``infrared``.
    width, height : int
        Pixels.
    frame_rate_hz : float
        Nominal.
    pixel_format : str
        The library's own name, such as ``DEPTH_1_MM`` or ``RGB888``.
    """

    stream: StreamName
    width: int
    height: int
    frame_rate_hz: float
    pixel_format: str


@dataclass(frozen=True, slots=True)
class SensorDescription:
    """A sensor that is plugged in.

    Attributes
    ----------
    name, vendor, serial : str
        As the sensor says; empty where unknown.
    uri : str
        How its library addresses it.
    modes : tuple of VideoMode
        Everything it can deliver; empty where it could not be asked.
    """

    name: str
    vendor: str
    serial: str
    uri: str
    modes: tuple[VideoMode, ...] = ()


@dataclass(frozen=True, slots=True)
class SensorOptions:
    """How a source is opened; what a source cannot do is refused in words.

    Attributes
    ----------
    color_size : (int, int)
        Wished (width, height) of the colour image, pixels. 1280 x 1024 shows an 8 mm sticker at
        2 m on about four pixels, 640 x 480 on two.
    depth_unit_m : float
        Metres in one count of depth: 0.001 or 0.0001 (OpenNI2 sensors).
    is_depth_registered : bool
        Let the sensor itself move the depth into the colour image. Off: the program registers
        with its own calibration, which is more exact.
    is_infrared : bool
        Brightness of the depth camera in place of colour, for calibration.
    is_paced : bool
        Recordings and the simulator: give the frames at their own pace, not as fast as possible.
    seed : int
        Of the simulator's noise.
    """

    color_size: tuple[int, int] = (1280, 1024)
    depth_unit_m: float = 0.001
    is_depth_registered: bool = False
    is_infrared: bool = False
    is_paced: bool = False
    seed: int = 0


DEFAULT_OPTIONS = SensorOptions()


class DepthCamera(Protocol):
    """A source of frames: a sensor, a file of a sensor's library, a recording, the simulator.

    It belongs to one thread at a time. Adapters derive from it for the context manager.
    """

    @property
    def info(self) -> "SourceInfo":
        """What holds for every frame."""
        ...

    @property
    def is_live(self) -> bool:
        """True where frames that are not fetched in time are lost."""
        ...

    def read(self, timeout_s: float = READ_TIMEOUT_S) -> "SensorFrame | None":
        """Return the next frame; None where a finite source has ended.

        Raises
        ------
        SensorError
            The sensor was unplugged, or gave no frame within `timeout_s` seconds.
        """
        ...

    def close(self) -> None:
        """Give the sensor back; calling it twice does no harm."""
        ...

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_error: object) -> None:
        self.close()
