"""Make the couch: one upholstered mesh, its feet, and couch.urdf.

1.9 m along y, 0.8 m along x, facing +x; the seat is 0.42 m high, the back 0.8 m; the origin is the centre of the
footprint on the floor.
"""

from __future__ import annotations

import argparse
from pathlib import Path

from surfaces import Mesh, joined, lathe, rounded_box, write_obj

BOXES = (  # size and centre [m]; who sits at the origin has room for the hips behind and the calves in front
    ((0.56, 1.66, 0.20), (0.02, 0.0, 0.18)),  # frame
    ((0.52, 0.80, 0.15), (0.06, 0.405, 0.345)),  # seat cushions
    ((0.52, 0.80, 0.15), (0.06, -0.405, 0.345)),
    ((0.18, 1.90, 0.72), (-0.31, 0.0, 0.44)),  # back
    ((0.13, 0.78, 0.34), (-0.195, 0.395, 0.57)),  # back cushions
    ((0.13, 0.78, 0.34), (-0.195, -0.395, 0.57)),
    ((0.78, 0.16, 0.50), (0.0, 0.87, 0.33)),  # arms
    ((0.78, 0.16, 0.50), (0.0, -0.87, 0.33)),
)


def upholstery() -> Mesh:
    """Return everything that is covered with fabric."""
    return joined(*(rounded_box(size, min(0.05, 0.3 * min(size)), 1).moved(centre) for size, centre in BOXES))


def feet() -> Mesh:
    """Return four wooden feet."""
    foot = lathe([(0.02, 0.0), (0.03, 0.1)], 8)
    return joined(*(foot.moved((x, y, 0.0)) for x in (-0.3, 0.32) for y in (-0.85, 0.85)))


def urdf() -> str:
    """Return couch.urdf; collisions are the seat and the back."""
    shapes = "".join(
        f'    <collision><origin xyz="{x} {y} {z}"/><geometry><box size="{a} {b} {c}"/></geometry></collision>\n'
        for (a, b, c), (x, y, z) in (((0.8, 1.9, 0.42), (0.0, 0.0, 0.21)), ((0.2, 1.9, 0.8), (-0.3, 0.0, 0.4)))
    )
    visuals = "".join(
        f'    <visual><geometry><mesh filename="meshes/{mesh}.obj"/></geometry>'
        f'<material name="{mesh}"><color rgba="{colour}"/></material></visual>\n'
        for mesh, colour in (("couch_cloth", "0.66 0.60 0.52 1"), ("couch_feet", "0.35 0.22 0.13 1"))
    )
    inertial = '    <inertial><mass value="0"/><inertia ixx="0" ixy="0" ixz="0" iyy="0" iyz="0" izz="0"/></inertial>\n'
    made = "<!-- Made by make_couch.py: origin at the centre of the footprint on the floor, facing +x. -->"
    body = f'  <link name="couch">\n{inertial}{visuals}{shapes}  </link>\n'
    return f'<?xml version="1.0"?>\n{made}\n<robot name="couch">\n{body}</robot>\n'


def main() -> None:
    """Write the meshes and the URDF."""
    parser = argparse.ArgumentParser(description="Make the meshes and the URDF of the couch.")
    parser.add_argument("--out", type=Path, default=Path(__file__).resolve().parent, help="folder to write to")
    out: Path = parser.parse_args().out
    (out / "meshes").mkdir(parents=True, exist_ok=True)
    cloth = write_obj(out / "meshes" / "couch_cloth.obj", upholstery(), picture="../textures/fabric.png")
    wood = write_obj(out / "meshes" / "couch_feet.obj", feet())
    (out / "couch.urdf").write_text(urdf())
    print(f"couch: {cloth + wood} triangles")


if __name__ == "__main__":
    main()
