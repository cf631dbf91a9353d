"""infuse.open: one function for every kind of recording."""

import os
import tempfile
import weakref

from . import _infuse

_BAGS = (".bag", ".db3", ".mcap")
_KITTI = ("velodyne_points", "velodyne")


def open(path, *, model="", calibration=""):
    """Opens a drive, a capture, a KITTI folder or a bag; returns a Recording.

    A KITTI folder and a bag are imported, as `infuse import` does, into a temporary folder that vanishes with the
    Recording: sweeps and images of KITTI are linked there if they can be, what a bag holds is copied. model,
    calibration: of the lidar of a capture whose packets state neither. Error: what cannot be read, and why.
    """
    path = os.fspath(path)
    if not os.path.exists(path):
        raise _infuse.Error(f"{path}: no such file or folder")
    if os.path.isdir(path) and any(os.path.isdir(os.path.join(path, name)) for name in _KITTI):
        return _imported(_infuse.import_kitti, path)
    if path.endswith(_BAGS) or os.path.isfile(os.path.join(path, "metadata.yaml")):
        return _imported(_infuse.import_bags, [path])
    return _infuse.Recording(path, model=model, calibration=calibration)


def _imported(importer, source):
    folder = tempfile.TemporaryDirectory(prefix="infuse-")
    drive = os.path.join(folder.name, "drive")
    importer(source, drive)
    recording = _infuse.Recording(drive)
    weakref.finalize(recording, folder.cleanup)
    return recording
