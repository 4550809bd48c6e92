"""The width of the board's edges tells blur, in pixels, whatever else the picture is like."""

import cv2
import numpy as np
import pytest
from bathbot_depthcorr.views.sharpness import MOST_EDGE_WIDTH, edge_width
from depthcorr_bag import BOARD, COLOUR, drawn, poses


@pytest.fixture(scope="module", params=range(4))
def seen(request):
    """A drawn board and its true corners."""
    pose = list(poses(4))[request.param]
    corners = COLOUR.project(BOARD.corners @ pose[:3, :3].T + pose[:3, 3])
    return cv2.cvtColor(drawn(pose.tobytes()), cv2.COLOR_RGB2GRAY), corners


@pytest.mark.parametrize("size", [5, 7, 9])
@pytest.mark.parametrize("axis", [0, 1])
def test_motion_widens_edges_to_its_length(seen, size, axis):
    grey, corners = seen
    blurred = cv2.blur(grey, (size, 1) if axis else (1, size))
    assert edge_width(blurred, corners, BOARD) == pytest.approx(size, rel=0.15)
    assert edge_width(blurred, corners, BOARD) > MOST_EDGE_WIDTH


def test_sharp_pictures_pass_with_noise_and_little_contrast(seen):
    grey, corners = seen
    sharp = edge_width(grey, corners, BOARD)
    assert sharp < 2.5
    noisy = grey + np.random.default_rng(0).normal(0.0, 5.0, grey.shape)
    assert edge_width(np.clip(noisy, 0, 255).astype(np.uint8), corners, BOARD) == pytest.approx(
        sharp, rel=0.1
    )
    assert edge_width((0.3 * grey + 60).astype(np.uint8), corners, BOARD) == pytest.approx(sharp, rel=0.1)


def test_without_contrast_nothing_is_sharp(seen):
    assert edge_width(np.full_like(seen[0], 90), seen[1], BOARD) == np.inf
