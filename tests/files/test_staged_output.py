"""Several outputs appear together or not at all."""

import os

import pytest

from indoorfit.errors import OutputError
from indoorfit.files import atomic_file, staged


def write(places, text="new"):
    for place in places:
        place.write_text(text)


def names(folder):
    return sorted(str(path.relative_to(folder)) for path in folder.rglob("*"))


def test_all_targets_appear_at_the_end_with_what_lies_beside_them(tmp_path):
    (tmp_path / "b").mkdir()
    targets = [tmp_path / "a.obj", tmp_path / "b" / "c.ply"]
    with staged(targets, overwrite=False) as places:
        assert [place.name for place in places] == ["a.obj", "c.ply"]
        write(places)
        places[0].with_suffix(".mtl").write_text("new")
        (places[0].parent / "textures").mkdir()
        (places[0].parent / "textures" / "wall.png").write_text("new")
        assert not any(target.exists() for target in targets)
    assert names(tmp_path) == ["a.mtl", "a.obj", "b", "b/c.ply", "textures", "textures/wall.png"]


@pytest.mark.parametrize("beside", ["a.mtl", "textures/wall.png"])
def test_files_beside_a_target_need_overwriting_too(tmp_path, beside):
    path = tmp_path / beside
    path.parent.mkdir(exist_ok=True)
    path.write_text("mine")

    def attempt(overwrite):
        with staged([tmp_path / "a.obj"], overwrite=overwrite) as places:
            write(places)
            (places[0].parent / beside).parent.mkdir(exist_ok=True)
            (places[0].parent / beside).write_text("new")

    with pytest.raises(OutputError, match="--overwrite"):
        attempt(False)
    assert path.read_text() == "mine"
    assert not (tmp_path / "a.obj").exists()
    attempt(True)
    assert path.read_text() == "new"
    assert not [name for name in names(tmp_path) if name.startswith(".")]


def test_an_error_in_the_last_step_brings_everything_back(tmp_path, monkeypatch):
    old = [tmp_path / "a", tmp_path / "b"]
    write(old, "old")
    rename, calls = os.rename, []

    def fourth_fails(source, target):
        calls.append(source)
        if len(calls) == 4:
            raise OSError(5, "Input/output error")
        rename(source, target)

    monkeypatch.setattr(os, "rename", fourth_fails)

    def attempt():
        with staged(old, overwrite=True) as places:
            write(places)

    with pytest.raises(OutputError, match="Input/output"):
        attempt()
    assert names(tmp_path) == ["a", "b"]
    assert [path.read_text() for path in old] == ["old", "old"]


def test_errors_name_the_target_and_not_the_temporary_place(tmp_path):
    def attempt():
        with staged([tmp_path / "a"], overwrite=False) as places:
            raise OutputError(f"{places[0]}: disk full. Fix: make room.")

    with pytest.raises(OutputError) as caught:
        attempt()
    assert str(caught.value) == f"{tmp_path / 'a'}: disk full. Fix: make room."
    assert names(tmp_path) == []


@pytest.mark.parametrize("folders", [True, False], ids=["told", "found out"])
@pytest.mark.parametrize("overwrite", [True, False])
def test_a_file_never_gives_way_to_a_directory(tmp_path, overwrite, folders):
    scan = tmp_path / "scan.ply"
    scan.write_text("precious")

    def attempt():
        with staged([scan], overwrite=overwrite, marks=("mark.json",), folders=folders) as (place,):
            place.mkdir()
            (place / "mark.json").write_text("new")

    with pytest.raises(OutputError):
        attempt()
    assert scan.read_text() == "precious"
    assert names(tmp_path) == ["scan.ply"]


def test_a_device_is_never_replaced_by_a_file(tmp_path):
    pipe = tmp_path / "device"
    os.mkfifo(pipe)
    with pytest.raises(OutputError, match="no ordinary file"), staged([pipe], overwrite=True) as places:
        write(places)
    with pytest.raises(OutputError, match="no ordinary file"), atomic_file(pipe) as file:
        file.write(b"new")
    assert pipe.is_fifo()
    assert names(tmp_path) == ["device"]
