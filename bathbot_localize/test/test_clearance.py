"""Room for the scrub head."""

import numpy as np
from bathbot_localize.arm.clearance import Column, clear, has_room
from hypothesis import assume, given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

COLUMN = Column(radius=0.03, foot=0.01, top=0.2)
UP = np.array([[0.0, 0.0, 1.0]])
AT = np.zeros((1, 3))


def cluster(position):
    """A few points close together; single ones count as noise."""
    return np.asarray(position) + 1e-4 * np.arange(5)[:, None]


@given(
    radius=st.floats(0.0, 0.06),
    height=st.floats(-0.1, 0.3),
    seed=st.integers(0, 1000),
    side=st.floats(0, 6.28),
)
def test_a_place_is_clear_unless_something_stands_in_its_column(radius, height, seed, side):
    """Whatever the frame."""
    assume(min(abs(radius - 0.03), abs(height - 0.01), abs(height - 0.2)) > 1e-3)
    turn, shift = Rotation.random(random_state=seed), np.random.default_rng(seed).normal(size=3)
    seen = cluster([radius * np.cos(side), radius * np.sin(side), height])
    place, outward = turn.apply(AT) + shift, turn.apply(UP)
    expected = not (radius < 0.03 and 0.01 < height < 0.2)
    assert clear(turn.apply(seen) + shift, place, outward, COLUMN)[0] == expected


def test_single_points_are_noise():
    assert clear([[0.0, 0.0, 0.05], [np.nan] * 3], AT, UP, COLUMN).all()


def test_many_places_are_judged_one_by_one():
    places = np.column_stack([np.linspace(-0.5, 0.5, 501), np.zeros(501), np.zeros(501)])
    free = clear(cluster([0.1, 0.0, 0.05]), places, np.tile(UP, (501, 1)), COLUMN)
    assert (free == (np.abs(places[:, 0] - 0.1) > 0.03)).mean() > 0.99


def test_nothing_seen_and_no_places():
    assert clear(np.full((4, 5, 3), np.nan), AT, UP, COLUMN).all()
    assert len(clear(cluster([0, 0, 0]), np.empty((0, 3)), np.empty((0, 3)), COLUMN)) == 0


def ground(height):
    """A floor seen from above, raised by `height(x, y)` [m]; 4 mm between cells."""
    x, y = np.meshgrid(np.arange(-0.2, 0.2, 0.004), np.arange(-0.15, 0.15, 0.004))
    return np.stack([x, y, height(x, y)], axis=-1)


def test_a_floor_has_room_but_beside_a_wall():
    points = ground(lambda x, y: np.where(x > 0.1, 0.05, 0.0))
    free = has_room(points, np.broadcast_to(UP, points.shape), COLUMN)
    assert free[points[..., 0] < 0.1 - 0.03 - 0.012].all()
    assert not free[(points[..., 0] > 0.1 - 0.03 + 0.012) & (points[..., 0] < 0.1)].any()
    assert free[points[..., 0] > 0.112].all()


def test_where_nothing_was_seen_there_is_no_room():
    points = ground(lambda x, y: 0.0 * x)
    points[:20] = np.nan
    free = has_room(points, np.broadcast_to(UP, points.shape), COLUMN)
    assert not free[:20].any()
    assert free[20:].all()
