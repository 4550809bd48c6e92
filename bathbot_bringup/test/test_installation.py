import sys
from pathlib import Path

import pytest
from bathbot_bringup.errors import InputError
from bathbot_bringup.graph import installation
from bathbot_bringup.graph.node_table import NODES, find_node, node_command

PACKAGES = ("bathbot_bringup", "bathbot_depthcorr", "bathbot_localize", "bathbot_perception", "bathbot_scrub")


@pytest.mark.parametrize("package", PACKAGES)
def test_a_checkout_is_found_beside_its_package(package):
    assert (installation.package_folder(package) / "package.xml").is_file()


def test_an_installed_package_is_found_in_its_prefix(tmp_path, monkeypatch):
    (tmp_path / "share" / "some_package" / "config").mkdir(parents=True)
    (tmp_path / "share" / "some_package" / "config" / "node.yaml").touch()
    monkeypatch.setenv("AMENT_PREFIX_PATH", str(tmp_path))
    assert installation.config_file("some_package", "node.yaml").is_file()


def test_a_missing_package_says_what_to_try():
    with pytest.raises(InputError, match="no_such_package is not installed; run `make setup`"):
        installation.package_folder("no_such_package")


def test_a_missing_file_lists_those_that_exist():
    with pytest.raises(InputError, match=r"no configuration nothing\.yaml; there are .*recorder\.yaml"):
        installation.config_file("bathbot_bringup", "nothing.yaml")


def test_the_first_prefix_wins(tmp_path, monkeypatch):
    folder = tmp_path / "share" / "bathbot_msgs" / "msg"
    folder.mkdir(parents=True)
    monkeypatch.setenv("AMENT_PREFIX_PATH", str(tmp_path))
    assert installation.message_folders()["bathbot_msgs"] == folder
    assert installation.prefixes() == [tmp_path, Path(sys.prefix)]


@pytest.mark.parametrize("name", NODES)
def test_every_node_has_a_module_and_a_parameter_file(name):
    from importlib.util import find_spec

    entry = find_node(name)
    assert find_spec(entry.module) is not None
    assert entry.parameter_file.is_file()


def test_parameters_reach_the_command_line_with_their_types():
    command = node_command(
        find_node("recorder"), {"a": "it's", "b": 2.0, "c": True, "d": 3, "e": 1e-7, "f": Path("x")}
    )
    given = [command[i + 1] for i, word in enumerate(command) if word == "-p"]
    assert given == ["a:='it''s'", "b:=2.0", "c:=true", "d:=3", "e:=1e-07", "f:='x'"]
