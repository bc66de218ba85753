"""`adibas benchmark` finds what there is, and hands over how much of it is to be done."""

import json

import pytest

from adibas.cli import main
from benchmarks import accuracy_posture, reliability_kills
from benchmarks.posture_trial import Result
from benchmarks.table import Row


@pytest.fixture
def runs(monkeypatch):
    """Runs of a benchmark that does nothing, as they were asked for."""
    asked = []

    def rows(run):
        asked.append(run)
        run.progress(1, 2)
        yield Row("things lost", 0, "things", 0, "goal")

    monkeypatch.setattr(reliability_kills, "rows", rows)
    return asked


def test_an_amount_reaches_the_benchmark_of_reliability(runs, capsys):
    assert main(["benchmark", "reliability", "kills", "--amount", "12", "--json"]) == 0
    told = json.loads(capsys.readouterr().out)
    assert [row["name"] for row in told["results"]["kills"]] == ["things lost"]
    assert main(["benchmark", "reliability", "kills", "--quick"]) == 0
    assert [(run.is_quick, run.amount) for run in runs] == [(False, 12.0), (True, None)]


@pytest.mark.parametrize("amount", ["0", "-3", "nan", "many"])
def test_an_amount_that_is_none_is_refused(amount, capsys):
    with pytest.raises(SystemExit):
        main(["benchmark", "reliability", "kills", "--amount", amount])
    assert "--amount" in capsys.readouterr().err


def test_an_amount_of_accuracy_is_refused_and_unknown_names_are_told(capsys):
    assert main(["benchmark", "accuracy", "--amount", "3"]) == 1
    assert "for reliability alone" in capsys.readouterr().err
    assert main(["benchmark", "reliability", "nothing"]) == 1
    assert "kills" in capsys.readouterr().err


def test_the_posture_figures_stand_beside_the_published_ones(monkeypatch):
    one = Result(
        0, 15, 15, 0, [[0.001, 0.001, 0.3, 0.3]], [[0.01, 0.01, 0.3, 1.0]], [[0.01, 0.0, 0.3, 1.0]]
    )
    monkeypatch.setattr(accuracy_posture, "run_all", lambda *_asked: [one])
    published = {
        (row.reference_name, row.unit): (row.ours, row.reference)
        for row in accuracy_posture.rows(quick=True)
        if row.name.endswith("as published")
    }
    assert published["thesis", "%"] == (100.0, 76.3)
    assert published["thesis", "mm"] == (pytest.approx(1.0), 2.3)
    assert published["SAPO, on an object", "mm"] == (pytest.approx(1.0), 1.8)
    assert published["SAPO, on an object", "deg"] == (pytest.approx(0.573, abs=1e-3), 0.11)
    assert published["thesis", "deg"][1] == 3.7
