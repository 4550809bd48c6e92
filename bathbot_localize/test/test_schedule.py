"""What is made at a rate is due by the stamps of the pictures, not by the clock."""

from bathbot_localize.target.schedule import Schedule


def due(stamps, **rates):
    schedule = Schedule(**rates or {"surface": 10.0})
    return [stamp for stamp in stamps if schedule.due("surface", stamp)]


def test_the_first_is_due_and_then_one_a_period():
    assert due([5.0, 5.03, 5.06, 5.09, 5.12, 5.15]) == [5.0, 5.12]


def test_a_picture_a_little_early_counts_as_in_time():
    assert due([5.0, 5.096]) == [5.0, 5.096]


def test_after_a_jump_back_in_time_it_is_due_at_once():
    assert due([100.0, 1.0, 1.05]) == [100.0, 1.0]


def test_names_do_not_wait_for_each_other_and_a_failed_one_comes_again():
    schedule = Schedule(surface=10.0, body_cloud=1.0)
    assert schedule.due("surface", 5.0)
    assert schedule.due("body_cloud", 5.0)
    assert not schedule.due("body_cloud", 5.5)
    schedule.repeat("body_cloud")
    schedule.repeat("contact_targets")
    assert schedule.due("body_cloud", 5.5)
