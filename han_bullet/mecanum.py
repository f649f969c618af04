"""Four mecanum wheels: how fast they turn for a twist, and what twist they make."""

from __future__ import annotations

from dataclasses import dataclass

from han_bullet.geometry import Twist2D

WHEELS = ("wheel_front_left", "wheel_front_right", "wheel_rear_left", "wheel_rear_right")


@dataclass(frozen=True)
class MecanumWheels:
    """Four mecanum wheels in a rectangle, rollers at 45 degrees.

    Attributes:
        radius: [m].
        half_length: From the robot's centre forward to the front axles [m].
        half_width: From the robot's centre sideways to the wheels [m].
    """

    radius: float
    half_length: float
    half_width: float

    def speeds(self, twist: Twist2D) -> tuple[float, float, float, float]:
        """Return the wheels' turning rates for a body twist, in the order of WHEELS [rad/s].

        Each is (vx -+ vy -+ (half_length + half_width) omega) / radius [Taheri2015].
        """
        turn = (self.half_length + self.half_width) * twist.omega
        return (
            (twist.vx - twist.vy - turn) / self.radius,
            (twist.vx + twist.vy + turn) / self.radius,
            (twist.vx + twist.vy - turn) / self.radius,
            (twist.vx - twist.vy + turn) / self.radius,
        )

    def twist(self, speeds: tuple[float, float, float, float]) -> Twist2D:
        """Return the body twist of wheels that turn at given rates [rad/s]: the inverse of `speeds`.

        Of four rates three are free; the mean takes what does not fit together for slip [Taheri2015].
        """
        front_left, front_right, rear_left, rear_right = speeds
        quarter = 0.25 * self.radius
        return Twist2D(
            quarter * (front_left + front_right + rear_left + rear_right),
            quarter * (-front_left + front_right + rear_left - rear_right),
            quarter * (-front_left + front_right - rear_left + rear_right) / (self.half_length + self.half_width),
        )
