"""Reads a project with BORIS, in whose environment this runs; prints what BORIS makes of it.

Its window and its player are left out, since both want libraries that reading does not.
"""

import importlib.util
import json
import sys
import types

found = importlib.util.find_spec("boris")
if found is None or found.submodule_search_locations is None:
    raise SystemExit("BORIS is not in this environment.")
package = types.ModuleType("boris")
package.__path__ = list(found.submodule_search_locations)
player = types.ModuleType("boris.mpv2")
player.dll = ""
sys.modules |= {"boris": package, "boris.mpv2": player}

from boris import config, db_functions, project_functions, time_budget_functions  # noqa: E402

NO_FOCUS = "No focal subject"
EVENTS = "SELECT {} FROM aggregated_events ORDER BY observation, subject, behavior, start, stop"
COLUMNS = ("observation", "subject", "behavior", "type", "modifiers")
TIMES = ("start", "stop", "comment", "comment_stop")


def told(path):
    """Return what BORIS finds wrong, the events as it pairs them, and its time budgets."""
    _, _, project, problem = project_functions.open_project_json(path)
    names = list(project["observations"])
    cancelled, usable = project_functions.check_state_events(project, names)
    wrong = project_functions.check_project_integrity(
        project, project["time_format"], path, media_file_available=False
    )
    subjects = [NO_FOCUS, *(one["name"] for one in project["subjects_conf"].values())]
    behaviours = [one["code"] for one in project["behaviors_conf"].values()]
    _, _, database = db_functions.load_aggregated_events_in_db(project, subjects, names, behaviours)
    chosen = {
        config.SELECTED_SUBJECTS: subjects,
        config.SELECTED_BEHAVIORS: behaviours,
        config.INCLUDE_MODIFIERS: False,
        config.EXCLUDE_BEHAVIORS: True,
    }
    ethogram = project["behaviors_conf"]
    budgets = []
    for name in names:
        cursor = db_functions.load_events_in_db(project, subjects, [name], behaviours)
        rows, _ = time_budget_functions.time_budget_analysis(ethogram, cursor, [name], chosen)
        budgets += [{"observation": name, **row} for row in rows]
    return {
        "problem": problem or wrong,
        "usable": [] if cancelled else list(usable),
        "events": [
            dict(zip((*COLUMNS, *TIMES), row, strict=True))
            for row in database.execute(EVENTS.format(", ".join((*COLUMNS, *TIMES))))
        ],
        "budgets": budgets,
    }


if __name__ == "__main__":
    sys.stdout.write(json.dumps(told(sys.argv[1])))
