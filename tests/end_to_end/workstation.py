"""One workstation, as a process of its own: opens the shared store and edits what it is told.

`workstation.py FOLDER OPERATOR SESSION CAPTURE`; says "seen" when it has looked at both, waits for
a line with its task as JSON, and answers with a line of JSON.
"""

import json
import os
import sys
from dataclasses import replace
from pathlib import Path

from adibas.data.corrections import MarkerCorrection
from adibas.sessions import open_store
from adibas.sessions.conflicts import ConflictError, Decision


def main():
    folder, operator, session_id, capture_id = sys.argv[1:]
    password = os.environ["ADIBAS_SERVER_PASSWORD"]
    passphrase = os.environ["ADIBAS_PASSPHRASE"]
    with open_store(Path(folder), passphrase, operator=operator, server_password=password) as store:
        session, capture = store.sessions.get(session_id), store.captures.get(capture_id)
        print("seen", flush=True)  # noqa: T201  (for the test that waits)
        task = json.loads(sys.stdin.readline())
        conflicts = []
        for number in range(task["times"]):
            notes = {} if "notes" not in task else {"notes": task["notes"]}
            setup = replace(session.setup, **{task["field"]: task["values"][number % 2]})
            session = edited(
                conflicts,
                lambda decisions, notes=notes, setup=setup, seen=session: store.sessions.change(
                    session_id, **notes, setup=setup, seen=seen, decisions=decisions
                ),
            )
            capture = edited(
                conflicts,
                lambda decisions, seen=capture, number=number: store.captures.correct(
                    capture_id,
                    moved(seen, task["label"], task["u"] + number),
                    seen=seen.history,
                    decisions=decisions,
                ),
            )
        print(json.dumps(conflicts), flush=True)  # noqa: T201


def edited(conflicts, save):
    """Save something; where somebody else did, too, the saver's own version holds."""
    try:
        return save(())
    except ConflictError as error:
        conflicts += [
            [one.field, one.operator, shown(one.theirs), shown(one.mine)] for one in error.conflicts
        ]
        return save([Decision(one, "mine") for one in error.conflicts])


def shown(version):
    return version if isinstance(version, str) else version.u


def moved(capture, label, u):
    marker = next(one for one in capture.markers() if one.label == label)
    return capture.history.after(MarkerCorrection(marker, replace(marker, u=u)))


if __name__ == "__main__":
    main()
