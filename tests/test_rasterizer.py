"""Properties of the renderer on meshes whose picture is known."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from han_bullet.geometry import Array, Intrinsics, look_at
from han_bullet.sim.mesh import Mesh
from han_bullet.sim.raster import Raster, View
from han_bullet.sim.rasterizer import NEAR, draw
from han_bullet.sim.surfaces import Surface, rectangle
from han_bullet.world_schema import Light

CAMERA = Intrinsics(64, 48, 50.0, 50.0, 32.0, 24.0)
AHEAD = look_at(np.zeros(3), np.array([1.0, 0.0, 0.0]))
WHITE = np.full((1, 1, 3), 255, np.uint8)


def picture(*meshes: Mesh, light: Light | None = None) -> Raster:
    raster = Raster.blank(CAMERA)
    for mesh in meshes:
        draw(raster, mesh, View(CAMERA, AHEAD), light or Light())
    return raster


def wall(distance: float, texture: Array | None = None, size: float = 100.0) -> Mesh:
    """An upright square that faces the camera, its texture one picture over all of it."""
    corner = np.array([distance, 0.5 * size, -0.5 * size])
    surface = rectangle(corner, np.array([0.0, -size, 0.0]), np.array([0.0, 0.0, size]))
    uvs = surface.uvs / size
    return Mesh(
        Surface(surface.vertices, surface.normals, uvs, surface.triangles), WHITE if texture is None else texture
    )


def test_a_wall_has_its_depth_everywhere_and_hides_what_is_behind_in_either_order() -> None:
    red = np.array([[[200, 0, 0]]], np.uint8)
    for meshes in ((wall(2.0), wall(3.0, red)), (wall(3.0, red), wall(2.0))):
        raster = picture(*meshes)
        assert np.allclose(raster.inverse_depth, 0.5, atol=1e-6)
        assert (raster.colour[..., 1] > 0).all()


def test_a_floor_that_reaches_behind_the_camera_is_drawn_up_to_the_nearest_row() -> None:
    floor = Surface(
        np.array([[-50.0, -50.0, -1.0], [50.0, -50.0, -1.0], [0.0, 80.0, -1.0]]),
        np.tile([0.0, 0.0, 1.0], (3, 1)),
        np.zeros((3, 2)),
        np.array([[0, 1, 2]]),
    )
    raster = picture(Mesh(floor, WHITE))
    rows = np.arange(28, 48)
    assert np.allclose(raster.inverse_depth[28:, 32], (rows + 0.5 - 24.0) / 50.0, atol=1e-6)
    assert not raster.drawn[:24].any()


def test_nothing_nearer_than_the_limit_is_drawn() -> None:
    assert not picture(wall(0.9 * NEAR)).drawn.any()
    assert picture(wall(1.1 * NEAR)).drawn.all()


def test_a_face_is_seen_from_its_front_only() -> None:
    mesh = wall(2.0)
    surface = mesh.surface
    back = Surface(surface.vertices, surface.normals, surface.uvs, surface.triangles[:, ::-1].copy())
    assert not picture(Mesh(back, WHITE)).drawn.any()


def test_a_texture_is_upright_and_sampled_at_the_nearest_pixel() -> None:
    texture = np.zeros((2, 2, 3), np.uint8)
    texture[0, 0], texture[0, 1], texture[1, 0], texture[1, 1] = (250, 0, 0), (0, 250, 0), (0, 0, 250), (250, 250, 250)
    light = Light(ambient=1.0, diffuse=0.0)
    colour = picture(wall(10.0, texture, size=9.0), light=light).colour
    assert [colour[y, x].tolist() for y in (10, 40) for x in (20, 45)] == [*texture[0].tolist(), *texture[1].tolist()]


def test_light_is_ambient_plus_diffuse_by_the_cosine_and_saturates() -> None:
    grey = np.full((1, 1, 3), 100, np.uint8)
    slanted = Light(direction=(-1.0, 0.0, 1.0), colour=(1.0, 0.5, 5.0), ambient=0.5, diffuse=0.4)
    expected = [100 * (0.5 + 0.4 * 0.5**0.5 * part) for part in (1.0, 0.5, 5.0)]
    assert picture(wall(2.0, grey), light=slanted).colour[5, 5].tolist() == [int(value) for value in expected]
    behind = Light(direction=(1.0, 0.0, 0.0), ambient=0.5, diffuse=0.4)
    assert picture(wall(2.0, grey), light=behind).colour[5, 5].tolist() == [50, 50, 50]
    assert picture(wall(2.0), light=Light(direction=(-1.0, 0.0, 0.0), ambient=2.0)).colour.min() == 255


@given(st.integers(0, 2**32 - 1))
def test_triangles_that_share_their_edges_leave_no_gap_and_a_cut_leaves_no_trace(seed: int) -> None:
    generator = np.random.default_rng(seed)
    corners = np.array([[3.0, 2.5, 2.0], [3.0, -2.5, 2.0], [3.0, -2.5, -2.0], [3.0, 2.5, -2.0]])
    centre = np.array([[3.0, *generator.uniform(-1.5, 1.5, 2)]])
    vertices = np.concatenate([corners, centre])
    vertices[:, 0] += 0.4 * vertices[:, 1]  # slanted, so that depth varies
    fan = np.array([[k, 4, (k + 1) % 4] for k in range(4)])
    whole = np.array([[0, 3, 1], [1, 3, 2]])
    normals, uvs = np.tile([-1.0, 0.4, 0.0], (5, 1)), np.zeros((5, 2))
    cut, uncut = (picture(Mesh(Surface(vertices, normals, uvs, triangles), WHITE)) for triangles in (fan, whole))
    assert np.array_equal(cut.drawn, uncut.drawn)
    assert uncut.drawn.sum() > 1500
    assert np.allclose(cut.inverse_depth, uncut.inverse_depth, rtol=1e-6)


@pytest.mark.parametrize("direction", [(0.3, 0.2, 1.0), (-1.0, 0.0, 0.0)])
def test_a_round_surface_is_shaded_smoothly(direction: tuple[float, float, float]) -> None:
    corners = np.array([[2.0, 1.0, -1.0], [2.0, -1.0, -1.0], [2.0, 0.0, 1.5]])
    normals = np.array([[-1.0, 1.0, 0.0], [-1.0, -1.0, 0.0], [-1.0, 0.0, 1.0]])
    mesh = Mesh(Surface(corners, normals, np.zeros((3, 2)), np.array([[0, 1, 2]])), WHITE)
    colour = picture(mesh, light=Light(direction=direction)).colour[..., 0].astype(int)
    row = colour[30][colour[30] > 0]
    assert len(row) > 20
    assert np.abs(np.diff(row)).max() <= 6
    assert np.ptp(row) >= 10
