"""infuse: fusion of lidars, cameras and odometry.

Units are metres, radians, seconds; stamps are whole nanoseconds since the Unix epoch. T_a_b, a (4, 4) array, takes
coordinates in frame b to coordinates in frame a. What cannot be read raises infuse.Error with the sentence that the
command `infuse` prints; a wrong argument raises ValueError or TypeError.
"""

import sys as _sys

from . import _infuse
from ._infuse import (Camera, Decoder, Error, GnssFix, GyroReadings, Image, ImuSample, Intrinsics, Lidar, Monitor,
                      MonitorReport, Recording, Reestimate, Sweep, WheelOdometry, __version__, calibration, decode,
                      dependence, models, motion, registration, study)
from . import client, plot, results, streetmap
from .opening import open
from .replay import Replay

for _name in ("calibration", "dependence", "motion", "registration", "study"):
    _sys.modules[f"{__name__}.{_name}"] = getattr(_infuse, _name)

__all__ = ["Camera", "Decoder", "Error", "GnssFix", "GyroReadings", "Image", "ImuSample", "Intrinsics", "Lidar",
           "Monitor", "MonitorReport", "Recording", "Reestimate", "Replay", "Sweep", "WheelOdometry", "calibration",
           "client", "decode", "dependence", "models", "motion", "open", "plot", "registration", "results", "streetmap", "study"]
