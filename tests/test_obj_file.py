from pathlib import Path

import numpy as np
import pytest

from han_bullet import assets
from han_bullet.errors import BadInputError
from han_bullet.sim.obj_file import read_obj


def written(folder: Path, text: str) -> Path:
    path = folder / "mesh.obj"
    path.write_text(text)
    return path


def test_a_polygon_becomes_a_fan_and_a_face_without_normals_gets_its_own(tmp_path: Path) -> None:
    surface, texture = read_obj(written(tmp_path, "v 0 0 0\nv 2 0 0\nv 2 1 0\nv 0 1 0\n# a square\nf 1 2 3 4\n"))
    assert texture is None
    corners = surface.vertices[surface.triangles]
    areas = 0.5 * np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])[:, 2]
    assert areas.tolist() == [1.0, 1.0]
    normals = surface.normals / np.linalg.norm(surface.normals, axis=1, keepdims=True)
    assert normals.tolist() == [[0.0, 0.0, 1.0]] * len(surface.vertices)
    assert not surface.uvs.any()


def test_corners_are_read_in_all_their_forms_and_numbers_from_the_end(tmp_path: Path) -> None:
    text = "v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0.25 0.75\nvn 0 0 -1\nf 1/1/1 2//1 -1/-1/-1\n"
    surface, _ = read_obj(written(tmp_path, text))
    rows = surface.triangles[0]
    assert surface.vertices[rows].tolist() == [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]
    assert surface.uvs[rows].tolist() == [[0.25, 0.75], [0.0, 0.0], [0.25, 0.75]]
    assert surface.normals[rows].tolist() == [[0.0, 0.0, -1.0]] * 3


def test_corners_that_are_the_same_are_kept_once() -> None:
    surface, _ = read_obj(assets.urdf_folder() / "meshes" / "slim_head.obj")
    assert len(surface.triangles) == 446
    assert len(surface.vertices) == 225


def test_the_picture_of_the_material_file_is_found() -> None:
    _, texture = read_obj(assets.urdf_folder() / "meshes" / "couch_cloth.obj")
    assert texture is not None
    assert texture.resolve() == (assets.urdf_folder() / "textures" / "fabric.png").resolve()


def test_numbers_from_the_end_are_those_of_the_rows_so_far(tmp_path: Path) -> None:
    triangle = "v 0 0 {z}\nv 1 0 {z}\nv 0 1 {z}\nf -3 -2 -1\n"
    surface, _ = read_obj(written(tmp_path, triangle.format(z=0) + triangle.format(z=5)))
    assert surface.vertices[surface.triangles][:, :, 2].tolist() == [[0.0] * 3, [5.0] * 3]


def test_a_normal_without_length_is_none(tmp_path: Path) -> None:
    surface, _ = read_obj(written(tmp_path, "v 0 0 0\nv 1 0 0\nv 0 1 0\nvn 0 0 0\nf 1//1 2//1 3//1\nf 1 1 2\n"))
    assert np.linalg.norm(surface.normals, axis=1).min() > 0.0


@pytest.mark.parametrize(
    "text", ["", "v 0 0 0\nv 1 0 0\nf 1 2\n", "v 0 0 0\nf 1 2 3\n", "v 0 0\nf 1 1 1\n", "v a b c\n", "solid stl\n"]
)
def test_what_is_no_mesh_is_named(tmp_path: Path, text: str) -> None:
    with pytest.raises(BadInputError, match=r"mesh\.obj is no OBJ file"):
        read_obj(written(tmp_path, text))


def test_a_missing_file_is_named(tmp_path: Path) -> None:
    with pytest.raises(BadInputError, match=r"gone\.obj"):
        read_obj(tmp_path / "gone.obj")
