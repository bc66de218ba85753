"""The model of limbs that comes with the program."""

from functools import lru_cache

from adibas.data.limbs import FULL_BODY, UPPER_BODY
from adibas.limbs.model import LimbModel, load_model, merged
from adibas.limbs.training_set import TO_TORSO
from adibas.resources import resource_path


def shipped_model(labels: str = FULL_BODY.name) -> LimbModel:
    """Return the model that comes with the program for the full or the upper body; loaded once."""
    return _loaded(labels)


@lru_cache(maxsize=2)
def _loaded(labels: str) -> LimbModel:
    if labels == FULL_BODY.name:
        return load_model(resource_path("models", "limbs-15.npz"))
    return merged(_loaded(FULL_BODY.name), UPPER_BODY, TO_TORSO)
