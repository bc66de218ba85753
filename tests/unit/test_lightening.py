"""What leaves the built folder is missed by nothing that stays; the folder itself is not built."""

import ctypes
import json
import os
import shutil
import struct
import subprocess
import sys
from importlib.metadata import version
from importlib.util import find_spec
from pathlib import Path

import PySide6
import pytest

from installers import icu, lightening, llvm, stand_ins

LINUX = sys.platform == "linux" and lightening.is_for_this_machine()
on_linux = pytest.mark.skipif(not LINUX, reason="changes libraries of Linux")
QT_LIBRARIES = Path(PySide6.__file__).parent / "Qt" / "lib"
WORDS_AND_CODES = """
from functools import cmp_to_key
from PySide6.QtCore import QCollator, QLocale, QStringDecoder

words = ["nz", "\\u00f1u", "oso", "\\u00e9l", "eco", "\\u00e7\\u00e0", "cz", "l\\u00b7l", "lz"]
for language in ("en_GB", "es_ES", "ca_ES", "pt_BR", "de_DE"):
    order = cmp_to_key(QCollator(QLocale(language)).compare)
    print(ascii(sorted(words, key=order)), ascii(QLocale(language).toUpper("stra\\u00dfe")))
for code in ("ISO-8859-15", "windows-1252", "windows-1251", "KOI8-R"):
    print(code, QStringDecoder(code).isValid())
"""


def say(*command, **more):
    return subprocess.run(command, capture_output=True, text=True, check=True, **more).stdout


def compiled(path, text, *options):
    name = f"-Wl,-soname,{path.name}"
    command = ["gcc", "-shared", "-fPIC", name, "-o", path, "-x", "c", "-", "-x", "none", *options]
    say(*command, input=text)
    return path


@on_linux
def test_qt_orders_words_and_reads_codes_with_the_short_data_as_with_the_whole(
    tmp_path,
):
    place = tmp_path / "PySide6/Qt/lib"
    place.mkdir(parents=True)
    (whole,) = QT_LIBRARIES.glob("libicudata.so.*")
    shutil.copy(whole, place)
    icu.shorten(tmp_path)
    assert (place / whole.name).stat().st_size < whole.stat().st_size / 7
    asked = [sys.executable, "-c", WORDS_AND_CODES]
    long = say(*asked)
    assert say(*asked, env={**os.environ, "LD_LIBRARY_PATH": str(place)}) == long
    spanish, catalan = (eval(line.split("] ")[0] + "]") for line in long.splitlines()[1:3])
    assert spanish.index("\xf1u") > spanish.index("nz")  # a letter of its own
    assert catalan.index("\xf1u") < catalan.index("nz")  # an n with a mark


@pytest.mark.parametrize(
    ("name", "is_needed"),
    [
        ("icudt73l/coll/root.res", True),
        ("icudt73l/coll/es.res", True),
        ("icudt73l/pt_BR.res", True),
        ("icudt73l/coll/zh.res", False),
        ("icudt73l/estonian.res", True),  # no name of a language: it is of all
        ("icudt73l/et.res", False),
        ("icudt73l/coll/res_index.res", True),
        ("icudt73l/zone/pool.res", True),
        ("icudt73l/brkitr/root.res", False),
        ("icudt73l/unames.icu", False),
        ("icudt73l/rfc3491.spp", False),
        ("icudt73l/confusables.cfu", False),
        ("icudt73l/uts46.nrm", True),
        ("icudt73l/coll/ucadata.icu", True),
        ("icudt73l/ibm-5348_P100-1997.cnv", True),
    ],
)
def test_tables_of_other_languages_go_and_those_of_all_stay(name, is_needed):
    assert icu.is_needed(name, 9000) == is_needed


def test_data_of_another_form_is_not_touched():
    with pytest.raises(ValueError, match="another form"):
        icu.with_tables(struct.pack("<H2s", 4, b"??") + bytes(8))


@on_linux
def test_a_stand_in_has_the_names_that_are_asked_for_and_finds_nothing(tmp_path):
    (tmp_path / "versions").write_text("FILM_62 { global: *; };\n")
    film = compiled(
        tmp_path / "libfilm.so.62",
        "int seven(void) { return 7; }\nint unasked(void) { return 8; }\n",
        f"-Wl,--version-script={tmp_path / 'versions'}",
    )
    here = [film, "-Wl,-rpath,$ORIGIN", "-Wl,-z,now"]
    text = "int seven(void);\nint ask(void) { return 35 + seven(); }\n"
    user = compiled(tmp_path / "user.so", text, *here)
    names = stand_ins.asked_names([user], film)
    assert names == {"seven": "FILM_62"}
    stand_ins.link(film, [stand_ins.NOTHING.format(name="seven")], names)
    assert ctypes.CDLL(str(user)).ask() == 35
    assert not hasattr(ctypes.CDLL(str(film)), "unasked")


@on_linux
def test_what_opencv_calculates_goes_to_the_library_of_scipy(tmp_path):
    for folder in (stand_ins.OPENCV, "scipy.libs", "cv2"):
        (tmp_path / folder).mkdir()
    text = "double scipy_cblas_ddot(double a, double b) { return a * b; }\n"
    compiled(tmp_path / "scipy.libs/libscipy_openblas-1.so", text)
    blas = tmp_path / stand_ins.OPENCV / "libopenblasp-2.so"
    compiled(blas, "double cblas_ddot(double a, double b) { return 0; }\n")
    text = "double cblas_ddot(double, double);\ndouble ask(double a) { return cblas_ddot(a, 6); }\n"
    user = compiled(tmp_path / "cv2/cv2.so", text, blas, f"-Wl,-rpath,{blas.parent}")
    stand_ins.lead_to(tmp_path, [user])
    ask = ctypes.CDLL(str(user)).ask
    ask.restype, ask.argtypes = ctypes.c_double, [ctypes.c_double]
    assert ask(7.0) == 42.0


@on_linux
def test_the_wheels_hold_every_library_that_a_stand_in_replaces():
    site = Path(PySide6.__file__).parents[1]
    patterns = (*stand_ins.EMPTY, *stand_ins.ORPHANS, *stand_ins.USERS, stand_ins.BLAS)
    assert [pattern for pattern in patterns if not list(site.glob(pattern))] == []
    asked = stand_ins.asked_names(site.glob("cv2/*.so"), next(site.glob(stand_ins.BLAS)))
    shared = stand_ins.asked_names(
        site.glob("scipy/linalg/*.so"), next(site.glob(stand_ins.SHARED_BLAS))
    )
    assert asked
    assert shared
    given = say("nm", "-D", "--defined-only", next(site.glob(stand_ins.SHARED_BLAS))).split()
    assert {stand_ins.PREFIX + name for name in asked} <= set(given)


def test_dicom_files_are_described_by_the_tables_that_stay():
    from pydicom.uid import ComprehensiveSRStorage, SecondaryCaptureImageStorage

    folder = Path(find_spec("highdicom").origin).parent / "_standard"
    kinds = json.loads((folder / "sop_class_iod_map.json").read_text())
    written = {kinds[uid] for uid in (ComprehensiveSRStorage, SecondaryCaptureImageStorage)}
    assert written == set(lightening.KINDS_OF_FILES)


def test_attributes_of_other_kinds_of_files_go():
    modules = {"report": [{"key": "patient"}, {"key": "text"}], "scan": [{"key": "dose"}]}
    attributes = {"patient": [1], "text": [2], "dose": [3]}
    kept = lightening.attributes_of(["report"], modules, attributes)
    assert kept == {"patient": [1], "text": [2]}


def test_the_tables_that_stay_say_of_the_files_written_what_the_whole_ones_say(tmp_path):
    names = ("iod_module_map.json", "module_attribute_map.json")
    for name in names:
        shutil.copy(Path(find_spec("highdicom").origin).parent / "_standard" / name, tmp_path)
    whole = [json.loads((tmp_path / name).read_text()) for name in names]
    lightening.shorten_tables(tmp_path)
    modules, attributes = (json.loads((tmp_path / name).read_text()) for name in names)
    assert modules == {kind: whole[0][kind] for kind in lightening.KINDS_OF_FILES}
    used = {module["key"] for kind in modules.values() for module in kind}
    assert attributes == {name: found for name, found in whole[1].items() if name in used}


def test_a_file_that_is_there_twice_is_a_link_that_survives_moving_the_folder(tmp_path):
    folder, content = tmp_path / "built", os.urandom(lightening.SMALLEST_DUPLICATE)
    for name in ("a/one", "b/deep/two", "b/other"):
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / name).write_bytes(content[:-1] + name[-1:].encode())
    (folder / "b/deep/two").write_bytes((folder / "a/one").read_bytes())
    lightening.link_duplicates(folder)
    moved = folder.rename(tmp_path / "installed")
    assert (moved / "b/deep/two").is_symlink()
    assert (moved / "b/deep/two").read_bytes() == (moved / "a/one").read_bytes()
    assert not (moved / "b/other").is_symlink()


def test_the_source_of_llvmlite_is_the_locked_release_with_its_sums():
    lock = llvm.LOCK.read_text(encoding="utf-8")
    first, *sums = llvm.locked_requirement(lock, "llvmlite").splitlines()
    assert first == f"llvmlite=={version('llvmlite')} \\"
    assert len(sums) > 1
    assert all(line.strip().startswith("--hash=sha256:") for line in sums)
    assert not sums[-1].endswith("\\")
