"""Look-ups in the tree of frames: consistent, in time, and plain about what is missing."""

import numpy as np
import pytest
from bathbot_depthcorr.geometry.frame_tree import FrameTree, UnknownFrameError
from bathbot_depthcorr.geometry.rigid import inverse, transform_from
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

NAMES = [f"f{i}" for i in range(8)]


def random_transform(rng):
    return transform_from(Rotation.random(random_state=rng).as_matrix(), rng.normal(size=3))


@settings(max_examples=50, deadline=None)
@given(parents=st.tuples(*[st.integers(0, i) for i in range(7)]), seed=st.integers(0, 1000))
def test_look_ups_chain_and_invert_in_any_tree(parents, seed):
    rng, tree = np.random.default_rng(seed), FrameTree()
    for child, parent in enumerate(parents, start=1):
        tree.add(NAMES[parent], NAMES[child], random_transform(rng))
    a, b, c = rng.choice(NAMES, 3)
    np.testing.assert_allclose(tree.lookup(a, a), np.eye(4), atol=1e-9)
    np.testing.assert_allclose(tree.lookup(a, b) @ tree.lookup(b, c), tree.lookup(a, c), atol=1e-9)
    np.testing.assert_allclose(inverse(tree.lookup(a, b)), tree.lookup(b, a), atol=1e-9)


def test_a_frame_moves_evenly_between_what_is_told_of_it():
    tree = FrameTree()
    for stamp in (0.0, 0.1, 0.2):
        turn = Rotation.from_rotvec([0.0, 0.0, 4.0 * stamp]).as_matrix()
        tree.add("base_link", "Link1", transform_from(turn, (stamp, 0.0, 0.0)), stamp)
    for stamp in (0.1, 0.12, 0.2):
        T = tree.lookup("base_link", "Link1", stamp)
        assert T[0, 3] == pytest.approx(stamp)
        np.testing.assert_allclose(
            Rotation.from_matrix(T[:3, :3]).as_rotvec(), [0.0, 0.0, 4.0 * stamp], atol=1e-9
        )
    assert tree.lookup("base_link", "Link1")[0, 3] == pytest.approx(0.2)
    assert tree.lookup("base_link", "Link1", 0.25)[0, 3] == pytest.approx(0.2)
    assert tree.lookup("base_link", "Link1", -0.05)[0, 3] == pytest.approx(0.0)
    with pytest.raises(UnknownFrameError, match=r"0\.80 s away"):
        tree.lookup("base_link", "Link1", 1.0)


def test_static_transforms_hold_at_any_time():
    tree = FrameTree()
    tree.add("camera_link", "eye", transform_from(translation=(0.0, 0.1, 0.0)))
    assert tree.lookup("camera_link", "eye", 1e9)[1, 3] == pytest.approx(0.1)


def test_frames_that_nothing_joins_are_named():
    tree = FrameTree()
    tree.add("base_link", "Link1", np.eye(4))
    tree.add("camera_link", "eye", np.eye(4))
    with pytest.raises(UnknownFrameError, match="from eye to base_link; known frames are Link1, base_link"):
        tree.lookup("base_link", "eye")
    with pytest.raises(UnknownFrameError, match="known frames are none"):
        FrameTree().lookup("base_link", "eye")


def test_a_loop_does_not_hang():
    tree = FrameTree()
    tree.add("a", "b", np.eye(4))
    tree.add("b", "a", np.eye(4))
    with pytest.raises(UnknownFrameError):
        tree.lookup("a", "c")
