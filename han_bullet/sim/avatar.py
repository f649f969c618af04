"""A dressed body in a PyBullet client: loaded once, posed by joint angles, never stepped."""

from __future__ import annotations

from dataclasses import dataclass

import pybullet as p

from han_bullet import assets
from han_bullet.errors import BadInputError
from han_bullet.sim.gait import JOINTS, BodyPose
from han_bullet.sim.skeleton import skeleton_of

Colour = tuple[float, float, float]


@dataclass(frozen=True)
class Outfit:
    """Colours of the clothes, red, green and blue in [0, 1].

    Attributes:
        shirt, trousers, shoes, hair, skin: Colours.
        long_sleeves: Whether the sleeves reach the wrists.
        shorts: Whether the trousers end at the knees.
        coat: Whether the upper garment reaches down over the hips.
        bag: Colour of a bag on the back, or None.
    """

    shirt: Colour
    trousers: Colour
    shoes: Colour
    hair: Colour
    skin: Colour
    long_sleeves: bool = True
    shorts: bool = False
    coat: bool = False
    bag: Colour | None = None


_LIGHT_SKIN, _TAN_SKIN, _DARK_SKIN = (0.76, 0.57, 0.47), (0.64, 0.45, 0.34), (0.36, 0.24, 0.18)
_BLACK_HAIR, _BROWN_HAIR = (0.08, 0.07, 0.07), (0.26, 0.17, 0.11)
_BLOND_HAIR, _GREY_HAIR = (0.66, 0.52, 0.32), (0.55, 0.54, 0.53)
_NAVY, _BLACK, _JEANS, _KHAKI = (0.10, 0.12, 0.20), (0.09, 0.09, 0.10), (0.16, 0.22, 0.36), (0.40, 0.33, 0.24)
_SHOES = (0.12, 0.10, 0.09)
OUTFITS: tuple[Outfit, ...] = (
    Outfit((0.16, 0.30, 0.55), (0.13, 0.13, 0.16), _SHOES, _BROWN_HAIR, _LIGHT_SKIN),
    Outfit((0.66, 0.14, 0.13), _JEANS, (0.25, 0.22, 0.20), _BLACK_HAIR, _TAN_SKIN, long_sleeves=False),
    Outfit((0.13, 0.13, 0.15), (0.34, 0.38, 0.46), _SHOES, _BLOND_HAIR, _LIGHT_SKIN, coat=True),
    Outfit((0.20, 0.42, 0.26), (0.30, 0.25, 0.19), _SHOES, _BLACK_HAIR, _DARK_SKIN, bag=(0.16, 0.14, 0.13)),
    Outfit((0.50, 0.32, 0.13), _NAVY, (0.20, 0.18, 0.17), _GREY_HAIR, _LIGHT_SKIN),
    Outfit((0.36, 0.20, 0.42), _BLACK, (0.28, 0.25, 0.24), _BROWN_HAIR, _TAN_SKIN),
    Outfit((0.24, 0.26, 0.28), _KHAKI, _SHOES, _BLACK_HAIR, _LIGHT_SKIN, coat=True),
    Outfit((0.10, 0.36, 0.42), (0.20, 0.20, 0.22), _BLACK, _BLACK_HAIR, _DARK_SKIN, long_sleeves=False, shorts=True),
)


class Avatar:
    """One person's body in one client.

    Attributes:
        body: Its id in that client.
    """

    outfits_count = len(OUTFITS)

    def __init__(self, client: int, build: str, outfit: int) -> None:
        """Load the body of a build, "slim" or "broad", and dress it in outfit 0 to outfits_count - 1."""
        if not 0 <= outfit < self.outfits_count:
            raise BadInputError(f"outfit is {outfit}; there are 0 to {self.outfits_count - 1}")
        skeleton_of(build)  # raises on a build that does not exist
        self._client = client
        self.body: int = p.loadURDF(
            str(assets.urdf_folder() / f"avatar_{build}.urdf"), useFixedBase=True, physicsClientId=client
        )
        links = self._links_by_joint()
        self._joints = [links[name] for name in JOINTS]
        self._dress(OUTFITS[outfit], links)

    def place(self, body_pose: BodyPose) -> None:
        """Put the body into a pose. Nothing is stepped: links without mass would turn into NaN."""
        pose = body_pose.pose_in_world
        p.resetBasePositionAndOrientation(
            self.body,
            (pose.x, pose.y, body_pose.root_height),
            p.getQuaternionFromEuler((0.0, body_pose.root_pitch, pose.yaw)),
            physicsClientId=self._client,
        )
        p.resetJointStatesMultiDof(
            self.body, self._joints, [[angle] for angle in body_pose.joints], physicsClientId=self._client
        )

    def _links_by_joint(self) -> dict[str, int]:
        """Return link index by the name of the joint above it; the base has -1."""
        count = p.getNumJoints(self.body, physicsClientId=self._client)
        infos = [p.getJointInfo(self.body, index, physicsClientId=self._client) for index in range(count)]
        return {info[1].decode(): info[0] for info in infos}

    def _dress(self, outfit: Outfit, links: dict[str, int]) -> None:
        for joint, index in {"base": -1, **links}.items():
            colour = _colour_of(joint, outfit)
            if colour is not None:
                p.changeVisualShape(self.body, index, rgbaColor=colour, physicsClientId=self._client)


def _colour_of(joint: str, outfit: Outfit) -> tuple[float, float, float, float] | None:
    """Return the rgba of the part below a joint; None for frames without a shape; alpha 0 is not drawn."""
    part = joint.removesuffix("_left").removesuffix("_right")
    colours: dict[str, Colour | None] = {
        "base": outfit.trousers,
        "waist_pitch": outfit.shirt,
        "neck_pitch": outfit.skin,
        "hair": outfit.hair,
        "eyes": (0.12, 0.09, 0.08),
        "shoulder_roll": outfit.shirt,
        "elbow": outfit.shirt if outfit.long_sleeves else outfit.skin,
        "hand": outfit.skin,
        "hip_pitch": outfit.trousers,
        "knee": outfit.skin if outfit.shorts else outfit.trousers,
        "ankle_roll": outfit.shoes,
        "coat": outfit.shirt if outfit.coat else None,
        "bag": outfit.bag,
    }
    if part not in colours:
        return None
    colour = colours[part]
    return (*colour, 1.0) if colour is not None else (0.0, 0.0, 0.0, 0.0)
