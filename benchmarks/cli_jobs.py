"""The main jobs of the command line, one after the other, in the folder that is the argument.

Prints the exit code of each as JSON.
"""

import json
import os
import sys
from pathlib import Path

N_FRAMES = 3


def jobs(folder: Path) -> dict[str, list[str]]:
    """Return the words of each command; files lie in `folder`, which the demo fills."""
    demo = folder / "demo"
    store = ["--store", str(demo / "store")]
    posture = ["posture", str(demo / "recording.mcap"), "--markers", str(demo / "colours.json")]
    return {
        "demo": ["demo", "--out", str(demo)],
        "record": ["record", "simulator", "--seconds", "0.3", "--out", str(folder / "r.mcap")],
        **{
            f"report {end}": [*posture, "--out", str(folder / f"report.{end}")]
            for end in ("xlsx", "pdf")
        },
        "convert to oni": ["convert", str(folder / "r.mcap"), str(folder / "r.oni")],
        "convert to folder": ["convert", str(folder / "r.mcap"), str(folder / "r")],
        "ethogram": ["coding", "ethogram", "--out", str(folder / "ethogram.json")],
        "verify": ["sessions", "verify", *store],
        "back up": ["sessions", "backup", "--out", str(folder / "a.adibas-backup"), *store],
        "list": ["sessions", "list", *store],
        "doctor": ["doctor"],
    }


def jobs_of_session(folder: Path, session: str) -> dict[str, list[str]]:
    """Return the words of what is done with the demo's session."""
    store = ["--store", str(folder / "demo" / "store")]
    return {
        "export": ["sessions", "export", session, "--out", str(folder / "exported"), *store],
        "fhir": ["export", "fhir", session, "--out", str(folder / "a.json"), *store],
        "dicom": ["export", "dicom", session, "--out", str(folder / "dicom"), *store],
    }


def main() -> None:
    """Run them."""
    folder = Path(sys.argv[1])
    from adibas.cli import main as run
    from adibas.cli.demo import PASSPHRASE
    from adibas.pipeline import demo

    demo.N_FRAMES = N_FRAMES
    os.environ["ADIBAS_PASSPHRASE"] = PASSPHRASE
    codes = {name: run(words) for name, words in jobs(folder).items()}
    codes |= {name: run(words) for name, words in jobs_of_session(folder, _session(folder)).items()}
    (folder / "codes.json").write_text(json.dumps(codes))


def _session(folder: Path) -> str:
    from adibas.sessions import open_store

    with open_store(folder / "demo" / "store", os.environ["ADIBAS_PASSPHRASE"]) as store:
        (patient,) = store.patients.search("")
        (session,) = store.sessions.of_patient(patient.pseudonym)
        return session.session_id


if __name__ == "__main__":
    main()
