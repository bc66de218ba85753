"""Debian's real PostgreSQL, on loopback alone, in a folder of its own, never as root."""

import os
import pwd
import secrets
import shutil
import subprocess
import tempfile
from dataclasses import dataclass, field
from pathlib import Path

import pytest

from adibas.sessions.server_address import ServerAddress
from tests.unit.loopback import free_port, make_certificate

NEEDED = ("initdb", "pg_ctl", "postgres", "psql")
_PLACES = [
    *sorted(Path("/usr/lib/postgresql").glob("*/bin"), reverse=True),
    *(Path(found).parent for found in [shutil.which("initdb")] if found),
]
PROGRAMS = next((one for one in _PLACES if all((one / name).exists() for name in NEEDED)), None)
MISSING = "PostgreSQL is missing: apt-get install postgresql"
OWNER = "postgres"
"""Who runs the server where the tests run as root, as whom it refuses."""
USER = "adibas"
OTHER = "127.0.0.2"
"""Also this computer, but not one of the names of loopback: here TLS is asked for."""


@dataclass
class Postgres:
    """A server that can be started, killed and started again.

    Attributes
    ----------
    folder : Path
        Its data, log and socket; belongs to whoever runs it.
    """

    folder: Path
    port: int
    password: str = field(default_factory=lambda: secrets.token_hex(8))

    def address(self, database, **more):
        fields = {"host": "127.0.0.1", "port": self.port, "user": USER} | more
        return ServerAddress(database=database, **fields)

    def make_database(self, name):
        self.ask("postgres", f"CREATE DATABASE {name}")
        return self.address(name)

    def ask(self, database, statement):
        """Return what somebody with the server's password and without the store's key reads."""
        told = ("-h", "127.0.0.1", "-p", str(self.port), "-U", USER, "-d", database)
        return self._run("psql", *told, "-At", "-c", statement)

    def start(self):
        log = ("-l", str(self.folder / "log"))
        self._run("pg_ctl", "-D", str(self.folder / "data"), *log, "-w", "-t", "60", "start")

    def kill(self):
        """End it at once, as when the power fails: connections break, nothing is written."""
        data = str(self.folder / "data")
        self._run("pg_ctl", "-D", data, "-w", "-t", "60", "-m", "immediate", "stop")

    def _run(self, program, *arguments):
        command = [str(PROGRAMS / program), *arguments]
        done = subprocess.run(
            command,
            env={**os.environ, "LC_ALL": "C.UTF-8", "PGPASSWORD": self.password},
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE if program == "psql" else subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
            cwd=self.folder,
            check=True,
            text=True,
            **_as_owner(),
        )
        return done.stdout


def start():
    """Make a server and start it."""
    folder = Path(tempfile.mkdtemp(prefix="adibas-postgres-"))
    if os.geteuid() == 0:
        owner = pwd.getpwnam(OWNER)
        os.chown(folder, owner.pw_uid, owner.pw_gid)
    server = Postgres(folder, free_port())
    secret = folder / "password"
    secret.write_text(server.password)
    secret.chmod(0o644)
    data = folder / "data"
    options = ("--auth=scram-sha-256", f"--pwfile={secret}", "--encoding=UTF8", "--locale=C.UTF-8")
    server._run("initdb", "-D", str(data), "-U", USER, *options)
    with (data / "postgresql.conf").open("a") as settings:
        settings.write(
            f"port = {server.port}\nlisten_addresses = '127.0.0.1,{OTHER}'\nssl = on\n"
            f"unix_socket_directories = '{folder}'\nmax_connections = 20\nfsync = off\n"
        )
    with (data / "pg_hba.conf").open("a") as rules:
        rules.write(f"host all all {OTHER}/32 scram-sha-256\n")
    _make_certificate(data)
    server.start()
    return server


def _make_certificate(data):
    files = data / "server.key", data / "server.crt"
    make_certificate(OTHER, *files)
    if os.geteuid() == 0:
        owner = pwd.getpwnam(OWNER)
        for one in files:
            os.chown(one, owner.pw_uid, owner.pw_gid)


@pytest.fixture(scope="module")
def server():
    """A server for the tests of one module."""
    started = start()
    yield started
    started.kill()
    shutil.rmtree(started.folder)


def _as_owner():
    if os.geteuid() != 0:
        return {}
    owner = pwd.getpwnam(OWNER)
    return {"user": owner.pw_uid, "group": owner.pw_gid, "extra_groups": []}
