"""Which parts of the body tell of which joint."""

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class JointPlace:
    """Where a joint is looked for.

    Attributes
    ----------
    joint : str
        Of `JOINT_NAMES`.
    parts : tuple of one or two str
        Of `BODY_PART_NAMES`: the part it lies in, or the two that meet at it.
    width_m : float
        How far a point's density reaches: about the width of the parts there.
    neighbors : tuple of str
        Parts whose middles say where the joint is beside the mode.
    """

    joint: str
    parts: tuple[str, ...]
    width_m: float
    neighbors: tuple[str, ...]

    @property
    def kind(self) -> str:
        """The joint without its side: both sides share what is learned."""
        return without_side(self.joint)


def without_side(name: str) -> str:
    """Return the name of a joint or part without its side."""
    return name.removeprefix("left_").removeprefix("right_")


def _of_side(side: str) -> tuple[JointPlace, ...]:
    other = {"left": "right", "right": "left"}[side]

    def own(part: str) -> str:
        return f"{side}_{part}"

    arm = (own("upper_arm"), own("lower_arm"))
    leg = (own("upper_leg"), own("lower_leg"))
    return (
        JointPlace(own("shoulder"), (arm[0], "torso"), 0.10, (arm[0], "torso", "head")),
        JointPlace(own("elbow"), arm, 0.08, arm),
        JointPlace(own("hand"), (own("hand"),), 0.08, (arm[1],)),
        JointPlace(
            own("hip"),
            (leg[0], "torso"),
            0.16,
            (leg[0], leg[1], "torso", f"{other}_upper_leg", "neck"),
        ),
        JointPlace(own("knee"), leg, 0.10, leg),
        JointPlace(own("foot"), (leg[1], own("foot")), 0.08, (leg[1], own("foot"))),
    )


PLACES: tuple[JointPlace, ...] = (
    JointPlace("head", ("head",), 0.12, ("torso",)),
    JointPlace("neck", ("neck",), 0.08, ("head", "torso")),
    JointPlace("torso", ("torso",), 0.25, ("torso", "neck", "left_upper_leg", "right_upper_leg")),
    *_of_side("left"),
    *_of_side("right"),
)
