"""The set-up says what it may not do, and does again only what is missing."""

import os
import shutil
import subprocess
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
PACKAGE_LIST = ROOT / "installers" / "debian-packages.txt"


def logging_python(log):
    """Return a Python that makes environments, whose Pythons write what they are told to a log."""
    return (
        'if [ "$1" = -c ]; then exit 0; fi\n'
        'mkdir -p "$3/bin"\n'
        f'printf \'#!/bin/sh\\necho "$0 $@" >>{log}\\n\' >"$3/bin/python"\n'
        'chmod +x "$3/bin/python"'
    )


def package_names(text):
    return [line for line in text.splitlines() if line and not line.startswith("#")]


@pytest.fixture
def machine(tmp_path):
    """A copy of the set-up in an empty tree, on a machine whose commands are all our own."""
    tree, commands = tmp_path / "tree", tmp_path / "commands"
    commands.mkdir()
    shutil.copytree(ROOT / "installers", tree / "installers")
    shutil.copy(ROOT / "pyproject.toml", tree)
    for name in ("sh", "sed", "cat", "cksum", "dirname", "env", "mkdir", "chmod"):
        (commands / name).symlink_to(shutil.which(name))

    def add_command(name, script):
        (commands / name).write_text(f"#!/bin/sh\n{script}\n")
        (commands / name).chmod(0o755)

    def run(*arguments):
        return subprocess.run(
            [str(tree / "installers" / "setup.sh"), *arguments],
            env={"PATH": str(commands), "HOME": os.environ["HOME"]},
            capture_output=True,
            text=True,
            check=False,
        )

    return add_command, run, tree


@pytest.mark.parametrize("extra", ["", "installer", "ci"])
def test_where_it_may_not_install_it_tells_the_one_command(machine, extra):
    add_command, run, _tree = machine
    add_command("dpkg-query", "exit 1")
    add_command("id", "echo 1000")
    result = run(*[extra] * bool(extra))
    assert result.returncode == 1
    command = result.stderr.splitlines()[-1].strip()
    assert command.startswith("sudo apt-get update && sudo apt-get install -y ")
    always, others = PACKAGE_LIST.read_text().split("# Installer")
    for_installers, for_ci = others.split("# CI")
    only = {"": "", "installer": for_installers, "ci": for_ci}[extra]
    assert command.split()[8:] == package_names(always) + package_names(only)[1:]


def test_as_root_it_refreshes_the_index_and_installs_what_is_missing(machine, tmp_path):
    add_command, run, _tree = machine
    log = tmp_path / "log"
    add_command("dpkg-query", 'case "$4" in libgl1) exit 1;; *) echo installed;; esac')
    add_command("id", "echo 0")
    add_command("apt-get", f'echo "$@" >>{log}')
    add_command("python3", "exit 1")
    result = run()
    assert result.returncode == 1
    assert "No Python 3.11, 3.12 or 3.13 was found" in result.stderr
    assert log.read_text().splitlines() == [
        "-q update",
        "-q install -y --no-install-recommends libgl1",
    ]


def test_a_second_run_installs_nothing(machine, tmp_path):
    add_command, run, _tree = machine
    log = tmp_path / "log"
    add_command("dpkg-query", "echo installed")
    add_command("python3", logging_python(log))
    assert run().returncode == 0
    calls = log.read_text().splitlines()
    assert len(calls) == 2
    assert "--no-deps --require-hashes" in calls[0]
    assert "--no-deps --no-build-isolation -e ." in calls[1]
    assert run().returncode == 0
    assert log.read_text().splitlines() == calls


def test_ci_has_boris_in_an_environment_of_its_own(machine, tmp_path):
    add_command, run, tree = machine
    log = tmp_path / "log"
    add_command("dpkg-query", "echo installed")
    add_command("python3", logging_python(log))
    assert run("ci").returncode == 0
    calls = log.read_text().splitlines()
    assert [call.split()[0] for call in calls] == [".venv/bin/python"] * 2 + [
        ".venv-boris/bin/python"
    ]
    assert "--no-deps --require-hashes -r installers/boris.lock" in calls[2]
    assert run("ci").returncode == 0
    assert log.read_text().splitlines() == calls
    assert (tree / ".venv-boris").is_dir()


@pytest.mark.parametrize("name", ["requirements.lock", "boris.lock"])
def test_the_lock_names_no_index_and_hashes_everything(name):
    lock = (ROOT / "installers" / name).read_text()
    assert "://" not in lock
    assert "index-url" not in lock
    requirements = [line for line in lock.splitlines() if "==" in line]
    assert all(line.endswith("\\") for line in requirements)
