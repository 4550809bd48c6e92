import pytest
from bathbot_perception.classes import SKIN_CLASSES
from bathbot_perception.errors import SettingsError
from bathbot_perception.model_card import accuracy_table, fill_card, marks, timing_table, training_summary
from tiny_model import row

BEGIN, END = marks("measured")


def test_only_the_marked_part_is_replaced(tmp_path):
    card = tmp_path / "card.md"
    card.write_text(f"# Title\n{BEGIN}\nold\n{END}\nrest\n")
    for text in ("first", "second"):
        fill_card(card, "measured", text)
    assert card.read_text() == f"# Title\n{BEGIN}\nsecond\n{END}\nrest\n"


def test_a_card_without_marks_is_left_alone(tmp_path):
    card = tmp_path / "card.md"
    card.write_text("# Title\n")
    with pytest.raises(SettingsError, match="must hold the lines"):
        fill_card(card, "measured", "text")
    assert card.read_text() == "# Title\n"


def test_the_tables_show_every_class_and_both_thread_counts(write_model):
    ap50 = {name: 0.5 for name in SKIN_CLASSES} | {"Foot_skin": None}
    table = accuracy_table({"photos": {"images": 3, "map50": 0.5, "map50_95": 0.25, "ap50": ap50}})
    assert (
        table.splitlines()[2] == "| photos | 3 | 0.500 | 0.250 | 0.500 | 0.500 | 0.500 | 0.500 | 0.500 | - |"
    )
    lines = timing_table(
        write_model([row("Hand_skin", 0.9, (32.0, 24.0), (16.0, 8.0))]), rounds=3
    ).splitlines()
    assert [line.split("|")[1].strip() for line in lines[2:4]] == ["1", "2"]


def test_the_training_summary_is_read_from_the_log(tmp_path):
    with pytest.raises(SettingsError, match="there is no"):
        training_summary(tmp_path)
    (tmp_path / "training.csv").write_text(
        "step,minutes,images_per_s\n50,0.4,15.0\n100,1.2,5.0\n150,1.6,14.0\n"
    )
    assert training_summary(tmp_path).startswith("150 steps in 2 minutes of training; 14.0 pictures/s")
