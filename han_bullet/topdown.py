"""The map picture: what is true and what the robot believes, seen from above.

Blue is the robot and its ways, green what it believes of people, white with a dark rim the true people, red what the
laser meets; the floor carries the costmap, and the building lies on it as a drawing.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Sequence

import cv2
import numpy as np

from han_bullet import drawing
from han_bullet.costmap.grid import FREE, INSCRIBED, SOCIAL_MAX, UNKNOWN, Costmap
from han_bullet.episode import Tick
from han_bullet.geometry import Array, Pose2D, SolidBox
from han_bullet.lettering import Anchor, Colour, Lettering, Picture
from han_bullet.messages import GoTo, LaserScan, Posture, Task, TrackedPerson, TruePerson
from han_bullet.metrics.tally import PERSON_RADIUS
from han_bullet.world_schema import CeilingCamera, World

OUTSIDE: Colour = (226, 230, 235)
FLOOR: Colour = (253, 253, 251)
INFLATION: Colour = (222, 226, 232)  # faint: walls need no warning colour
WALL: Colour = (58, 66, 80)
FURNITURE: Colour = (196, 184, 166)
FURNITURE_RIM: Colour = (128, 115, 98)
SCREEN_ON: Colour = (64, 176, 255)
INK: Colour = (32, 38, 48)
PALE: Colour = (255, 255, 255)
CAMERA: Colour = (104, 112, 128)
ROBOT: Colour = (29, 92, 214)
PATH: Colour = (60, 130, 250)
TRAJECTORY: Colour = (16, 44, 104)
TRACK: Colour = (0, 122, 78)
GOAL: Colour = (200, 30, 60)
LASER: Colour = (236, 62, 30)

SOCIAL_RANGE = (0.93, 0.36)  # of the colour map, from cost 0 to 252: bright to dark, no black, since it is drawn upon
SOCIAL_OPACITY = (0.0, 0.85)  # over the floor, at cost 0 and 252
MARGIN = 0.15  # [m] around the building
CAMERA_WEDGE = 0.45  # [m]
NEW_POINT_AFTER = 2.0  # [px]: a trajectory needs no finer points
SCAN_SHOWN_FOR = 0.15  # [s]
LABEL_SIZE, SMALL_SIZE = 15, 13  # [px]


def cost_colours() -> Picture:
    """Return what costs look like, RGB, shape (512, 3): 256 costs of the building, then 256 of people and devices."""
    share = np.clip(np.arange(256.0) / SOCIAL_MAX, 0.0, 1.0)
    ramp = np.rint(255.0 * np.interp(share, (0.0, 1.0), SOCIAL_RANGE)).astype(np.uint8)
    colours = np.asarray(cv2.applyColorMap(ramp, cv2.COLORMAP_INFERNO), float)[:, 0, ::-1]
    opacity = np.interp(share, (0.0, 1.0), SOCIAL_OPACITY)[:, None]
    social = (1.0 - opacity) * np.array(FLOOR) + opacity * colours
    building = (1.0 - share[:, None]) * np.array(FLOOR) + share[:, None] * np.array(INFLATION)
    building[FREE], building[INSCRIBED:UNKNOWN] = FLOOR, INFLATION
    building[UNKNOWN] = social[UNKNOWN] = OUTSIDE
    colours_of_costs: Picture = np.rint(np.concatenate([building, social])).astype(np.uint8)
    return colours_of_costs


class TopDownView:
    """Draw ticks onto a map of the world that fills a picture as far as its shape allows.

    Args:
        world: Building and cameras.
        size: Width and height of the picture [px].
        lettering: For names and labels.
    """

    def __init__(self, world: World, size: tuple[int, int], lettering: Lettering) -> None:
        self._world = world
        self._size = size
        self._lettering = lettering
        self._boxes = {box.name: box for box in world.all_boxes()}
        low, high = extent(world)
        self.scale = float(np.min(np.array(size) / (high - low)))  # [px/m]
        self._centre = 0.5 * (low + high)
        self._colours = cost_colours()
        self._ground = np.full((size[1], size[0], 3), OUTSIDE, np.uint8)
        self._trajectory: list[Array] = []
        self._scan: LaserScan | None = None

    def pixels(self, points_in_world: Array) -> Array:
        """Return columns and rows, shape (..., 2) [px], of points, shape (..., 2) [m]; y points up in the picture."""
        offset = (np.asarray(points_in_world, float) - self._centre) * self.scale * [1.0, -1.0]
        places: Array = offset + 0.5 * np.array(self._size)
        return places

    def draw(self, picture: Picture, tick: Tick, measurements: Sequence[Array] = ()) -> None:
        """Paint a tick over a picture of this view's size.

        Args:
            picture: RGB, shape (height, width, 3); changed.
            tick: The moment.
            measurements: Foot points that came in since the last picture, each (n, 2) [m].
        """
        self._draw_costs(picture, tick.decision.costmap)
        self._draw_building(picture, dict(tick.truth.devices_on), tick.truth.taken_away)
        self._draw_goal(picture, tick.decision.scene.task)
        self._draw_ways(picture, tick)
        for person in tick.truth.people:
            self._draw_person(picture, person)
        for point in (point for points in measurements for point in points):
            drawing.disc(picture, self.pixels(point), 3.5, TRACK)
        for track in tick.decision.people:
            self._draw_track(picture, track)
        self._draw_scan(picture, tick)
        self._draw_robot(picture, tick.truth.pose_robot_in_world)
        self._write_names(picture, tick)

    def _draw_costs(self, picture: Picture, costmap: Costmap) -> None:
        """Paint the costmap in colours, smooth between cells, and nothing around it."""
        social = costmap.cost > costmap.building
        cells = np.take(self._colours, costmap.cost + np.uint16(256) * social, axis=0)
        extent = np.array(costmap.cost.shape[::-1]) * costmap.resolution
        ends = self.pixels(costmap.origin_in_world + np.outer([0.0, 1.0], extent))
        left, bottom, right, top = np.rint(ends).astype(int).ravel()
        np.copyto(picture, self._ground)
        picture[top:bottom, left:right] = cv2.resize(cells[::-1], (right - left, bottom - top))

    def _draw_building(self, picture: Picture, devices_on: dict[str, bool], taken_away: Collection[str]) -> None:
        for name, box in self._boxes.items():
            if name in taken_away:
                continue
            if box.kind == "wall":
                drawing.polygon(picture, self.pixels(footprint(box)), WALL)
            elif name in devices_on:
                drawing.polygon(picture, self.pixels(footprint(box)), SCREEN_ON if devices_on[name] else INK, rim=INK)
            else:
                drawing.polygon(picture, self.pixels(footprint(box)), FURNITURE, rim=FURNITURE_RIM)
        for camera in self._world.cameras:
            if isinstance(camera, CeilingCamera):
                self._draw_camera(picture, camera)

    def _draw_camera(self, picture: Picture, camera: CeilingCamera) -> None:
        """Draw a ceiling camera as a wedge as wide as its horizontal field of view, its name at the wedge's side."""
        wedge = self.pixels(camera_wedge(camera, CAMERA_WEDGE))
        drawing.line(picture, wedge, CAMERA, 1, closed=True)
        drawing.disc(picture, wedge[0], 5.0, CAMERA)
        middle, (right, low) = wedge.mean(axis=0), wedge.max(axis=0)
        along_corridor = abs(camera.look_at[0] - camera.position[0]) > abs(camera.look_at[1] - camera.position[1])
        spot = (middle[0], low + 12.0) if along_corridor else (right + 8.0, middle[1])
        anchor: Anchor = "centre" if along_corridor else "left"
        self._lettering.write(picture, camera.name, spot, SMALL_SIZE, CAMERA, anchor=anchor, halo=PALE)

    def _draw_goal(self, picture: Picture, task: Task | None) -> None:
        """Draw a ring as large as the robot, with a nose where the task asks for a direction."""
        if task is None:
            return
        radius = self._world.robot.radius
        place = task.pose_in_world.position if isinstance(task, GoTo) else task.place_in_world
        if isinstance(task, GoTo):
            self._nose(picture, task.pose_in_world, (radius, radius + 0.12), GOAL, 3)
        drawing.disc(picture, self.pixels(place), radius * self.scale, PALE, GOAL)
        drawing.disc(picture, self.pixels(place), 4.0, GOAL)

    def _draw_ways(self, picture: Picture, tick: Tick) -> None:
        """Draw the driven trajectory and the planned path."""
        place = self.pixels(tick.truth.pose_robot_in_world.position)
        if not self._trajectory or np.abs(place - self._trajectory[-1]).max() > NEW_POINT_AFTER:
            self._trajectory.append(place)
        drawing.line(picture, np.array([*self._trajectory, place]), TRAJECTORY, 3)
        path = tick.decision.path
        if path is not None:
            drawing.line(picture, self.pixels(path.points_in_world), PATH, 3)

    def _draw_person(self, picture: Picture, person: TruePerson) -> None:
        """Draw a true body: a disc with a nose."""
        pose = person.pose_in_world
        self._nose(picture, pose, (PERSON_RADIUS, PERSON_RADIUS + 0.12), INK, 3)
        drawing.disc(picture, self.pixels(pose.position), PERSON_RADIUS * self.scale, PALE, INK)

    def _draw_track(self, picture: Picture, track: TrackedPerson) -> None:
        """Draw the centre, the 1-sigma ellipse and, while walking, an arrow to the place in one second."""
        variances, axes = np.linalg.eigh(track.covariance[:2, :2])
        turns = np.linspace(0.0, 2.0 * math.pi, 32, endpoint=False)
        circle = np.column_stack([np.cos(turns), np.sin(turns)]) * np.sqrt(np.maximum(variances, 0.0))
        drawing.line(picture, self.pixels(track.position_in_world + circle @ axes.T), TRACK, 2, closed=True)
        drawing.disc(picture, self.pixels(track.position_in_world), 4.0, TRACK)
        if track.posture is Posture.WALKING:
            start, end = self.pixels(track.position_in_world + np.outer([0.0, 1.0], track.velocity_in_world))
            drawing.arrow(picture, start, end, TRACK, 3)

    def _draw_scan(self, picture: Picture, tick: Tick) -> None:
        """Dot where the beams of the last scan ended, seen from where the robot believes to be."""
        self._scan = tick.observation.laser or self._scan
        if self._scan is None or self._scan.time < tick.decision.time - SCAN_SHOWN_FOR:
            return
        points = tick.decision.estimate.pose_robot_in_world.to_world(self._scan.points_in_body)
        columns, rows = np.rint(self.pixels(points)).astype(int).T
        inside = (columns >= 1) & (columns < self._size[0]) & (rows >= 1) & (rows < self._size[1])
        for right, down in np.ndindex(2, 2):  # squares: 541 round dots would cost as much as all else
            picture[rows[inside] - down, columns[inside] - right] = LASER

    def _draw_robot(self, picture: Picture, pose: Pose2D) -> None:
        radius = self._world.robot.radius
        drawing.disc(picture, self.pixels(pose.position), radius * self.scale, ROBOT, PALE)
        self._nose(picture, pose, (0.3 * radius, 0.75 * radius), PALE, 5)

    def _nose(
        self, picture: Picture, pose: Pose2D, from_to: tuple[float, float], colour: Colour, thickness: int
    ) -> None:
        """Draw a stroke straight ahead of a pose, between two distances [m]."""
        ends = pose.to_world(np.array([[distance, 0.0] for distance in from_to]))
        drawing.line(picture, self.pixels(ends), colour, thickness)

    def _write_names(self, picture: Picture, tick: Tick) -> None:
        """Write names last, above people and below tracks, so that nothing lies over them."""
        for name, on in tick.truth.devices_on:
            corner = footprint(self._boxes[name]).min(axis=0)
            self._label(picture, f"{name} {'on' if on else 'off'}", corner, (-8.0, -12.0), INK, anchor="right")
        below = PERSON_RADIUS * self.scale + 16.0
        for person in tick.truth.people:
            self._label(picture, person.name, person.pose_in_world.position, (0.0, -below), INK, anchor="centre")
        for track in tick.decision.people:
            self._label(picture, _track_label(track), track.position_in_world, (0.0, below), TRACK, anchor="centre")

    def _label(
        self,
        picture: Picture,
        text: str,
        point_in_world: Array,
        offset: tuple[float, float],
        colour: Colour,
        size: int = LABEL_SIZE,
        anchor: Anchor = "left",
    ) -> None:
        """Write at an offset (right, down) [px] from a point, (2,) [m]."""
        place = self.pixels(point_in_world) + np.array(offset)
        self._lettering.write(picture, text, place, size, colour, anchor=anchor, halo=PALE)


def _track_label(track: TrackedPerson) -> str:
    """Return id and posture, of walkers also the speed."""
    speed = f" {track.speed:.2f} m/s" if track.posture is Posture.WALKING else ""
    return f"#{track.id} {track.posture.value}{speed}"


def footprint(box: SolidBox) -> Array:
    """Return the corners of a box on the floor, shape (4, 2) [m]."""
    corners = 0.5 * box.size[:2] * np.array([[1.0, 1.0], [-1.0, 1.0], [-1.0, -1.0], [1.0, -1.0]])
    return Pose2D(box.centre_in_world[0], box.centre_in_world[1], box.yaw).to_world(corners)


def plan_colours(box: SolidBox, world: World) -> tuple[Colour, Colour]:
    """Return the colours of a box and of its rim in a plan, where devices are as dark as walls."""
    is_dark = box.kind == "wall" or box.name in {device.name for device in world.devices}
    return (WALL, WALL) if is_dark else (FURNITURE, FURNITURE_RIM)


def camera_wedge(camera: CeilingCamera, length: float) -> Array:
    """Return the camera's place and the ends, so far ahead [m], of its horizontal field of view, shape (3, 2) [m]."""
    (x, y), target = camera.position[:2], camera.look_at
    half = 0.5 * camera.intrinsics.width / camera.intrinsics.fx
    view = Pose2D(x, y, math.atan2(target[1] - y, target[0] - x))
    return view.to_world(length * np.array([[0.0, 0.0], [1.0, -half], [1.0, half]]))


def extent(world: World) -> tuple[Array, Array]:
    """Return the lower left and upper right corners of the building with a margin, each shape (2,) [m]."""
    floors = [corner for area in world.floor for corner in np.transpose([area.x, area.y])]
    corners = np.array([*floors, *(corner for box in world.all_boxes() for corner in footprint(box))])
    return corners.min(axis=0) - MARGIN, corners.max(axis=0) + MARGIN
