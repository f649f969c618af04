"""Make the robot: meshes of shell, wheels and head, and mbot.urdf.

The root is the floor point under the robot's centre, x forward. The centre of mass of the base is put there too: the
physics engine then reports and resets the very pose that the rest of the program speaks of.
"""

from __future__ import annotations

import argparse
from pathlib import Path

import numpy as np
from surfaces import Mesh, joined, lathe, rounded_box, write_obj

WHEEL_RADIUS = 0.075  # [m]
WHEEL_WIDTH = 0.055  # [m]
WHEELS = {  # place of the axle [m], handedness of the rollers
    "front_left": (0.165, 0.195, 1.0),
    "front_right": (0.165, -0.195, -1.0),
    "rear_left": (-0.165, 0.195, -1.0),
    "rear_right": (-0.165, -0.195, 1.0),
}
ROLLERS = 8
WHITE, GREY, DARK = "0.93 0.93 0.91 1", "0.55 0.57 0.60 1", "0.13 0.14 0.16 1"
ORANGE, CYAN, RUBBER = "0.95 0.48 0.12 1", "0.45 0.88 0.95 1", "0.20 0.20 0.21 1"


def wheel(hand: float) -> tuple[Mesh, Mesh]:
    """Return hub and rollers of a mecanum wheel that turns about y; the rollers lean by 45 degrees to one hand."""
    across = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, -1.0, 0.0]])  # z to y
    half = 0.5 * WHEEL_WIDTH
    hub = lathe([(0.0, -half), (0.052, -half), (0.052, half), (0.020, half), (0.0, half + 0.006)], 9)
    barrel = lathe([(0.0, -0.036), (0.011, -0.032), (0.017, 0.0), (0.011, 0.032), (0.0, 0.036)], 6)
    rollers = []
    for index in range(ROLLERS):
        lean, angle = 0.25 * np.pi * hand, 2.0 * np.pi * index / ROLLERS
        tilt = turn_z(lean) @ across
        rollers.append(barrel.moved((0.0, 0.0, WHEEL_RADIUS - 0.017), tilt).moved((0.0, 0.0, 0.0), turn_y(angle)))
    return hub.moved((0.0, 0.0, 0.0), across), joined(*rollers)


def turn_y(angle: float) -> np.ndarray:
    """Return the rotation about y."""
    c, s = np.cos(angle), np.sin(angle)
    return np.array([[c, 0.0, s], [0.0, 1.0, 0.0], [-s, 0.0, c]])


def turn_z(angle: float) -> np.ndarray:
    """Return the rotation about z."""
    c, s = np.cos(angle), np.sin(angle)
    return np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])


def to_x() -> np.ndarray:
    """Return the rotation that turns z to x."""
    return turn_y(0.5 * np.pi)


def eyes() -> Mesh:
    """Return two friendly discs on the face."""
    disc = lathe([(0.026, -0.002), (0.026, 0.004), (0.0, 0.006)], 10)
    return joined(*(disc.moved((0.118, side * 0.055, 0.115), to_x()) for side in (1.0, -1.0)))


def boom() -> Mesh:
    """Return the neck that holds the camera over the head: up behind it, then forward."""
    post = lathe([(0.014, 0.74), (0.014, 1.205)], 8).moved((-0.135, 0.0, 0.0))
    bar = lathe([(0.013, 0.0), (0.013, 0.335)], 8).moved((-0.14, 0.0, 1.2), to_x())
    elbow = rounded_box((0.04, 0.04, 0.04), 0.012, 1).moved((-0.135, 0.0, 1.2))
    return joined(post, bar, elbow)


def meshes() -> dict[str, Mesh]:
    """Return every mesh by name."""
    shell = [(0.20, 0.155), (0.275, 0.165), (0.292, 0.20), (0.285, 0.25), (0.25, 0.29), (0.17, 0.31)]
    column = [(0.165, 0.30), (0.155, 0.34), (0.175, 0.55), (0.172, 0.66), (0.15, 0.74), (0.10, 0.785), (0.0, 0.79)]
    left_hub, left_rollers = wheel(1.0)
    _, right_rollers = wheel(-1.0)
    return {
        "robot_chassis": rounded_box((0.40, 0.28, 0.12), 0.03, 1).moved((0.0, 0.0, 0.105)),
        "robot_shell": lathe(shell, 20),
        "robot_band": lathe([(0.287, 0.197), (0.297, 0.202), (0.295, 0.225), (0.286, 0.23)], 20),
        "robot_column": lathe(column, 18),
        "robot_stripe": lathe([(0.170, 0.585), (0.180, 0.59), (0.180, 0.61), (0.170, 0.615)], 18),
        "robot_panel": rounded_box((0.03, 0.16, 0.11), 0.012, 1).moved((0.163, 0.0, 0.50)),
        "robot_boom": boom(),
        "robot_neck": lathe([(0.055, 0.0), (0.05, 0.04)], 12),
        "robot_head": rounded_box((0.22, 0.28, 0.19), 0.07, 2).moved((0.0, 0.0, 0.12)),
        "robot_face": rounded_box((0.04, 0.23, 0.13), 0.018, 1).moved((0.098, 0.0, 0.12)),
        "robot_eyes": eyes(),
        "robot_camera": rounded_box((0.045, 0.09, 0.04), 0.01, 1).moved((-0.055, 0.0, 0.0)),
        "robot_lens": lathe([(0.014, -0.005), (0.014, 0.010), (0.0, 0.010)], 10).moved((-0.035, 0.0, 0.0), to_x()),
        "wheel_hub": left_hub,
        "wheel_rollers_left_handed": left_rollers,
        "wheel_rollers_right_handed": right_rollers,
    }


def visual(mesh: str, colour: str) -> str:
    """Return a visual with its colour."""
    return (
        f'    <visual><geometry><mesh filename="meshes/{mesh}.obj"/></geometry>'
        f'<material name="{mesh}_{colour.replace(" ", "_")}"><color rgba="{colour}"/></material></visual>\n'
    )


def inertial(mass: float, xx: float, yy: float, zz: float) -> str:
    """Return mass [kg] and inertia [kg m^2] about the link's own origin."""
    moments = f'ixx="{xx}" ixy="0" ixz="0" iyy="{yy}" iyz="0" izz="{zz}"'
    return f'    <inertial><mass value="{mass}"/><inertia {moments}/></inertial>\n'


def link(name: str, body: str) -> str:
    """Return a link."""
    return f'  <link name="{name}">\n{body}  </link>\n'


def joint(name: str, kind: str, child: str, at: tuple[float, float, float], axis: str | None = None) -> str:
    """Return a joint below the base."""
    turn = f'<axis xyz="{axis}"/>' if axis else ""
    place = " ".join(f"{value:g}" for value in at)
    return (
        f'  <joint name="{name}" type="{kind}"><parent link="base"/><child link="{child}"/>'
        f'<origin xyz="{place}"/>{turn}</joint>\n'
    )


def urdf() -> str:
    """Return mbot.urdf: 40 kg in all, one cylinder to collide with."""
    hull = '<origin xyz="0 0 0.51"/><geometry><cylinder radius="0.3" length="0.98"/></geometry>'
    base = inertial(34.0, 1.7, 1.7, 1.35) + f"    <collision>{hull}</collision>\n"
    for mesh, colour in (
        ("robot_chassis", DARK),
        ("robot_shell", WHITE),
        ("robot_band", ORANGE),
        ("robot_column", WHITE),
        ("robot_stripe", ORANGE),
        ("robot_panel", GREY),
        ("robot_boom", GREY),
    ):
        base += visual(mesh, colour)
    head = inertial(1.8, 0.015, 0.015, 0.015) + visual("robot_neck", DARK) + visual("robot_head", WHITE)
    head += visual("robot_face", DARK) + visual("robot_eyes", CYAN)
    text = link("base", base)
    text += link("head", head) + joint("head_pan", "continuous", "head", (0.0, 0.0, 0.78), "0 0 1")
    camera = inertial(0.2, 1e-3, 1e-3, 1e-3) + visual("robot_camera", DARK) + visual("robot_lens", CYAN)
    text += link("camera_mount", camera) + joint("camera_mount", "fixed", "camera_mount", (0.25, 0.0, 1.2))
    for name, (x, y, hand) in WHEELS.items():
        rollers = "wheel_rollers_left_handed" if hand > 0.0 else "wheel_rollers_right_handed"
        body = inertial(1.0, 2e-3, 3e-3, 2e-3) + visual("wheel_hub", GREY) + visual(rollers, RUBBER)
        text += link(f"wheel_{name}", body)
        text += joint(f"wheel_{name}", "continuous", f"wheel_{name}", (x, y, WHEEL_RADIUS), "0 1 0")
    made = "<!-- Made by make_robot.py: root on the floor under the centre, x forward, z up. -->"
    return f'<?xml version="1.0"?>\n{made}\n<robot name="mbot">\n{text}</robot>\n'


def main() -> None:
    """Write the meshes and the URDF."""
    parser = argparse.ArgumentParser(description="Make the meshes and the URDF of the robot.")
    parser.add_argument("--out", type=Path, default=Path(__file__).resolve().parent, help="folder to write to")
    out: Path = parser.parse_args().out
    (out / "meshes").mkdir(parents=True, exist_ok=True)
    counts = {name: write_obj(out / "meshes" / f"{name}.obj", mesh) for name, mesh in meshes().items()}
    (out / "mbot.urdf").write_text(urdf())
    total = sum(count * (4 if name == "wheel_hub" else 2 if "rollers" in name else 1) for name, count in counts.items())
    print(f"mbot: {total} triangles, {counts}")


if __name__ == "__main__":
    main()
