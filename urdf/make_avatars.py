"""Make the people: smooth bodies from signed distance fields, one mesh per link, and their URDFs.

Each part is a smooth union of a few ellipsoids and tapered capsules; marching cubes finds its surface on a coarse grid,
the vertices are then moved onto the exact surface and get its gradient as normals, so a few thousand triangles look
smooth. Needs scikit-image (extra "dev"); the output is committed, so only those who change the people run this.
"""

from __future__ import annotations

import argparse
from collections.abc import Callable
from pathlib import Path

import numpy as np
from surfaces import Array, Field, Mesh, Part, capsule, cut, ellipsoid, joined, lathe, mesh_of, union, write_obj

from han_bullet.sim.skeleton import Skeleton, skeleton_of

GIRTHS = {"slim": 1.0, "broad": 1.12}


def trunk(s: Skeleton, g: float) -> Part:
    """Return the shirt, from the waist joint; it hangs over the belt."""
    w, top = s.shoulder, s.shoulder_height
    field = union(
        ellipsoid((0.006, 0.0, 0.55 * top), (0.127 * g, w - 0.010, 0.78 * top)),
        ellipsoid((0.006, 0.0, -0.03), (0.131 * g, 0.158 * g, 0.19)),
        capsule((-0.012, w - 0.01, top - 0.012), (-0.012, 0.04, top + 0.035), 0.054 * g, 0.062 * g),
        capsule((-0.012, 0.01 - w, top - 0.012), (-0.012, -0.04, top + 0.035), 0.054 * g, 0.062 * g),
        capsule((-0.02, 0.0, top + 0.02), (-0.008, 0.0, s.neck - 0.025), 0.07 * g, 0.057 * g),
        blend=0.05,
    )
    hem = cut(field, lambda points: -0.135 - points[:, 2])
    return Part(hem, (-0.2, -0.3, -0.2), (0.2, 0.3, 0.5), (0.049, 0.052, 0.056))


def pelvis(s: Skeleton, g: float) -> Part:
    """Return the hips, from the middle between the hip joints."""
    field = union(
        ellipsoid((-0.010, 0.0, 0.03), (0.117 * g, 0.152 * g, 0.13)),
        ellipsoid((-0.014, s.hip, -0.02), (0.105 * g, 0.083 * g, 0.09)),
        ellipsoid((-0.014, -s.hip, -0.02), (0.105 * g, 0.083 * g, 0.09)),
        blend=0.05,
    )
    return Part(field, (-0.2, -0.25, -0.18), (0.2, 0.25, 0.2), (0.055, 0.06, 0.056))


def cranium(grow: float) -> Field:
    """Return the upper head, grown by some metres."""
    return ellipsoid((0.005, 0.0, 0.125), (0.098 + grow, 0.078 + grow, 0.102 + grow))


def head(_s: Skeleton, g: float) -> Part:
    """Return head and neck, from the neck joint."""
    field = union(
        cranium(0.0),
        ellipsoid((0.028, 0.0, 0.065), (0.064, 0.056, 0.066)),
        capsule((-0.012, 0.0, -0.09), (-0.005, 0.0, 0.06), 0.053 * g, 0.050 * g),
        capsule((0.096, 0.0, 0.115), (0.108, 0.0, 0.082), 0.010, 0.015),
        ellipsoid((0.0, 0.078, 0.095), (0.020, 0.012, 0.030)),
        ellipsoid((0.0, -0.078, 0.095), (0.020, 0.012, 0.030)),
        blend=0.025,
    )
    return Part(field, (-0.15, -0.14, -0.16), (0.15, 0.14, 0.26), (0.030, 0.030, 0.034))


def hair(_s: Skeleton, _g: float) -> Part:
    """Return the hair: a shell over the back and top of the head."""
    field = cut(cranium(0.014), lambda points: 0.140 + 0.80 * points[:, 0] - points[:, 2])
    return Part(field, (-0.15, -0.14, 0.0), (0.15, 0.14, 0.26), (0.034, 0.034, 0.034))


def eyes() -> Mesh:
    """Return two dark spots, by which one sees where a person looks."""
    spot = lathe([(0.008, -0.004), (0.007, 0.001), (0.0, 0.002)], 6)
    to_x = np.array([[0.0, 0.0, 1.0], [0.0, 1.0, 0.0], [-1.0, 0.0, 0.0]])
    return joined(*(spot.moved((0.097, side * 0.031, 0.122), to_x) for side in (1.0, -1.0)))


def upper_arm(s: Skeleton, g: float) -> Part:
    """Return the upper arm in its sleeve, from the shoulder."""
    field = union(
        ellipsoid((0.0, 0.0, -0.045), (0.057 * g, 0.053 * g, 0.085)),
        capsule((0.0, 0.0, -0.01), (0.0, 0.0, -s.upper_arm - 0.02), 0.050 * g, 0.052 * g),
    )
    sleeve = cut(field, lambda points: -s.upper_arm + 0.01 - points[:, 2])
    return Part(sleeve, (-0.1, -0.1, -0.4), (0.1, 0.1, 0.1), (0.034, 0.034, 0.070))


def forearm(s: Skeleton, g: float) -> Part:
    """Return the forearm, from the elbow."""
    field = union(
        capsule((0.0, 0.0, 0.0), (0.0, 0.0, -s.forearm), 0.043 * g, 0.033 * g),
        ellipsoid((0.004, 0.0, -0.07), (0.047 * g, 0.044 * g, 0.09)),
    )
    return Part(field, (-0.08, -0.08, -0.34), (0.08, 0.08, 0.08), (0.032, 0.032, 0.06))


def hand(_s: Skeleton, g: float) -> Part:
    """Return the hand, from the wrist; the fingers are half closed."""
    field = union(
        ellipsoid((0.0, 0.0, -0.06), (0.040 * g, 0.024 * g, 0.062)),
        capsule((0.008, 0.0, -0.09), (0.022, 0.0, -0.145), 0.027, 0.020),
        capsule((0.03, 0.0, -0.05), (0.05, 0.0, -0.09), 0.015, 0.012),
        blend=0.03,
    )
    return Part(field, (-0.07, -0.06, -0.2), (0.09, 0.06, 0.04), (0.030, 0.027, 0.038))


def thigh(s: Skeleton, g: float) -> Part:
    """Return the upper leg, from the hip."""
    field = union(
        capsule((0.0, 0.0, -0.02), (0.0, 0.0, -s.thigh - 0.02), 0.088 * g, 0.069 * g),
        ellipsoid((0.006, 0.0, -0.16), (0.091 * g, 0.08 * g, 0.2)),
        blend=0.03,
    )
    leg = cut(field, lambda points: -s.thigh + 0.004 - points[:, 2])
    return Part(leg, (-0.15, -0.15, -0.55), (0.15, 0.15, 0.15), (0.046, 0.046, 0.082))


def shin(s: Skeleton, g: float) -> Part:
    """Return the lower leg, from the knee; the trousers end over the shoe."""
    field = union(
        capsule((0.0, 0.0, 0.0), (0.0, 0.0, -s.shin), 0.065 * g, 0.058 * g),
        ellipsoid((-0.016, 0.0, -0.13), (0.066 * g, 0.060 * g, 0.15)),
        blend=0.03,
    )
    leg = cut(field, lambda points: -s.shin - 0.012 - points[:, 2])
    return Part(leg, (-0.12, -0.12, -0.53), (0.12, 0.12, 0.12), (0.037, 0.037, 0.08))


def shoe(s: Skeleton, g: float) -> Part:
    """Return the shoe, from the ankle; its tip rises a little so that the foot can roll off."""
    floor = -s.ankle
    body = union(
        capsule((s.heel + 0.043, 0.0, floor + 0.035), (s.toe - 0.042, 0.0, floor + 0.02), 0.043 * g, 0.042 * g),
        capsule((0.0, 0.0, 0.0), (0.05, 0.0, floor + 0.045), 0.044 * g, 0.043 * g),
        blend=0.03,
    )

    def above_sole(points: Array) -> Array:
        beyond = np.clip((points[:, 0] - s.ball) / (s.toe - s.ball), 0.0, 2.0)
        return floor + s.toe_spring * beyond**2 - points[:, 2]

    return Part(cut(body, above_sole), (-0.13, -0.09, -0.13), (0.25, 0.09, 0.09), (0.040, 0.030, 0.030))


def coat(_s: Skeleton, g: float) -> Part:
    """Return the skirts of a coat, over hips and thighs, from the pelvis."""
    cone = capsule((0.0, 0.0, 0.12), (0.0, 0.0, -0.30), 0.145, 0.205)
    oval = lambda points: cone(points * (1.0 / g, 0.82 / g, 1.0))  # noqa: E731
    skirts = cut(oval, lambda points: -0.27 - points[:, 2])
    return Part(skirts, (-0.28, -0.33, -0.34), (0.28, 0.33, 0.3), (0.086, 0.086, 0.09))


def bag(_s: Skeleton, g: float) -> Part:
    """Return a rucksack, from the waist joint."""
    field = union(
        ellipsoid((-0.16 * g, 0.0, 0.16), (0.085, 0.14, 0.19)),
        ellipsoid((-0.15 * g, 0.0, 0.08), (0.095, 0.145, 0.12)),
        blend=0.05,
    )
    return Part(field, (-0.32, -0.2, -0.1), (0.0, 0.2, 0.42), (0.065, 0.065, 0.07))


PARTS: dict[str, Callable[[Skeleton, float], Part]] = {
    "pelvis": pelvis,
    "trunk": trunk,
    "head": head,
    "hair": hair,
    "upper_arm": upper_arm,
    "forearm": forearm,
    "hand": hand,
    "thigh": thigh,
    "shin": shin,
    "shoe": shoe,
    "coat": coat,
    "bag": bag,
}


def link(name: str, mesh: str | None) -> str:
    """Return a link without mass; render clients are never stepped."""
    inertial = '<inertial><mass value="0"/><inertia ixx="0" ixy="0" ixz="0" iyy="0" iyz="0" izz="0"/></inertial>'
    visual = f'<visual><geometry><mesh filename="meshes/{mesh}.obj"/></geometry></visual>' if mesh else ""
    return f'  <link name="{name}">{inertial}{visual}</link>\n'


def joint(name: str, parent: str, at: tuple[float, float, float], axis: str | None, mesh: str | None) -> str:
    """Return a joint and the link below it, both of the same name; no axis means fixed."""
    kind, turn = ("fixed", "") if axis is None else ("revolute", f'<axis xyz="{axis}"/>')
    limit = "" if axis is None else '<limit lower="-3.1" upper="3.1" effort="0" velocity="0"/>'
    origin = " ".join(f"{value:.4f}" for value in at)
    return link(name, mesh) + (
        f'  <joint name="{name}" type="{kind}"><parent link="{parent}"/><child link="{name}"/>'
        f'<origin xyz="{origin}"/>{turn}{limit}</joint>\n'
    )


def urdf(build: str, s: Skeleton) -> str:
    """Return the URDF of a build; its root sits midway between the hip joints."""
    x, y, z, here = "1 0 0", "0 1 0", "0 0 1", (0.0, 0.0, 0.0)
    mesh = {name: f"{build}_{name}" for name in PARTS}
    text = link("base", mesh["pelvis"])
    text += joint("coat", "base", here, None, mesh["coat"])
    text += joint("waist_yaw", "base", (0.0, 0.0, s.waist), z, None)
    text += joint("waist_pitch", "waist_yaw", here, y, mesh["trunk"])
    text += joint("bag", "waist_pitch", here, None, mesh["bag"])
    text += joint("neck_yaw", "waist_pitch", (0.0, 0.0, s.neck), z, None)
    text += joint("neck_pitch", "neck_yaw", here, y, mesh["head"])
    text += joint("hair", "neck_pitch", here, None, mesh["hair"])
    text += joint("eyes", "neck_pitch", here, None, "eyes")
    for side, sign in (("left", 1.0), ("right", -1.0)):
        text += joint(f"hip_yaw_{side}", "base", (0.0, sign * s.hip, 0.0), z, None)
        text += joint(f"hip_roll_{side}", f"hip_yaw_{side}", here, x, None)
        text += joint(f"hip_pitch_{side}", f"hip_roll_{side}", here, y, mesh["thigh"])
        text += joint(f"knee_{side}", f"hip_pitch_{side}", (0.0, 0.0, -s.thigh), y, mesh["shin"])
        text += joint(f"ankle_pitch_{side}", f"knee_{side}", (0.0, 0.0, -s.shin), y, None)
        text += joint(f"ankle_roll_{side}", f"ankle_pitch_{side}", here, x, mesh["shoe"])
        shoulder = (0.0, sign * s.shoulder, s.shoulder_height)
        text += joint(f"shoulder_pitch_{side}", "waist_pitch", shoulder, y, None)
        text += joint(f"shoulder_roll_{side}", f"shoulder_pitch_{side}", here, x, mesh["upper_arm"])
        text += joint(f"elbow_{side}", f"shoulder_roll_{side}", (0.0, 0.0, -s.upper_arm), y, mesh["forearm"])
        text += joint(f"hand_{side}", f"elbow_{side}", (0.0, 0.0, -s.forearm - 0.005), None, mesh["hand"])
    made = "<!-- Made by make_avatars.py: root midway between the hip joints, x forward, z up. -->"
    return f'<?xml version="1.0"?>\n{made}\n<robot name="avatar_{build}">\n{text}</robot>\n'


def main() -> None:
    """Write the meshes and URDFs."""
    parser = argparse.ArgumentParser(description="Make the meshes and URDFs of the people.")
    parser.add_argument("--out", type=Path, default=Path(__file__).resolve().parent, help="folder to write to")
    out: Path = parser.parse_args().out
    (out / "meshes").mkdir(parents=True, exist_ok=True)
    spots = write_obj(out / "meshes" / "eyes.obj", eyes())
    for build, girth in GIRTHS.items():
        skeleton = skeleton_of(build)
        counts = {
            name: write_obj(out / "meshes" / f"{build}_{name}.obj", mesh_of(make(skeleton, girth)))
            for name, make in PARTS.items()
        }
        (out / f"avatar_{build}.urdf").write_text(urdf(build, skeleton))
        paired = ("upper_arm", "forearm", "hand", "thigh", "shin", "shoe")
        total = spots + sum(count * (2 if name in paired else 1) for name, count in counts.items())
        print(f"{build}: {total} triangles, {counts}")


if __name__ == "__main__":
    main()
