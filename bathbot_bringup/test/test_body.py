"""The committed bodies: seated adults with all six parts."""

import numpy as np
import pytest
from bathbot_bringup.sim.body import (
    BODIES,
    Part,
    Side,
    UnknownBodyError,
    body_count,
    breathing_weights,
    load_body,
    vertex_normals,
)
from bathbot_perception.classes import SKIN_CLASSES
from numpy.testing import assert_allclose


def test_the_file_is_small_and_holds_ten_bodies_or_more():
    assert BODIES.stat().st_size < 1.5e6
    assert body_count() >= 10


@pytest.mark.parametrize("index", range(body_count()))
def test_a_body_is_a_seated_adult_with_all_parts(index):
    body = load_body(index)
    assert set(body.parts) == {part for part in Part if part != Part.NOT_SKIN}
    assert len(SKIN_CLASSES) == len(set(body.parts))
    assert 0.75 < body.vertices[:, 2].max() < 1.1  # from seat to crown
    assert -0.7 < body.vertices[:, 2].min() < -0.2  # feet below the seat
    assert body.landmarks["lowerleg01.L"][0] > 0.3  # knees forward
    assert body.landmarks["upperarm01.L"][1] > 0.1 > body.landmarks["upperarm01.R"][1]


def test_both_sexes_sit_there():
    assert {load_body(index).male for index in range(body_count())} == {True, False}


def test_normals_point_outward():
    body = load_body(0)
    normals = vertex_normals(body.vertices, body.faces)
    assert_allclose(np.linalg.norm(normals, axis=1), 1.0, atol=1e-6)
    chest = (body.parts == Part.TRUNK) & (np.abs(body.fraction - 0.6) < 0.1)
    front = chest & (body.vertices[:, 0] > np.quantile(body.vertices[chest, 0], 0.8))
    assert normals[front, 0].mean() > 0.5


def test_only_paired_parts_have_sides():
    body = load_body(0)
    middle = np.isin(body.parts, (Part.FACE, Part.TRUNK))
    assert (body.sides[middle] == Side.MIDDLE).all()
    assert (body.sides[~middle] != Side.MIDDLE).all()


def test_breath_moves_the_front_of_the_trunk_only():
    body = load_body(1)
    weights = breathing_weights(body)
    assert weights.min() >= 0.0
    assert weights.max() == 1.0
    assert body.parts[np.argmax(weights)] == Part.TRUNK
    assert weights[np.isin(body.parts, (Part.HAND, Part.FOOT, Part.FACE))].max() < 0.01


def test_an_unknown_body_is_refused_by_name_of_what_there_is():
    with pytest.raises(UnknownBodyError, match="holds bodies 0"):
        load_body(99)
