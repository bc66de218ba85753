"""Joints found without markers as files, every one of them marked so."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from adibas.data.joints import JOINT_NAMES
from adibas.data.movement import Origin
from adibas.data.skeleton_track import SkeletonTrack
from adibas.pipeline.person_facts import PersonFacts
from adibas.pipeline.pose import PosedRecording, movement_of
from adibas.recordings.joints_csv import write_joints_csv

ORIGIN: Origin = "markerless"
DIGITS = 4


def write_pose(posed: PosedRecording, path: Path, person: int) -> None:
    """Write a table of everybody's joints (CSV), or those of one person (TRC, C3D).

    Raises
    ------
    ReportError
        The format cannot hold so many frames.
    FileError
        The disk is full, or the folder cannot be written.
    """
    if path.suffix.lower() == ".csv":
        write_joints_csv(path, posed.tracks, ORIGIN, posed.up)
        return
    from adibas.reports.motion_files import write_c3d, write_trc

    write = write_trc if path.suffix.lower() == ".trc" else write_c3d
    write(movement_of(posed, person), path)


def pose_to_json(posed: PosedRecording, paths: Sequence[Path]) -> dict[str, Any]:
    """Return the document of ``adibas pose --json``."""
    provenance = posed.provenance
    return {
        "origin": ORIGIN,
        "out": [str(path) for path in paths],
        "frames": posed.n_frames,
        "lag_frames": posed.lag_frames,
        "lag_s": round(posed.lag_s, DIGITS),
        "people": [
            _person(track, facts) for track, facts in zip(posed.tracks, posed.facts, strict=True)
        ],
        "notices": [notice.text for notice in posed.notices],
        "provenance": {
            "recording_sha256": provenance.recording_sha256,
            "calibration": provenance.calibration,
            "version": provenance.version,
            "parameters": dict(provenance.parameters),
        },
    }


def _person(track: SkeletonTrack, facts: PersonFacts) -> dict[str, Any]:
    known = track.confidence[np.isfinite(track.confidence)]
    return {
        "person": track.person,
        "frames": len(track),
        "from_s": float(track.times_s[0]),
        "to_s": float(track.times_s[-1]),
        "stature_m": round(facts.stature_m, DIGITS),
        "front_share": round(facts.front_share, DIGITS),
        "view_confidence": round(facts.view_confidence, DIGITS),
        "against_share": round(facts.against_share, DIGITS),
        "sides_exchanged_frames": facts.n_exchanged,
        "mean_confidence": round(float(known.mean()), DIGITS) if len(known) else None,
        "seen_share": {
            name: round(float(share), DIGITS)
            for name, share in zip(JOINT_NAMES, track.seen.mean(axis=0), strict=True)
        },
    }
