"""Kill -9 while people are added and removed: the administrator is never shut out."""

import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from adibas.errors import PassphraseError
from adibas.sessions import open_store
from adibas.sessions.roles import Role
from tests.end_to_end.people_victim import CHEAP

ANNA = "anna has a long one"
N_KILLS = 8


def kill_after(folder, n_changes, seconds):
    """Let a program change people and kill it; give the last change it said it saved."""
    command = [sys.executable, "-m", "tests.end_to_end.people_victim", str(folder), ANNA]
    root = Path(__file__).parents[2]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True, cwd=root) as victim:
        said = [victim.stdout.readline() for _ in range(n_changes)]
        try:
            victim.wait(seconds)
        except subprocess.TimeoutExpired:
            victim.kill()
        said += victim.stdout.readlines()
    return said[-1].split()


@pytest.mark.parametrize("seed", range(N_KILLS))
def test_a_kill_leaves_the_people_of_before_or_after_a_change(tmp_path, seed):
    folder, rng = tmp_path / "store", np.random.default_rng(seed)
    with open_store(folder, "before all people", key_params=CHEAP) as store:
        store.people.add("Anna", Role.ADMINISTRATOR, ANNA, CHEAP)
    what, number = kill_after(folder, int(rng.integers(1, 6)), float(rng.uniform(0.0, 0.03)))
    with open_store(folder, ANNA) as store:
        others = {one.name for one in store.people.all()} - {"Anna"}
        assert store.verify().is_sound
    last, following = {f"person {number}"}, {f"person {int(number) + 1}"}
    assert others in ((last, set()) if what == "added" else (set(), following))
    for name in others:
        open_store(folder, f"the words of {name.split()[1]}").close()
    with pytest.raises(PassphraseError):
        open_store(folder, "before all people")
