"""A skeleton model's file whose arrays do not fit together is refused: kernels check no index."""

import copy

import pytest

from adibas.cli.command_line import main
from adibas.pipeline.skeleton_labelling import shipped_namer
from adibas.skeleton.model_files import model_from_json, model_to_json, write_model
from adibas.skeleton.parts_checks import SHAPES


@pytest.fixture(scope="module")
def document():
    return model_to_json(shipped_namer()._model)


def broken(document, part, field, change):
    """Return the document with one field of core, limbs, anchors or stance changed."""
    parts = dict(document["parts"])
    values = copy.deepcopy(parts[part][field])
    change(values)
    parts[part] = {**parts[part], field: values}
    return {**document, "parts": parts}


def test_the_shipped_model_fits_together_and_so_does_what_was_written_of_it(document):
    again = model_to_json(model_from_json(document))
    assert again["parts"] == document["parts"]


@pytest.mark.parametrize(
    ("part", "field"),
    [(kind.__name__.lower(), field) for kind, fields in SHAPES.items() for field in fields],
)
def test_a_field_of_which_an_entry_is_lost_is_refused(document, part, field):
    """Of one that gives a length to the others, those are found to be too long."""
    lost = broken(document, part, field, lambda values: values.pop())
    with pytest.raises(ValueError, match="must have shape"):
        model_from_json(lost)


@pytest.mark.parametrize(
    ("part", "field"),
    [(kind.__name__.lower(), field) for kind, fields in SHAPES.items() for field in fields],
)
def test_a_field_that_is_lost_is_missed(document, part, field):
    parts = copy.deepcopy(document["parts"])
    del parts[part][field]
    with pytest.raises(KeyError, match=field):
        model_from_json({**document, "parts": parts})


@pytest.mark.parametrize("index", [-1, 10**6])
@pytest.mark.parametrize(
    ("part", "field"),
    [
        ("core", "labels"),
        ("core", "mirror"),
        ("core", "kinds"),
        ("limbs", "labels"),
        ("limbs", "roots"),
        ("limbs", "kinds"),
        ("anchors", "points"),
    ],
)
def test_an_index_of_nothing_is_refused(document, part, field, index):
    def change(values):
        if isinstance(values[0], list):
            values[0][0] = index
        else:
            values[0] = index

    with pytest.raises(ValueError, match="must be from 0 to"):
        model_from_json(broken(document, part, field, change))


@pytest.mark.parametrize(("part", "field"), [("core", "factors"), ("limbs", "outer_factors")])
def test_a_distribution_without_extent_is_refused(document, part, field):
    def change(values):
        block = values[0] if part == "core" else values[0][0]
        block[0][0] = 0.0

    with pytest.raises(ValueError, match="must be positive"):
        model_from_json(broken(document, part, field, change))


@pytest.mark.parametrize("value", [1e5, -0.1])
def test_covariances_of_which_nothing_could_be_searched_are_refused(document, value):
    """With such a one the search for names did not end."""

    def change(values):
        values[0][0][0] = value

    with pytest.raises(ValueError, match=r"positive definite|those of the covariances"):
        model_from_json(broken(document, "core", "covariances", change))


def test_lengths_of_bones_that_do_not_vary_are_refused(document):
    def change(values):
        values[0][0][0][0] = 0.0

    with pytest.raises(ValueError, match="positive definite"):
        model_from_json(broken(document, "limbs", "bone_covariances", change))


def test_lengths_of_both_sides_that_are_more_alike_than_they_vary_are_refused(document):
    def change(values):
        own = document["parts"]["limbs"]["bone_covariances"][1][2]
        values[1][2] = [[2.0 * one for one in row] for row in own]

    with pytest.raises(ValueError, match="bone_covariances must be positive definite"):
        model_from_json(broken(document, "limbs", "side_covariances", change))


@pytest.mark.parametrize("part", ["core", "stance"])
def test_covariances_that_are_no_mirror_image_of_themselves_are_refused(document, part):
    """A factorisation that looks at one half of them would not see it."""

    def change(values):
        values[0][0][1] *= 1.01

    with pytest.raises(ValueError, match="symmetric"):
        model_from_json(broken(document, part, "covariances", change))


@pytest.mark.parametrize(("part", "field"), [("core", "kinds"), ("limbs", "kinds")])
def test_a_kind_of_posture_that_no_component_is_of_is_refused(document, part, field):
    def change(values):
        rows = values if part == "limbs" else [values]
        rows[-1][:] = [0] * len(rows[-1])

    with pytest.raises(ValueError, match="each of the kinds"):
        model_from_json(broken(document, part, field, change))


@pytest.mark.parametrize(
    ("field", "value", "told"),
    [("bone_means", 800.0, "below 20"), ("bone_sds", 1e-300, "positive")],
)
def test_bones_whose_lengths_no_number_holds_are_refused(document, field, value, told):
    def change(values):
        values[2][1] = value

    with pytest.raises(ValueError, match=told):
        model_from_json(broken(document, "stance", field, change))


@pytest.mark.parametrize(
    ("part", "field"), [("core", "log_weights"), ("stance", "bone_means"), ("anchors", "costs")]
)
def test_numbers_that_no_body_has_are_refused(document, part, field):
    def change(values):
        row = values[0] if isinstance(values[0], list) else values
        row[0] = 1e300

    with pytest.raises(ValueError, match="must be below"):
        model_from_json(broken(document, part, field, change))


def test_the_command_says_that_it_is_no_model(tmp_path, capsys):
    points = tmp_path / "points.csv"
    points.write_text(
        "\n".join(["shape,point,label,x_m,y_m,z_m", *(f"a,{i},,{i},0,1" for i in range(9))])
    )
    model, out = tmp_path / "model.json", tmp_path / "out.csv"
    write_model(shipped_namer()._model, model)
    text = model.read_text("utf-8")
    start = text.index('"roots"')
    model.write_text(text[:start] + text[start:].replace("2", "999999", 1), "utf-8")
    command = ["skeleton", "label", str(points), "--model", str(model), "--out", str(out)]
    assert main(command) == 1
    assert "no skeleton model" in capsys.readouterr().err
    assert not out.exists()
