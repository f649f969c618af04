"""People on the floor: ground projection, association, Kalman filter, posture, the tracker."""
