"""An analysis of behaviour as plain values for JSON."""

from dataclasses import asdict
from typing import Any

import numpy as np

from adibas.behaviour.activity import JointActivity
from adibas.behaviour.budget import Budget, budgets, conditions, time_bins, transitions
from adibas.data.coding import MS_PER_S, Coding
from adibas.data.joints import JOINT_NAMES
from adibas.pipeline.behaviour import BehaviourAnalysis
from adibas.pipeline.behaviour_activity import PersonActivity


def behaviour_to_json(analysis: BehaviourAnalysis) -> dict[str, Any]:
    """Return the document of ``adibas behaviour --json``."""
    codings = [one for one in (analysis.observed, analysis.detected) if one is not None]
    return {
        "recording": analysis.recording,
        "recordings": list(analysis.parts or (analysis.recording,)),
        "patient": analysis.patient,
        "begin_s": analysis.detected.begin_ms / MS_PER_S,
        "end_s": analysis.detected.end_ms / MS_PER_S,
        "people": [_person(person) for person in analysis.people],
        "codings": [coding_to_json(coding, analysis.bin_ms) for coding in codings],
        "notices": [notice.text for notice in analysis.notices],
        "provenance": asdict(analysis.provenance),
    }


def coding_to_json(coding: Coding, bin_ms: int) -> dict[str, Any]:
    """Return a coding with its totals, bins, conditions and transitions."""
    return {
        "observer": coding.observer,
        "observed_s": coding.duration_ms / MS_PER_S,
        "totals": [_budget(one) for one in budgets(coding)],
        "conditions": {
            one.name: {
                "observed_s": one.observed_ms / MS_PER_S,
                "totals": [_budget(part) for part in one.budgets],
            }
            for one in conditions(coding)
        },
        "bins": [
            {
                "begin_s": one.begin_ms / MS_PER_S,
                "end_s": one.end_ms / MS_PER_S,
                "totals": [_budget(part) for part in one.budgets],
            }
            for one in time_bins(coding, bin_ms)
        ],
        "transitions": [
            {"subject": one.subject, "behaviours": list(one.behaviours), "counts": one.counts}
            for one in transitions(coding)
        ],
        "events": [
            {
                "behaviour": one.behaviour,
                "subject": one.subject,
                "begin_s": one.begin_ms / MS_PER_S,
                "end_s": one.end_ms / MS_PER_S,
                "modifiers": list(one.modifiers),
            }
            for one in coding.occurrences
        ],
    }


def _person(person: PersonActivity) -> dict[str, Any]:
    bands = person.bands
    return {
        "person": person.person,
        "joints": [_joint(one) for one in person.joints],
        "noise_mm": {
            name: _known(1000.0 * float(noise_m))
            for name, noise_m in zip(JOINT_NAMES, person.steps.noise_m, strict=True)
        },
        "conditions": {
            name: [_joint(one) for one in joints] for name, joints in person.by_condition
        },
        "band_edges_hz": bands.edges_hz.tolist(),
        "band_power_m2_s2": {
            name: [_known(power) for power in row]
            for name, row in zip(JOINT_NAMES, bands.power.tolist(), strict=True)
        },
    }


def _joint(one: JointActivity) -> dict[str, Any]:
    return {**asdict(one), "active_share": one.active_share}


def _budget(one: Budget) -> dict[str, Any]:
    return {
        "subject": one.subject,
        "behaviour": one.behaviour,
        "kind": "state" if one.is_state else "point",
        "count": one.count,
        "per_minute": one.per_minute,
        "total_s": one.total_ms / MS_PER_S if one.is_state else None,
        "share": one.share,
        "mean_s": None if one.mean_ms is None else one.mean_ms / MS_PER_S,
        "first_after_s": None if one.latency_ms is None else one.latency_ms / MS_PER_S,
        "observed_s": one.observed_ms / MS_PER_S,
    }


def _known(value: float) -> float | None:
    return value if np.isfinite(value) else None
