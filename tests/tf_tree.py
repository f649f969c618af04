"""A tree of frames as a subscriber of /tf and /tf_static builds it, by rules of its own."""

from __future__ import annotations

from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation


class FrameTree:
    """Where each frame is in its parent, from TFMessages."""

    def __init__(self, *messages: Any) -> None:
        transforms = [transform for message in messages for transform in message.transforms]
        self.parents = {t.child_frame_id: t.header.frame_id for t in transforms}
        assert len(self.parents) == len(transforms), "a frame has two parents"
        self._poses = {t.child_frame_id: _matrix(t.transform) for t in transforms}

    def pose(self, frame: str, parent: str) -> np.ndarray:
        """Return where a frame is in one above it, shape (4, 4)."""
        pose = np.eye(4)
        while frame != parent:
            pose = self._poses[frame] @ pose
            frame = self.parents[frame]
        return pose


def _matrix(transform: Any) -> np.ndarray:
    t, q = transform.translation, transform.rotation
    assert abs(np.linalg.norm([q.x, q.y, q.z, q.w]) - 1.0) < 1e-9
    pose = np.eye(4)
    pose[:3, :3], pose[:3, 3] = Rotation.from_quat([q.x, q.y, q.z, q.w]).as_matrix(), (t.x, t.y, t.z)
    return pose
