"""`indoorfit explain`: the decision on the plan as text, JSON and picture."""

import json


def test_explain_writes_its_four_files_and_prints_one(run_cli, room_ply, tmp_path):
    outcome = run_cli("explain", room_ply, "--out", tmp_path / "why", "--json", "--quiet")
    assert outcome.code == 0
    document = json.loads(outcome.out)
    folder = tmp_path / "why"
    assert sorted(p.name for p in folder.iterdir()) == [
        f"explain.{kind}" for kind in ("json", "png", "svg", "txt")
    ]
    assert document == json.loads((folder / "explain.json").read_text(encoding="utf-8"))
    text = (folder / "explain.txt").read_text(encoding="utf-8")
    drawing = (folder / "explain.svg").read_text(encoding="utf-8")
    for candidate in document["candidates"]:
        assert f"{candidate['id']}: {candidate['reason']}" in text
        assert f">{candidate['id']}</text>" in drawing
    assert (folder / "explain.png").read_bytes().startswith(b"\x89PNG")
    assert run_cli("explain", room_ply, "--out", folder, "--quiet").code == 1
    assert run_cli("explain", room_ply, "--out", folder, "--quiet", "--overwrite").code == 0


def test_points_told_by_explain_are_taken_by_fit(run_cli, room_ply, tmp_path):
    document = json.loads(run_cli("explain", room_ply, "--json", "--quiet").out)
    wall = next(c for c in document["candidates"] if c["verdict"] == "accepted")
    said = tmp_path / "said.toml"
    said.write_text(
        f"[[overrides.force_wall]]\nfrom_m = {wall['from_scan']}\nto_m = {wall['to_scan']}\n",
        encoding="utf-8",
    )
    outcome = run_cli("fit", room_ply, "--out", tmp_path / "room", "--overrides", said, "--json", "--quiet")
    assert outcome.code == 0
    model = json.loads(outcome.out)
    assert model["provenance"]["config"]["overrides"]["force_wall"][0]["from_m"] == wall["from_scan"]
    assert any(note["code"] == "OVERRIDDEN" for note in model["warnings"])


def test_explain_leaves_nothing_behind_where_no_room_is(run_cli, xyz, tmp_path):
    path = xyz([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]])
    outcome = run_cli("explain", path, "--out", tmp_path / "why")
    assert outcome.code == 1
    assert "Fix:" in outcome.err
    assert not (tmp_path / "why").exists()
