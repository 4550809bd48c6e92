import json
import subprocess
import sys

import pytest
from bathbot_bringup.bathing.steps import full_region_name
from bathbot_bringup.command.arguments import board_size, seed_list
from bathbot_bringup.command.cli import run
from bathbot_bringup.errors import InputError
from bathbot_depthcorr.node.dds import reach
from hypothesis import given, settings
from hypothesis import strategies as st

COMMANDS = (
    "demo", "bathe", "detect", "replay", "record", "calibrate depth", "calibrate hand-eye", "evaluate demo",
    "evaluate detector", "evaluate localization", "node", "sim-arm", "simulate board", "simulate marker",
    "train detector", "bench depth", "bench detector", "evaluate regions", "export detector", "keys",
)  # fmt: skip


def complaint(capsys, *arguments: str) -> str:
    """Run a command line that must fail politely; give its one line on stderr."""
    assert run([str(argument) for argument in arguments]) == 2
    lines = capsys.readouterr().err.splitlines()
    assert len(lines) == 1, lines
    assert lines[0].startswith("bathbot: ")
    return lines[0]


def test_every_command_explains_itself(capsys):
    for line in COMMANDS:
        words = line.split()
        assert run([*words, "--help"]) == 0
        shown = capsys.readouterr().out
        assert "Usage" in shown
        assert f"bathbot {line}" in shown, f"{line} has no example"


def test_keys_that_are_missing_end_a_command_before_ros_looks_for_them(capsys, monkeypatch, tmp_path):
    for name, value in reach.network_variables(tmp_path, "/nobody").items():
        monkeypatch.setenv(name, value)
    assert "the enclave '/nobody' of" in complaint(capsys, "status", "--domain", "5")


@pytest.mark.graph
def test_help_loads_nothing_heavy():
    program = "import sys; from bathbot_bringup.command.cli import run; run(['--help']); print(*sys.modules)"
    outcome = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True)
    assert "Usage: bathbot" in outcome.stdout
    heavy = {"rclpy", "onnxruntime", "cv2", "numba", "numpy", "scipy", "matplotlib", "rosbags"}
    assert not heavy & set(outcome.stdout.splitlines()[-1].split())


@pytest.mark.parametrize(("line", "said"), [
    pytest.param("demo --region nose", "no region is named 'nose'; there are Face_skin", id="region"),
    pytest.param("demo --scenario earthquake", "no scenario 'earthquake'; there are", id="scenario"),
    pytest.param("demo --seed -1", "seed must lie in 0..", id="seed"),
    pytest.param("demo --seed one", "integer, got 'one'; see bathbot demo --help", id="seed of letters"),
    pytest.param("demo --rate nan", "rate must lie in 1..60 Hz, got nan", id="rate"),
    pytest.param("demo --duration 0", "duration must lie in 1..600 s, got 0.0", id="duration"),
    pytest.param("demo --preset best", "no preset is named 'best'", id="preset"),
    pytest.param("demo --colour red", "No such option", id="option"),
    pytest.param("wash", "No such command 'wash'", id="command"),
    pytest.param("detect nowhere.jpg --out x", "there is no nowhere.jpg", id="picture"),
    pytest.param("detect nowhere.jpg", "Missing option '--out'", id="no out"),
    pytest.param("detect . --out x --model no.onnx", "there is no model file no.onnx", id="model"),
    pytest.param("replay nowhere", "there is no bag nowhere", id="bag"),
    pytest.param("replay nowhere --rate 0", "0", id="replay rate"),
    pytest.param("record --out x --profile all", "no privacy profile is named 'all'", id="profile"),
    pytest.param("record --out x --profile full", "needs consent", id="consent"),
    pytest.param("node camera", "no node is named 'camera'; did you mean sim_camera?", id="node"),
    pytest.param("calibrate depth nowhere --out x.npz", "nowhere", id="calibration bag"),
    pytest.param("calibrate depth nowhere --out x.npz --board 11", "got '11'", id="board"),
    pytest.param("calibrate hand-eye nowhere --out x.yaml", "nowhere", id="hand-eye bag"),
    pytest.param("evaluate detector nowhere", "nowhere", id="data set"),
    pytest.param("evaluate safety --json .", ". is a folder; name a file in it", id="numbers to a folder"),
    pytest.param("bench arm --json /dev/null/x/y.json", "/dev/null is no folder", id="numbers to nowhere"),
    pytest.param("bench depth --size big", "a size is written as width x height", id="bench size"),
    pytest.param("bench depth --rate nan", "rate must lie in 1..120 Hz, got nan", id="bench rate"),
    pytest.param("bench depth --seconds 0", "seconds must lie in 1..3600, got 0.0", id="bench seconds"),
    pytest.param("bench depth --rate many", "got 'many'; see bathbot bench depth --help", id="bench letters"),
    pytest.param("evaluate demo --seeds 5-1", "the range 5-1", id="seeds"),
    pytest.param("keys /dev/null", "not an empty folder; name a new one", id="keys"),
    pytest.param("keys x --domain 233", "got '233'", id="domain of keys"),
    pytest.param("simulate board --out x --preset best", "no D455 preset 'best'", id="simulated preset"),
    pytest.param("simulate marker --out x --poses 0", "got '0'", id="simulated poses"),
    pytest.param("train detector nowhere --out x", "there is no nowhere", id="training data"),
    pytest.param("train detector . --out x --scratch --resume .", "exclude each other", id="two beginnings"),
    pytest.param("train detector . --out x --resume . --optimiser sgd", "leave them out", id="optimiser"),
    pytest.param("train detector . --out x --corrections nowhere", "there is no nowhere", id="corrections"),
    pytest.param("evaluate regions --region nose", "no region is named 'nose'", id="region to find"),
    pytest.param("evaluate regions --seeds x", "seeds are numbers and ranges", id="seeds to look at"),
    pytest.param("bench detector --rounds 3", "rounds must be 10 or more, got 3", id="rounds"),
    pytest.param("bench detector --size 100", "in steps of 32, got 100", id="input size"),
    pytest.param("export detector --out x --precision fp8", "must be one of fp32, fp16, int8", id="fp8"),
    pytest.param("export detector --out x --shape 640x400", "multiples of 32 px", id="shape"),
    pytest.param("export detector --out x --precision int8", "needs pictures", id="int8 of nothing"),
    pytest.param("export detector --out x --model no.onnx", "there is no model file no.onnx", id="no model"),
    pytest.param("sim-arm --host no.such.host.invalid", "no.such.host.invalid", id="address"),
    pytest.param("sim-arm --port 99999", "got '99999'", id="port"),
])  # fmt: skip
def test_bad_input_is_one_line_and_leaves_nothing_behind(capsys, tmp_path, monkeypatch, line, said):
    monkeypatch.chdir(tmp_path)
    assert said in complaint(capsys, *line.split())
    assert list(tmp_path.iterdir()) == []


def test_a_file_that_is_no_picture(capsys, tmp_path):
    broken = tmp_path / "broken.jpg"
    broken.write_bytes(b"\xff\xd8\xff\xe0 not a picture")
    assert "broken.jpg" in complaint(capsys, "detect", broken, "--out", tmp_path / "out")
    assert not (tmp_path / "out").exists()


def test_a_file_that_is_no_model(capsys, tmp_path):
    model = tmp_path / "model.onnx"
    model.write_text("no model")
    assert "cannot load" in complaint(capsys, "detect", tmp_path, "--out", tmp_path / "out", "--model", model)


@pytest.mark.parametrize(
    "content", [b"", b"no bag at all", b"\x89MCAP0\r\n cut off"], ids=["empty", "text", "cut off"]
)
def test_a_file_that_is_no_bag(capsys, tmp_path, content):
    bag = tmp_path / "bag.mcap"
    bag.write_bytes(content)
    for arguments in (["replay", bag], ["detect", bag, "--out", tmp_path / "x"],
                      ["calibrate", "depth", bag, "--out", tmp_path / "x.npz"]):  # fmt: skip
        assert "bag.mcap" in complaint(capsys, *arguments)
    assert [file.name for file in tmp_path.iterdir()] == ["bag.mcap"]


def test_a_folder_that_is_no_bag(capsys, tmp_path):
    assert "metadata.yaml" in complaint(capsys, "replay", tmp_path)


def test_an_existing_bag_is_not_overwritten(capsys, tmp_path):
    (tmp_path / "bag").mkdir()
    assert "exists already" in complaint(capsys, "record", "--out", tmp_path / "bag")


@pytest.mark.parametrize("command", [
    "demo", "detect photo.jpg", "evaluate demo", "evaluate safety",
])  # fmt: skip
def test_results_never_mix_with_those_of_an_earlier_run(capsys, tmp_path, command):
    used = tmp_path / "used"
    used.mkdir()
    (used / "summary.json").touch()
    for out in (used, used / "summary.json"):
        assert "is there already" in complaint(capsys, *command.split(), "--out", out)
    assert [file.name for file in used.iterdir()] == ["summary.json"]


@pytest.mark.graph
def test_mistakes_leave_no_traceback_in_a_real_process():
    outcome = subprocess.run(
        [sys.executable, "-m", "bathbot_bringup.command.cli", "demo", "--region", "nose"],
        capture_output=True,
        text=True,
    )
    assert outcome.returncode == 2
    assert len(outcome.stderr.splitlines()) == 1
    assert "Traceback" not in outcome.stdout + outcome.stderr


def test_the_nodes_are_listed(capsys):
    assert run(["node"]) == 0
    assert "rm65_driver" in capsys.readouterr().out


def test_a_node_explains_its_parameters_with_units_and_ranges(capsys):
    assert run(["node", "rm65_driver", "--help"]) == 0
    told = capsys.readouterr().out
    assert "retract_speed: " in told
    assert "[m/s]; must lie in" in told
    assert run(["node", "--help"]) == 0
    assert "list the nodes" in capsys.readouterr().out


def test_the_version_is_shown(capsys):
    assert run(["--version"]) == 0
    assert capsys.readouterr().out.startswith("bathbot 0.")


@pytest.mark.parametrize(("text", "seeds"), [("3", [3]), ("0-3", [0, 1, 2, 3]), ("0-1,7,1", [0, 1, 7])])
def test_seeds_are_read(text, seeds):
    assert seed_list(text) == seeds


@pytest.mark.parametrize("text", ["", "a", "1-", "-1", "1,,2", "3-1", "0-99999999"])
def test_bad_seeds_are_refused(text):
    with pytest.raises(InputError):
        seed_list(text)


@settings(deadline=None)
@given(st.text(max_size=8))
def test_a_board_is_read_or_refused(text):
    try:
        columns, rows = board_size(text)
    except InputError:
        return
    assert min(columns, rows) >= 2


@pytest.mark.parametrize("name", ["trunk", "Trunk", "TRUNK_SKIN", " Trunk_skin "])
def test_regions_have_short_names(name):
    assert full_region_name(name) == "Trunk_skin"


def test_numbers_that_do_not_exist_become_null(tmp_path):
    import numpy as np
    from bathbot_bringup.files import write_json

    write_json(
        tmp_path / "x.json", {"a": float("nan"), "b": np.float32(1.5), "c": [np.inf, np.int64(2)], "d": True}
    )
    assert json.loads((tmp_path / "x.json").read_text()) == {"a": None, "b": 1.5, "c": [None, 2], "d": True}
