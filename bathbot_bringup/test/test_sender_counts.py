"""What was lost on the way, against publishers that count."""

from bathbot_bringup.bag.recording.sender_counts import SenderCounts
from hypothesis import given
from hypothesis import strategies as st

ONE, OTHER = b"1", b"2"


@given(kept=st.lists(st.booleans(), min_size=2), first=st.integers(1, 10**6))
def test_all_between_the_first_and_the_last_that_came_are_counted(kept, first):
    counts = SenderCounts()
    came = [first + place for place, there in enumerate(kept) if there]
    missed = sum(counts.missed("/tf", ONE, number) for number in came)
    assert missed == (came[-1] - came[0] + 1 - len(came) if came else 0)


def test_publishers_and_topics_count_for_themselves():
    counts = SenderCounts()
    for number in (1, 2, 5):
        for topic in ("/tf", "/wrench"):
            for publisher in (ONE, OTHER):
                assert counts.missed(topic, publisher, number) == (2 if number == 5 else 0)


def test_a_middleware_that_does_not_count_loses_nothing():
    counts = SenderCounts()
    assert [counts.missed("/tf", ONE, 0) for _ in range(3)] == [0, 0, 0]


def test_what_comes_late_changes_nothing():
    counts = SenderCounts()
    assert [counts.missed("/tf", ONE, number) for number in (1, 3, 2, 4)] == [0, 1, 0, 0]
