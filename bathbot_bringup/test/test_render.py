"""Pictures: the z-buffer against ray casting, planes, labels and boxes."""

from xml.etree import ElementTree

import numpy as np
import pytest
from bathbot_bringup.sim.body import Part, Side, load_body
from bathbot_bringup.sim.render.bathroom import random_lighting, random_room
from bathbot_bringup.sim.render.boxes import SkinBox, skin_boxes, write_voc
from bathbot_bringup.sim.render.light import ray_scene
from bathbot_bringup.sim.render.mesh import box_shape, capsule_shape, cylinder_shape, merged, plain_mesh
from bathbot_bringup.sim.render.poster import Poster, draw_poster
from bathbot_bringup.sim.render.raster import project_vertices, rasterise
from bathbot_bringup.sim.render.render import camera_rays, developed, render
from bathbot_bringup.sim.render.stage import lit_stage, looking_at
from bathbot_bringup.sim.render.weather import Weather, weathered
from bathbot_bringup.sim.skin_tone import dressed, random_look
from bathbot_depthcorr.geometry.pinhole import Pinhole
from bathbot_depthcorr.geometry.rigid import rotate
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.testing import assert_allclose

CAMERA = Pinhole(212, 120, 105.0, 105.0, 105.5, 59.5)
VIEW = looking_at((1.3, 0.4, 0.6), (0.1, 0.0, 0.2))


@pytest.fixture(scope="module")
def stage():
    rng, body = np.random.default_rng(0), load_body(1)
    room = random_room(rng, (-0.5, -0.8, -0.6), (1.6, 0.8, 2.0))
    stool = plain_mesh(*cylinder_shape((0.0, 0.0, -0.05), (0.0, 0.0, -0.01), (0.16, 0.17)), (0.5, 0.5, 0.5))
    mesh = merged([dressed(body, random_look(rng, body.male), rng), stool])
    return lit_stage(mesh, room, random_lighting(rng, room), rng, rays=4, samples=1)


@pytest.fixture(scope="module")
def rendering(stage):
    return render(stage, CAMERA, VIEW)


def test_depth_agrees_with_ray_casting(stage, rendering):
    rays = rotate(VIEW, camera_rays(CAMERA)).reshape(-1, 3)
    origins = np.broadcast_to(VIEW[:3, 3], rays.shape)
    hit = ray_scene(stage.mesh.vertices, stage.mesh.faces).cast_rays(
        np.concatenate([origins, rays], 1).astype(np.float32)
    )
    cast = hit["t_hit"].numpy().reshape(rendering.depth.shape)
    room = stage.room.hit(VIEW[:3, 3], rays).distance.reshape(cast.shape)
    expected = np.minimum(cast, room)
    off = np.abs(rendering.depth - expected)
    assert np.quantile(off, 0.99) < 1e-4
    assert (off > 0.01).mean() < 0.002  # pixels on a contour may fall on either side


def test_the_floor_is_where_the_plane_is(rendering, stage):
    rays = rotate(VIEW, camera_rays(CAMERA))
    height = VIEW[2, 3] + rays[..., 2] * rendering.depth
    assert height.min() > stage.room.low[2] - 1e-4
    assert (np.abs(height - stage.room.low[2]) < 1e-4).mean() > 0.05


def test_labels_and_sides_are_those_of_the_person(rendering):
    seen = set(np.unique(rendering.parts))
    assert {Part.TRUNK, Part.UPPER_LIMB, Part.LOWER_LIMB, Part.FACE} <= seen
    assert (rendering.sides[rendering.parts == Part.NOT_SKIN] == Side.MIDDLE).all()
    assert (rendering.sides[rendering.parts == Part.TRUNK] == Side.MIDDLE).all()
    assert (rendering.sides[rendering.parts == Part.HAND] != Side.MIDDLE).all()


def test_left_is_left(rendering):
    columns = np.broadcast_to(np.arange(CAMERA.width), rendering.parts.shape)
    limb = rendering.parts == Part.UPPER_LIMB
    left, right = (columns[limb & (rendering.sides == side)].mean() for side in (Side.LEFT, Side.RIGHT))
    assert left > right  # who faces the camera has the left arm on its right


def test_boxes_hold_all_skin_of_their_part(rendering):
    boxes = skin_boxes(rendering.parts, rendering.sides)
    assert {box.part for box in boxes} >= {Part.TRUNK, Part.LOWER_LIMB}
    for part in (Part.TRUNK, Part.FACE):
        mine = [box for box in boxes if box.part == part]
        rows, columns = np.nonzero(rendering.parts == part)
        inside = np.zeros(len(rows), dtype=bool)
        for box in mine:
            inside |= (
                (columns >= box.left) & (columns <= box.right) & (rows >= box.top) & (rows <= box.bottom)
            )
        assert inside.mean() > 0.97


@given(left=st.integers(0, 60), top=st.integers(0, 40), width=st.integers(12, 30), height=st.integers(12, 30))
def test_a_box_is_exactly_a_rectangle_of_labels(left, top, width, height):
    parts = np.full((80, 100), Part.NOT_SKIN, dtype=np.uint8)
    parts[top : top + height, left : left + width] = Part.TRUNK
    expected = SkinBox(Part.TRUNK, left, top, min(left + width, 100) - 1, min(top + height, 80) - 1)
    assert skin_boxes(parts, np.zeros_like(parts)) == [expected]


def test_one_box_goes_round_both_pieces_of_a_divided_arm_but_not_round_specks():
    parts = np.full((80, 100), Part.NOT_SKIN, dtype=np.uint8)
    sides = np.full_like(parts, Side.LEFT)
    parts[10:30, 10:25], parts[50:70, 12:25], parts[0, 99] = Part.UPPER_LIMB, Part.UPPER_LIMB, Part.UPPER_LIMB
    assert skin_boxes(parts, sides) == [SkinBox(Part.UPPER_LIMB, 10, 10, 24, 69)]


def test_small_boxes_are_dropped():
    parts = np.full((80, 100), Part.NOT_SKIN, dtype=np.uint8)
    parts[10:21, 10:40] = Part.HAND
    assert skin_boxes(parts, np.full_like(parts, Side.LEFT)) == []


def test_voc_counts_from_one(tmp_path):
    write_voc(tmp_path / "1.xml", "1.jpg", (80, 100), [SkinBox(Part.FACE, 0, 1, 30, 40)])
    root = ElementTree.parse(tmp_path / "1.xml").getroot()
    assert root.findtext("object/name") == "Face_skin"
    assert [root.findtext(f"object/bndbox/{key}") for key in ("xmin", "ymin", "xmax", "ymax")] == [
        "1",
        "2",
        "31",
        "41",
    ]
    assert root.findtext("size/width") == "100"


def test_what_is_narrower_than_the_brush_is_difficult(tmp_path):
    boxes = [SkinBox(Part.HAND, 100, 100, 100 + side - 1, 180) for side in (19, 20)]
    write_voc(tmp_path / "1.xml", "1.jpg", (480, 640), boxes)
    root = ElementTree.parse(tmp_path / "1.xml").getroot()
    assert [node.findtext("difficult") for node in root.findall("object")] == ["0", "1"]


def test_what_hides_the_scene_is_no_longer_skin(rendering):
    hidden = weathered(rendering, Weather(occluders=3), np.random.default_rng(1))
    assert (hidden.parts != Part.NOT_SKIN).sum() <= (rendering.parts != Part.NOT_SKIN).sum()
    assert hidden.colour.shape == rendering.colour.shape


def test_steam_lowers_contrast(rendering):
    steamy = weathered(rendering, Weather(steam=1.0, noise=0.0), np.random.default_rng(1))
    assert steamy.colour.std() < 0.8 * rendering.colour.std()


@settings(max_examples=30)
@given(light=st.floats(0.0, 10.0), more=st.floats(0.0, 1.0))
def test_more_light_is_never_darker(light, more):
    dim, bright = (developed(np.full((1, 3), value, np.float32)) for value in (light, light + more))
    assert (bright >= dim).all()


@pytest.mark.parametrize(
    "shape",
    [
        pytest.param(capsule_shape((0, 0, 0), (0.1, 0.2, 0.3), 0.05), id="capsule"),
        pytest.param(cylinder_shape((0, 0, 0), (0.0, 0.1, 0.3), (0.05, 0.03)), id="cylinder"),
        pytest.param(box_shape((0.1, 0.2, 0.3)), id="box"),
    ],
)
def test_shapes_are_closed_and_face_outward(shape):
    vertices, faces = shape
    corners = vertices[faces]
    volume = np.einsum("ij,ij->i", corners[:, 0], np.cross(corners[:, 1], corners[:, 2])).sum() / 6.0
    assert volume > 0.0


def test_a_triangle_seen_from_behind_or_behind_the_camera_is_not_drawn():
    square, faces = (
        np.array([(-1, -1, 2.0), (1, -1, 2.0), (1, 1, 2.0), (-1, 1, 2.0)]),
        np.array([(0, 1, 2), (0, 2, 3)]),
    )
    empty = np.full((120, 212), np.inf, dtype=np.float32)
    front = rasterise(project_vertices(square, CAMERA, np.eye(4)), faces[:, ::-1].astype(np.int32), empty)
    back = rasterise(project_vertices(square, CAMERA, np.eye(4)), faces.astype(np.int32), empty)
    behind = rasterise(
        project_vertices(square * (1, 1, -1), CAMERA, np.eye(4)), faces.astype(np.int32), empty
    )
    assert_allclose(front.depth[60, 106], 2.0, rtol=1e-6)
    assert (back.face == -1).all()
    assert (behind.face == -1).all()


def test_a_poster_covers_exactly_its_area():
    poster = Poster(0.4, 0.2, np.ones((1, 1), np.float32))
    radiance, depth = np.zeros((120, 212, 3), np.float32), np.full((120, 212), np.inf, np.float32)
    T_world_poster = np.eye(4)
    T_world_poster[2, 3] = 0.5
    draw_poster(poster, T_world_poster, CAMERA, np.eye(4), (1.0, 1.0, 1.0), radiance, depth)
    assert_allclose(radiance[..., 0].sum(), 0.4 * 0.2 * (105.0 / 0.5) ** 2, rtol=0.02)
    assert_allclose(depth[np.isfinite(depth)], 0.5, rtol=1e-6)
