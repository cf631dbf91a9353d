"""What the tests share."""

import os
import subprocess
import tempfile
import unittest

import numpy as np

BUILD = os.environ["INFUSE_BUILD"]
SOURCES = os.environ["INFUSE_SOURCES"]


def program(name):
    return os.path.join(BUILD, "bin", name)


def capture(folder, seconds=2):
    """A capture of an HDL-32E."""
    path = os.path.join(folder, "capture.pcap")
    subprocess.run([program("infuse-make-capture"), "-o", path, "--seconds", str(seconds)], check=True,
                   stdout=subprocess.DEVNULL)
    return path


def room(n=6000, seed=1):
    """Points on the floor and two walls of a room, with 1 cm of noise: (N, 3) float32."""
    random = np.random.default_rng(seed)
    points = random.uniform(0, 10, (n, 3))
    for wall in range(3):
        points[wall::3, wall] = 0
    return (points + random.normal(0, 0.01, points.shape)).astype(np.float32)


def moved(points, yaw=0.02, shift=(0.1, -0.05, 0.02)):
    """Points seen from elsewhere, and the pose T_target_source that takes them back."""
    pose = np.eye(4)
    pose[:2, :2] = [[np.cos(yaw), -np.sin(yaw)], [np.sin(yaw), np.cos(yaw)]]
    pose[:3, 3] = shift
    back = np.linalg.inv(pose)
    return (points @ back[:3, :3].T + back[:3, 3]).astype(np.float32), pose


def scratch():
    return tempfile.TemporaryDirectory(prefix="infuse-test-")


class OnAStreet(unittest.TestCase):
    """Tests of a simulated street: `self.drive` in `self.folder`."""

    @classmethod
    def setUpClass(cls):
        cls.folder = scratch()
        cls.drive = os.path.join(cls.folder.name, "drive")
        subprocess.run([os.path.join(SOURCES, "fixtures/simulate_once"), program("infuse-simulate-unversioned"),
                        os.path.join(SOURCES, "fixtures/scenarios/street_quick.toml"), "-o", cls.drive], check=True,
                       stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)

    @classmethod
    def tearDownClass(cls):
        cls.folder.cleanup()
