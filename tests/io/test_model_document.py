"""model.json: the contract to the letter, lossless, the same bytes every time, and checked on the way in."""

import copy
import json
from dataclasses import replace

import jsonschema
import numpy as np
import pytest

from indoorfit.errors import InputError
from indoorfit.io import SCHEMA_PATH, document_bytes, read_model_json, to_document, write_model_json
from indoorfit.model import SIDES, Method

SCHEMA = json.loads(SCHEMA_PATH.read_text(encoding="utf-8"))
VALIDATOR = jsonschema.Draft202012Validator(SCHEMA)

CONTRACT = {
    (): "schema unit level method frame rooms cubes faces dimensions noise warnings provenance",
    ("frame",): "R_manhattan_scan origin_scan",
    ("rooms", 0): "id cube floor_area volume perimeter",
    ("rooms", 0, "volume"): "value std interval",
    ("rooms", 0, "volume", "interval"): "level low high",
    ("cubes", 1): "id role parent centre size open",
    ("faces", 0): "id kind class room cube normal offset_std rings points coverage rms status",
    ("dimensions", 0): "id kind faces from to value std interval status",
    ("dimensions", 0, "interval"): "level low high",
    ("warnings", 0): "code message",
}


OPTIONAL = {"coverage_factor", "budget", "intervals", "loa"}


def below(document, path):
    for key in path:
        document = document[key]
    return document


def required_paths(value, path=()):
    """The path of every key in the document, except in the free-form parts and of those that may lack."""
    if isinstance(value, dict) and path[:1] not in (("noise",), ("provenance",)):
        for key, item in value.items():
            if key in OPTIONAL or (path[:1], key) == (("warnings",), "faces"):
                continue
            yield (*path, key)
            yield from required_paths(item, (*path, key))
    elif isinstance(value, list):
        for index, item in enumerate(value):
            yield from required_paths(item, (*path, index))


def test_schema_is_itself_valid():
    jsonschema.Draft202012Validator.check_schema(SCHEMA)


def test_document_has_every_field_of_the_contract(result):
    document = to_document(result)
    for path, names in CONTRACT.items():
        assert set(names.split()) <= set(below(document, path)), path
    VALIDATOR.validate(document)


@pytest.mark.parametrize("method", ["joint", "greedy", "truth"])
def test_document_of_every_method_satisfies_the_schema(result, method: Method):
    VALIDATOR.validate(to_document(replace(result, method=method)))


def test_schema_and_reader_refuse_a_document_that_lacks_any_field(tmp_path, result):
    document = to_document(result)
    paths = list(required_paths(document))
    assert len(paths) > 100
    for path in paths:
        # What follows from the sides need not be read, but the contract has it.
        derived = path[0] == "cubes" and path[2:3] in (("centre",), ("size",), ("open",))
        broken = copy.deepcopy(document)
        del below(broken, path[:-1])[path[-1]]
        assert not VALIDATOR.is_valid(broken), path
        (tmp_path / "model.json").write_text(json.dumps(broken))
        if not derived:
            with pytest.raises(InputError, match=f"{path[-1]} is missing".replace("+", r"\+")):
                read_model_json(tmp_path / "model.json")


def test_a_document_without_the_optional_fields_is_read(tmp_path, result):
    def bare(value):
        if isinstance(value, dict):
            return {key: bare(item) for key, item in value.items() if key not in OPTIONAL}
        return [bare(item) for item in value] if isinstance(value, list) else value

    document = bare(to_document(result))
    for warning in document["warnings"]:
        del warning["faces"]
    VALIDATOR.validate(document)
    (tmp_path / "model.json").write_text(json.dumps(document))
    found = read_model_json(tmp_path / "model.json")
    assert [note.faces for note in found.notes] == [()]
    assert found.dimensions[0].loa is None
    assert found.dimensions[0].quantity.budget is None
    assert found.dimensions[0].quantity.intervals == ()


def test_cubes_carry_their_boxes_in_the_manhattan_frame(result):
    room, notch = to_document(result)["cubes"]
    assert room["centre"] == [0.0, 0.0, 0.0]
    assert room["size"] == [4.0, 3.0, 2.5]
    assert notch["open"] == ["+x", "+y"]
    assert notch["sides"] == dict(zip(SIDES, [6, None, 7, None, 4, 5], strict=True))
    # The notch reaches from its planes to a metre beyond the room.
    np.testing.assert_allclose(notch["size"], [3.0 - 1 / 3, 2.5 - 0.3, 2.5], rtol=0.0, atol=1e-15)


def test_reading_gives_back_everything_to_the_bit(tmp_path, result):
    path = tmp_path / "model.json"
    write_model_json(path, result)
    found = read_model_json(path)
    assert document_bytes(to_document(found)) == path.read_bytes()
    assert found.shape == result.shape
    assert found.rooms == result.rooms
    assert found.notes == result.notes
    assert found.meshes == ()
    np.testing.assert_array_equal(found.frame.R_manhattan_scan, result.frame.R_manhattan_scan)
    for face, expected in zip(found.faces, result.faces, strict=True):
        np.testing.assert_array_equal(face.rings_m[1], expected.rings_m[1])
        assert (face.id, face.side, face.n_points) == (expected.id, expected.side, expected.n_points)


def test_free_form_parts_hold_plain_values_only(result):
    document = to_document(result)
    assert document["noise"] == {"sigma_m": 0.005, "knots": [1.0, None], "explanation": "Größe"}
    with pytest.raises(ValueError, match=r"noise\.model is of type object"):
        to_document(replace(result, noise={"model": object()}))


def test_numbers_without_a_value_do_not_pass_for_measurements(result):
    face = replace(result.faces[1], offset_std_m=float("inf"))
    with pytest.raises(ValueError, match=r"faces\[1\]\.offset_std is inf"):
        to_document(replace(result, faces=(result.faces[0], face)))


def test_an_error_while_writing_keeps_the_older_file(tmp_path, result):
    path = tmp_path / "model.json"
    write_model_json(path, result)
    before = path.read_bytes()
    with pytest.raises(ValueError, match="noise"):
        write_model_json(path, replace(result, noise={"model": object()}))
    assert [p.name for p in tmp_path.iterdir()] == ["model.json"]
    assert path.read_bytes() == before


CHANGES = {
    "another schema": (("schema",), "indoorfit.model/2", "schema is 'indoorfit.model/2'"),
    "feet": (("unit",), "ft", "unit is 'ft'"),
    "unknown method": (("method",), "guess", "joint or greedy or truth"),
    "word for a number": (("level",), "0.95", "level is a string"),
    "short vector": (("frame", "origin_scan"), [1, 2], "a list of 2"),
    "short matrix": (("frame", "R_manhattan_scan"), [[1, 0, 0]], "a list of 1"),
    "plane out of range": (("faces", 0, "plane"), 8, "from 0 to 7"),
    "negative plane": (("cubes", 0, "sides", "-x"), -1, "from 0 to 7"),
    "plane across another axis": (("cubes", 0, "sides", "-x"), 2, "across y"),
    "open room": (("cubes", 0, "sides", "-x"), None, "closed on all sides"),
    "unknown parent": (("cubes", 1, "parent"), "cube-9", "comes before"),
    "own parent": (("cubes", 1, "parent"), "cube-1", "comes before"),
    "id twice": (("cubes", 1, "id"), "cube-0", "second time"),
    "unknown cube": (("faces", 1, "cube"), "cube-9", "id of a cube"),
    "unknown room": (("dimensions", 0, "room"), "room-9", "id of a room"),
    "unknown face": (("dimensions", 0, "faces"), ["wall-1", "wall-9"], "id of a face"),
    "three faces": (("dimensions", 0, "faces"), ["wall-1"] * 3, "a list of 2"),
    "flat ring": (("faces", 0, "rings", 0), [[0, 0, 0], [1, 1, 1]], "at least 3"),
    "outward of 2": (("planes", 0, "outward"), 2, "1 or -1"),
    "nan": (("planes", 0, "offset"), float("nan"), "finite"),
    "huge integer": (("planes", 0, "offset"), 10**400, "finite"),
    "list for an object": (("noise",), [], "noise is a list"),
}


@pytest.mark.parametrize(("path", "value", "said"), CHANGES.values(), ids=CHANGES)
def test_read_model_json_names_the_field_that_is_wrong(tmp_path, result, path, value, said):
    document = to_document(result)
    below(document, path[:-1])[path[-1]] = value
    (tmp_path / "model.json").write_text(json.dumps(document))
    with pytest.raises(InputError, match=said):
        read_model_json(tmp_path / "model.json")


@pytest.mark.parametrize("content", [b"", b"{", b"\xff\xfe", b"[]", b"3"])
def test_read_model_json_refuses_files_that_are_no_model(tmp_path, content):
    (tmp_path / "model.json").write_bytes(content)
    with pytest.raises(InputError, match=r"model\.json"):
        read_model_json(tmp_path / "model.json")
    with pytest.raises(InputError, match=r"absent\.json: cannot be read"):
        read_model_json(tmp_path / "absent.json")


@pytest.mark.parametrize("part", ["rooms", "faces", "dimensions"])
def test_read_model_json_refuses_an_id_that_comes_twice(tmp_path, result, part):
    document = to_document(result)
    document[part].append(document[part][0])
    (tmp_path / "model.json").write_text(json.dumps(document))
    with pytest.raises(InputError, match=rf"{part}\[0\]\.id is .* like another"):
        read_model_json(tmp_path / "model.json")


def test_read_model_json_refuses_half_a_character(tmp_path, result):
    document = to_document(result)
    document["rooms"][0]["id"] = "\ud800"
    (tmp_path / "model.json").write_text(json.dumps(document))
    with pytest.raises(InputError, match="half a character"):
        read_model_json(tmp_path / "model.json")
