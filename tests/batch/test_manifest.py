"""A manifest says which fits there are; what is wrong with it is named before anything runs."""

from dataclasses import replace

import pytest

from indoorfit.batch import read_manifest
from indoorfit.batch.published import read_published
from indoorfit.errors import ConfigError, InputError
from indoorfit.io import write_ply
from synthetic import virtual


@pytest.fixture
def folder(tmp_path):
    for name in ("a", "b"):
        write_ply(tmp_path / f"{name}.ply", virtual("box", 1, n_points=2000).scan)
    return tmp_path


def study(folder, text, name="manifest.toml"):
    (folder / name).write_text(text, encoding="utf-8")
    return read_manifest(folder / name)


def test_every_scan_meets_every_configuration(folder):
    text = """
    [config.joint]
    [config.greedy]
    method = "greedy"
    level = 0.9
    [[scan]]
    file = "a.ply"
    [[scan]]
    file = "b.ply"
    name = "kitchen"
    sensor = "tls"
    room = "r1"
    configs = ["greedy"]
    [[simulate]]
    name = "sim"
    rooms = 2
    seed = 7
    plan = "U"
    configs = ["joint"]
    """
    jobs = study(folder, text).jobs
    assert [(j.name, j.room, j.sensor, j.config_name) for j in jobs] == [
        ("a", "a", "unknown", "joint"),
        ("a", "a", "unknown", "greedy"),
        ("kitchen", "r1", "tls", "greedy"),
        ("sim-7", "sim-7", "even", "joint"),
        ("sim-8", "sim-8", "even", "joint"),
    ]
    assert jobs[1].config.method == "greedy"
    assert jobs[1].config.level == 0.9


def test_csv_says_the_same_as_toml(folder):
    toml = '[[scan]]\nfile = "a.ply"\nsensor = "tls"\n[[scan]]\nfile = "b.ply"\nunit = "cm"\n'
    rows = "file,sensor,unit\na.ply,tls,\nb.ply,,cm\n"
    assert study(folder, rows, "manifest.csv").jobs == study(folder, toml).jobs


def test_settings_of_a_file_are_changed_by_those_written_here(folder):
    (folder / "base.toml").write_text("level = 0.8\nseed = 3\n[joint]\nmax_rounds = 9\n")
    text = '[config.x]\nfile = "base.toml"\nlevel = 0.9\n[[scan]]\nfile = "a.ply"\n'
    config = study(folder, text).jobs[0].config
    assert (config.level, config.seed, config.joint.max_rounds) == (0.9, 3, 9)


def test_one_table_of_readings_serves_all_scans(folder):
    (folder / "tape.csv").write_text(
        "scan,dimension,value,unit\na.ply,A,5,m\nb,A,4,m\nb,B,oops,m\nattic,A,3,m\n,A,2,m\n"
    )
    found = study(folder, 'tape = "tape.csv"\n[[scan]]\nfile = "a.ply"\n[[scan]]\nfile = "b.ply"\n')
    values = [[r.value_m for r in job.tape.readings] for job in found.jobs if job.tape]
    assert values == [[5.0], [4.0]]
    assert [(row.line, table) for table, row in found.refused] == [
        (4, "tape.csv"),
        (5, "tape.csv"),
        (6, "tape.csv"),
    ]


def test_the_key_is_that_of_the_content(folder):
    text = '[[scan]]\nfile = "a.ply"\n'
    job = study(folder, text).jobs[0]
    assert study(folder, text.replace("a.ply", "b.ply")).jobs[0].key == job.key, "equal bytes"
    assert replace(job, name="other").key == job.key
    assert replace(job, config=replace(job.config, level=0.9)).key != job.key
    write_ply(folder / "a.ply", virtual("box", 2, n_points=2000).scan)
    assert study(folder, text).jobs[0].key != job.key, "another scan"
    (folder / "tape.csv").write_text("dimension,value,unit\nA,5,m\n")
    first = study(folder, text + 'tape = "tape.csv"\n').jobs[0].key
    (folder / "tape.csv").write_text("dimension,value,unit\nA,5.001,m\n")
    assert study(folder, text + 'tape = "tape.csv"\n').jobs[0].key != first, "another reading"


WRONG = {
    "no scan": ("[config.joint]\n", "names no scan"),
    "missing file": ('[[scan]]\nfile = "none.ply"\n', "none.ply"),
    "missing tape": ('[[scan]]\nfile = "a.ply"\ntape = "none.csv"\n', "none.csv"),
    "unknown key": ('[[scan]]\nfile = "a.ply"\ncolour = 3\n', "colour"),
    "unknown table": ('[[scans]]\nfile = "a.ply"\n', "scans"),
    "unknown setting": ('[config.x]\nspeed = 3\n[[scan]]\nfile = "a.ply"\n', "speed"),
    "unknown configuration": ('[[scan]]\nfile = "a.ply"\nconfigs = ["y"]\n', "'y'"),
    "twice": ('[[scan]]\nfile = "a.ply"\n[[scan]]\nfile = "a.ply"\n', "comes twice"),
    "unit": ('[[scan]]\nfile = "a.ply"\nunit = "yard"\n', "unit"),
    "no rooms": ('[[simulate]]\nname = "s"\nrooms = 0\n', "rooms"),
    "rooms in words": ('[[simulate]]\nname = "s"\nrooms = "two"\n', "rooms"),
    "no toml": ("[[scan]\n", "no manifest"),
}


@pytest.mark.parametrize(("text", "said"), WRONG.values(), ids=WRONG.keys())
def test_what_is_wrong_is_named(folder, text, said):
    with pytest.raises((ConfigError, InputError)) as caught:
        study(folder, text)
    assert said in str(caught.value)
    assert "Fix:" in str(caught.value)


SHARED = {
    "scans": '[[scan]]\nfile = "a.ply"\nname = "my room"\n[[scan]]\nfile = "b.ply"\nname = "my_room"\n',
    "configurations": '[config."x y"]\n[config.x_y]\n[[scan]]\nfile = "a.ply"\n',
}


@pytest.mark.parametrize("text", SHARED.values(), ids=SHARED.keys())
def test_two_models_never_share_a_folder(folder, text):
    assert len(study(folder, text).jobs) == 2
    with pytest.raises(ConfigError, match="one folder"):
        read_manifest(folder / "manifest.toml", folder / "models")


@pytest.mark.parametrize(
    "row",
    ["A,wall,x,2,m", "A,wall,nan,2,m", "A,wall,1,inf,m", "A,wall,1,2,yard", "A,wall,1", 'A,"wall,1,2,m'],
)
def test_a_wrong_row_of_a_publication_is_named_by_its_line(tmp_path, row):
    (tmp_path / "p.csv").write_text(f"# remark\ndimension,kind,value,reference,unit\n{row}\n")
    with pytest.raises(InputError, match="line 3"):
        read_published(tmp_path / "p.csv", "room", "paper", "kinect")
