"""Train the shipped model of the thesis' five gestures: python -m benchmarks.train_gestures."""

from pathlib import Path

from adibas import __version__
from adibas.gestures.descriptor import DescriptorParams
from adibas.gestures.model import GestureModel
from adibas.gestures.model_file import write_model
from adibas.gestures.training import TrainingParams, train
from adibas.pipeline.gesture_examples import examples_of
from benchmarks.gesture_actors import streams

SEED = 9000
"""None of the actors of the benchmarks."""

N_ACTORS, N_EACH = 3, 4
PLACE = Path(__file__).parents[1] / "resources" / "models" / "gestures.json"


def main() -> None:
    """Simulate actors, train, and write the model."""
    tracks, events = streams(N_ACTORS, N_EACH, SEED)
    examples, rule, _ = examples_of(tracks, events, DescriptorParams())
    params = TrainingParams(most_examples=6, most_others=80, seed=SEED)
    model = train(examples, DescriptorParams(), params)
    provenance: dict[str, object] = {
        "version": __version__,
        "source": "simulated actors (benchmarks/train_gestures.py), no person",
        "n_actors": N_ACTORS,
        "n_examples": len(examples.gestures),
        "split_by": rule,
        "seed": SEED,
    }
    write_model(
        PLACE,
        GestureModel(
            model.method, model.labels, model.descriptor, model.examples, model.owners,
            model.weights, model.thresholds, model.gates, model.judge, provenance,
        ),
    )  # fmt: skip


if __name__ == "__main__":
    main()
