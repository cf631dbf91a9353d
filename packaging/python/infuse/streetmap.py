"""infuse.streetmap: localisation on a street map."""

import os
import tempfile
from typing import NamedTuple

import numpy as np

from . import _infuse
from .replay import Replay

__all__ = ["KINDS", "Map", "Track", "Tracker", "TrackerEstimate", "compile", "track"]

KINDS = _infuse.streetmap.KINDS
Map = _infuse.streetmap.Map
Tracker = _infuse.streetmap.Tracker
TrackerEstimate = _infuse.streetmap.TrackerEstimate
compile = _infuse.streetmap.compile


class Track(NamedTuple):
    """Poses on the map, as infused reports them; the map frame is x east, y north of the map's origin."""

    stamps_ns: np.ndarray  #: (N,) int64
    poses: np.ndarray  #: (N, 4, 4), T_map_vehicle
    covariances: np.ndarray  #: (N, 6, 6), (rx, ry, rz, tx, ty, tz), left
    states: list  #: N of "TRACKING", "UNSURE", "LOST"
    usable: np.ndarray  #: (N,) bool


def track(drive, map, *, initial_pose=None, program="infused"):
    """Tracks the vehicle of a drive on a Map, or on the file of one, as infused does; a Track.

    initial_pose: (x, y, yaw), m and rad, map frame; None: by GNSS fixes, else by the drive itself.
    """
    with tempfile.TemporaryDirectory(prefix="infuse-") as folder:
        if isinstance(map, Map):
            file = os.path.join(folder, "map")
            map.save(file)
        else:
            file = os.path.abspath(os.fspath(map))
        lines = ["[streetmap]", f"map = {_toml(file)}"]
        if initial_pose is not None:
            x, y, yaw = (float(value) for value in initial_pose)
            lines += [f"x = {x!r}", f"y = {y!r}", f"yaw_deg = {np.degrees(yaw).item()!r}"]
        config = os.path.join(folder, "infused.toml")
        with open(config, "w", encoding="utf-8") as out:
            out.write("\n".join(lines) + "\n")
        replay = Replay(drive, config=config, program=program)
    reports = [report for report in replay if report["class"] == "POSE" and report["frame"] == "map"]
    return Track(np.array([report["stamp"] for report in reports], dtype=np.int64),
                 np.array([report["T_frame_vehicle"] for report in reports], dtype=float).reshape(-1, 4, 4),
                 np.array([report["covariance"] for report in reports], dtype=float).reshape(-1, 6, 6),
                 [report.get("state", "LOST") for report in reports],
                 np.array([report["usable"] for report in reports], dtype=bool))


def _toml(text):
    return '"' + "".join(f"\\u{ord(c):04x}" if c in '"\\' or ord(c) < 32 else c for c in text) + '"'
