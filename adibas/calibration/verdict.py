"""Is a calibration good, usable, or to be repeated, and why.

Each mistake of someone who calibrates for the first time has a sentence of its own. What is wrong
with the images is judged beside what it does to the result: a false "good" is the one thing that
must not happen.
"""

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from adibas.calibration.finder import BoardProblem, BoardSearch
from adibas.calibration.projection_uncertainty import distance_uncertainty
from adibas.calibration.quality import map_residuals, tilt_directions_rad, tilts_rad
from adibas.data.board import Board
from adibas.data.calibration_verdict import Finding, Grade, Reason, Verdict
from adibas.data.camera_fit import CameraFit

CERTAIN = 1.96


@dataclass(frozen=True, slots=True)
class VerdictParams:
    """Where good ends, and where usable ends.

    Attributes
    ----------
    least_views, good_views : int
        Fewer than 6 images are too few, 10 enough: with so many the focal length is sure to some
        0.2 %.
    tilt_rad : float
        A board tilted less is frontal: 12 degrees. Zhang 2000, section 5: best is 45.
    least_tilted : int
        Boards that must be tilted: 3.
    least_lean_rad : float
        Spread of the leans' directions, below which all lean one way: 35 degrees.
    cut_share, greatest_cut_share, bad_cut_share : float
        An image is cut off below 0.9 of the corners. More than 0.3 of such images are too many;
        more than 0.7 say that the board was never held right.
    blur_px, greatest_blurred_share : float
        A blur of 2.5 pixels; more than 0.2 of such images are too many. A sharp camera has 1.
    least_covered, good_covered : float
        Share of the cells of the image with corners: 0.35 and 0.65.
    good_rms_px : float
        Over points, in an image 1280 wide: 0.6. Five times what the finder reaches.
    bad_rms_px : float
        Likewise: 1.5.
    good_birge, bad_birge : float
        Ratio of variances between views: 16 and 100, so 4 and 10 times the noise.
    length_m, distance_m : float
        A length to judge by: 1 m at 2.5 m, from a patient's shoulder to the knee.
    good_error_m, bad_error_m : float
        Half of its 95 % interval: 2.5 mm, about one marker's own error, and 20 mm,
        worse than a ruler.
    least_scale_error : float
        Of the squares' size: 0.02; a printer's "fit to page" is 3 to 6 %.
    """

    least_views: int = 6
    good_views: int = 10
    tilt_rad: float = float(np.deg2rad(12.0))
    least_tilted: int = 3
    least_lean_rad: float = float(np.deg2rad(35.0))
    cut_share: float = 0.9
    greatest_cut_share: float = 0.3
    bad_cut_share: float = 0.7
    blur_px: float = 2.5
    greatest_blurred_share: float = 0.2
    least_covered: float = 0.35
    good_covered: float = 0.65
    good_rms_px: float = 0.6
    bad_rms_px: float = 1.5
    good_birge: float = 16.0
    bad_birge: float = 100.0
    length_m: float = 1.0
    distance_m: float = 2.5
    good_error_m: float = 0.0025
    bad_error_m: float = 0.02
    least_scale_error: float = 0.02


@dataclass(frozen=True, slots=True)
class ScaleCheck:
    """A board's distance by depth and by its image.

    Attributes
    ----------
    by_depth_m, by_image_m : float
        Of the same point of the board in the same camera's frame.
    sd_m : float
        Of their difference, the depth sensor's own bias included.
    """

    by_depth_m: float
    by_image_m: float
    sd_m: float


@dataclass(frozen=True, slots=True, eq=False)
class Evidence:
    """What a verdict is made of.

    Attributes
    ----------
    board : Board
        What was said to be shown.
    searches : sequence of BoardSearch
        One for each image.
    fit : CameraFit or None
        None where nothing could be fitted.
    blurs_px : sequence of float
        Of the images with a board; NaN where unknown.
    scale_checks : sequence of ScaleCheck
        Where there is depth.
    """

    board: Board
    searches: Sequence[BoardSearch]
    fit: CameraFit | None
    blurs_px: Sequence[float] = ()
    scale_checks: Sequence[ScaleCheck] = ()


def judge(evidence: Evidence, params: VerdictParams | None = None) -> Verdict:
    """Return the verdict on a calibration."""
    params = params or VerdictParams()
    findings = [*_about_searches(evidence), *_about_images(evidence, params)]
    findings += _about_number(evidence, params, is_explained=_has_repeat(findings))
    fit = evidence.fit
    is_enough = all(finding.reason is not Reason.TOO_FEW for finding in findings)
    if fit is not None and fit.is_settled and is_enough:
        findings += _about_scale(evidence, params)
        findings += _about_fit(fit, params)
    elif not _has_repeat(findings):
        leans = [] if fit is None else _about_leans(fit, params)
        has_cause = _has_repeat(leans)
        findings += leans if has_cause else [Finding(Reason.UNSETTLED, Grade.REPEAT)]
    grades, reasons = list(Grade), list(Reason)
    findings.sort(key=lambda one: (-grades.index(one.grade), reasons.index(one.reason)))
    return Verdict(tuple(findings))


def _has_repeat(findings: Sequence[Finding]) -> bool:
    return any(finding.grade is Grade.REPEAT for finding in findings)


def _about_fit(fit: CameraFit, params: VerdictParams) -> list[Finding]:
    """Speak of what the images made of the camera; what explains it is enough."""
    leans = _about_leans(fit, params)
    residuals = _about_residuals(fit, params)
    if _has_repeat(leans):
        return leans + residuals
    return leans + residuals + _about_certainty(fit, params)


def _about_searches(evidence: Evidence) -> list[Finding]:
    """Speak of images without corners; a board elsewhere than said is never overlooked."""
    total = len(evidence.searches)
    counts = Counter(search.problem for search in evidence.searches)
    found = [search.corners for search in evidence.searches if search.corners is not None]
    findings = []
    if any(corners.is_mirrored for corners in found):
        findings.append(Finding(Reason.MIRRORED, Grade.REPEAT))
    n = counts[BoardProblem.ANOTHER_SIZE]
    if n > 0:
        findings.append(_other_size(evidence, n))
    for problem, reason in (
        (BoardProblem.TWO_BOARDS, Reason.TWO_BOARDS),
        (BoardProblem.NO_BOARD, Reason.NO_BOARD),
    ):
        n = counts[problem]
        if n > 0:
            findings.append(Finding(reason, _grade(n > total / 2), {"n": n, "total": total}))
    return findings


def _other_size(evidence: Evidence, n: int) -> Finding:
    searches = [s for s in evidence.searches if s.problem is BoardProblem.ANOTHER_SIZE]
    sizes = Counter((search.fields["columns"], search.fields["rows"]) for search in searches)
    (columns, rows), _ = sizes.most_common(1)[0]
    total = len(evidence.searches)
    fields = {
        "n": n,
        "total": total,
        "columns": columns,
        "rows": rows,
        "board": f"{evidence.board.columns} x {evidence.board.rows}",
    }
    return Finding(Reason.OTHER_SIZE, _grade(n > total / 4), fields)


def _about_number(
    evidence: Evidence, params: VerdictParams, *, is_explained: bool
) -> list[Finding]:
    """Speak of the number of images; `is_explained`: why there are none was said."""
    n = sum(search.corners is not None for search in evidence.searches)
    if evidence.fit is not None:
        n = len(evidence.fit.used_views)
    if n == 0 and is_explained:
        return []
    if n < params.least_views:
        fields = {"n": n, "least": params.least_views}
        return [Finding(Reason.TOO_FEW, Grade.REPEAT, fields)]
    if n < params.good_views:
        return [Finding(Reason.FEW, Grade.USABLE, {"n": n, "wanted": params.good_views})]
    return []


def _about_images(evidence: Evidence, params: VerdictParams) -> list[Finding]:
    total = len(evidence.searches)
    cut = (BoardProblem.PARTLY_SEEN, BoardProblem.TOO_FEW)
    n_cut = sum(search.problem in cut for search in evidence.searches)
    found = [search.corners for search in evidence.searches if search.corners is not None]
    n_cut += sum(corners.n_seen < params.cut_share * len(corners.pixels) for corners in found)
    findings = []
    if n_cut > params.greatest_cut_share * total:
        grade = _grade(n_cut > params.bad_cut_share * total)
        findings.append(Finding(Reason.CUT_OFF, grade, {"n": n_cut, "total": total}))
    n_blurred = sum(blur > params.blur_px for blur in evidence.blurs_px)
    if n_blurred > params.greatest_blurred_share * len(evidence.blurs_px):
        fields = {"n": n_blurred, "total": len(evidence.blurs_px)}
        grade = _grade(n_blurred > len(evidence.blurs_px) / 2)
        findings.append(Finding(Reason.BLURRED, grade, fields))
    return findings


def _about_leans(fit: CameraFit, params: VerdictParams) -> list[Finding]:
    is_tilted = tilts_rad(fit) > params.tilt_rad
    if is_tilted.sum() < params.least_tilted:
        return [Finding(Reason.FRONTAL, Grade.REPEAT)]
    directions = np.exp(1j * tilt_directions_rad(fit)[is_tilted])
    # Of directions in a plane; leans to the left and to the right are two ways.
    spread_rad = np.sqrt(-2.0 * np.log(max(abs(directions.mean()), 1e-12)))
    if spread_rad < params.least_lean_rad:
        return [Finding(Reason.ONE_LEAN, Grade.USABLE)]
    return []


def _about_scale(evidence: Evidence, params: VerdictParams) -> list[Finding]:
    """Compare distances by depth with those that the said size of the squares gives."""
    checks = evidence.scale_checks
    if not checks:
        return []
    by_depth, by_image, sds = np.array([(c.by_depth_m, c.by_image_m, c.sd_m) for c in checks]).T
    factor = float(np.median(by_depth / by_image))
    error = float(np.median(sds / by_image))
    if abs(factor - 1.0) <= max(params.least_scale_error, CERTAIN * error):
        return []
    said_mm = 1000.0 * evidence.board.square_m
    fields = {"factor": factor, "square_mm": said_mm * factor, "said_mm": said_mm}
    return [Finding(Reason.SCALE, Grade.REPEAT, fields)]


def _about_residuals(fit: CameraFit, params: VerdictParams) -> list[Finding]:
    findings = []
    outliers = [view.image for view in fit.views if view.is_outlier]
    if outliers:
        fields = {"n": len(outliers), "total": len(fit.views), "images": ", ".join(outliers)}
        findings.append(
            Finding(Reason.OUTLIERS, _grade(len(outliers) > len(fit.views) / 4), fields)
        )
    limit_px = params.good_rms_px * max(fit.camera.width / 1280.0, 0.5)
    if fit.rms_px > limit_px:
        grade = _grade(fit.rms_px > limit_px * params.bad_rms_px / params.good_rms_px)
        findings.append(Finding(Reason.LARGE_ERROR, grade, {"rms": fit.rms_px, "limit": limit_px}))
    if fit.birge_ratio > params.good_birge:
        grade = _grade(fit.birge_ratio > params.bad_birge)
        findings.append(Finding(Reason.NOT_FLAT, grade, {"ratio": fit.birge_ratio**0.5}))
    covered = map_residuals(fit).covered_share
    if covered < params.good_covered:
        fields = {"percent": round(100.0 * covered)}
        findings.append(Finding(Reason.UNCOVERED, _grade(covered < params.least_covered), fields))
    return findings


def _about_certainty(fit: CameraFit, params: VerdictParams) -> list[Finding]:
    error_m = CERTAIN * distance_uncertainty(fit, params.distance_m, params.length_m)
    if error_m <= params.good_error_m:
        return []
    if np.isnan(error_m):
        return [Finding(Reason.UNSETTLED, Grade.REPEAT)]
    fields = {
        "length_mm": 1000.0 * params.length_m,
        "distance_m": params.distance_m,
        "error_mm": 1000.0 * error_m,
        "limit_mm": 1000.0 * params.good_error_m,
    }
    return [Finding(Reason.UNCERTAIN, _grade(error_m > params.bad_error_m), fields)]


def _grade(is_bad: bool) -> Grade:
    return Grade.REPEAT if is_bad else Grade.USABLE
