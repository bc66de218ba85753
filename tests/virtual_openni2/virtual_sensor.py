"""A virtual OpenNI2 sensor, built on the spot, in an OpenNI2 folder of its own.

OpenNI2 can be loaded once in a process, so that every look at the sensor is a process of its own.
"""

import json
import os
import shutil
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path

import numpy as np

INFRARED, COLOR, DEPTH = 1, 2, 3
DEPTH_1_MM, DEPTH_100_UM, RGB888, GRAY16 = 100, 101, 200, 203
PROJECT = Path(__file__).parents[2]
N_IMAGES = 4

# Type, format, width, height, frames/s: what a PrimeSense sensor offers of use to us.
MODES = (
    (DEPTH, DEPTH_1_MM, 320, 240, 30),
    (DEPTH, DEPTH_1_MM, 640, 480, 30),
    (DEPTH, DEPTH_100_UM, 640, 480, 30),
    (COLOR, RGB888, 640, 480, 30),
    (COLOR, RGB888, 1280, 1024, 10),
    (INFRARED, GRAY16, 640, 480, 30),
)


def build_openni2(folder):
    """Make an OpenNI2 folder with the virtual driver and the player of .oni files."""
    drivers = folder / "OpenNI2" / "Drivers"
    drivers.mkdir(parents=True)
    system = next(Path("/usr/lib").glob("*/libOpenNI2.so.0")).parent
    (folder / "libOpenNI2.so").symlink_to(system / "libOpenNI2.so.0")
    shutil.copy(system / "OpenNI2" / "Drivers" / "libOniFile.so.0", drivers)
    source = Path(__file__).with_name("driver.cpp")
    flags = ["-O1", "-std=c++17", "-shared", "-fPIC", "-pthread", "-I/usr/include/openni2"]
    library = drivers / "libVirtual.so.0"  # Debian loads only names that end like this
    subprocess.run(["g++", *flags, str(source), "-o", str(library)], check=True)
    return folder


def write_dump(path, rng):
    """Write random images of every mode; return them as arrays by mode."""
    images = {}
    with path.open("wb") as file:
        for mode in MODES:
            sensor, _, width, height, _ = mode
            file.write(np.array([*mode, N_IMAGES], np.int32).tobytes())
            shape = (N_IMAGES, height, width)
            if sensor == COLOR:
                images[mode] = rng.integers(0, 256, (*shape, 3), np.uint8)
            else:
                images[mode] = rng.integers(0, 10_000, shape, np.uint16)
            file.write(images[mode].tobytes())
    return images


@dataclass
class VirtualSensor:
    """One dump, served by the virtual driver; files beside it say what befalls the sensor."""

    library: Path
    dump: Path

    def tell(self, what):
        self.control(what).touch()

    def control(self, what):
        return Path(f"{self.dump}.{what}")

    def run(self, script, timeout_s=60, allowed=""):
        """Run `script`, which calls give(name=value, ...); return what it gave.

        Nothing may be told on stderr but lines that hold `allowed`.
        """
        prelude = (
            "import json, sys, time\nfrom pathlib import Path\nimport numpy as np\n"
            "from adibas.errors import AdibasError\n"
            "from adibas.sensors import SensorOptions, open_source\n"
            f"FOLDER, DUMP = Path({str(self.dump.parent)!r}), {str(self.dump)!r}\n"
            "def give(**what): print(json.dumps(what))\n"
        )
        environment = os.environ | {
            "OPENNI2_REDIST": str(self.library),
            "ADIBAS_VIRTUAL_SENSOR": str(self.dump),
            "NUMBA_NUM_THREADS": "1",
        }
        environment.pop("OPENNI2_REDIST64", None)
        run = subprocess.run(
            [sys.executable, "-W", "error", "-c", prelude + script],
            cwd=PROJECT,
            env=environment,
            capture_output=True,
            text=True,
            timeout=timeout_s,
            check=False,
        )
        assert run.returncode == 0, f"{run.returncode}\n{run.stdout}\n{run.stderr}"
        told = run.stderr.splitlines()
        assert [line for line in told if not (allowed and allowed in line)] == []
        given = {}
        for line in run.stdout.splitlines():
            given |= json.loads(line)
        return given
