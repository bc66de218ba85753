"""The model of limbs that comes with the program."""

from adibas.data.limbs import FULL_BODY, UPPER_BODY
from adibas.limbs.model import LimbModel, load_model, merged
from adibas.limbs.training_set import TO_TORSO
from adibas.resources import resource_path


def shipped_model(labels: str = FULL_BODY.name) -> LimbModel:
    """Return the model that comes with the program for the full or the upper body.

    The seven labels of the upper body are made of the fifteen, in a fifth of a second.
    """
    model = load_model(resource_path("models", "limbs-15.npz"))
    return model if labels == FULL_BODY.name else merged(model, UPPER_BODY, TO_TORSO)
