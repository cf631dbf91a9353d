"""Drives and captures as the commands read them; the socket of a live replay."""

import json
import os
import subprocess
import time
import unittest

import numpy as np

import common
import infuse
from common import program


class Drive(common.OnAStreet):
    def test_items_come_by_time_and_are_those_of_each_iterator(self):
        recording = infuse.open(self.drive)
        inspected = json.loads(subprocess.run([program("infuse"), "inspect", self.drive, "--json"], check=True,
                                              capture_output=True).stdout)
        kinds = {}
        stamps = []
        for sensor, item in recording:
            kinds[type(item).__name__] = kinds.get(type(item).__name__, 0) + 1
            if isinstance(item, infuse.Image):
                stamps.append(item.stamp_ns)
        self.assertEqual(stamps, sorted(stamps))
        self.assertEqual(kinds["Sweep"], len(list(recording.sweeps())))
        self.assertEqual(kinds["Image"], len(list(recording.images())))
        self.assertIn("ImuSample", kinds)
        self.assertTrue(inspected)
        image = next(recording.images())
        camera = recording.cameras[0].intrinsics
        self.assertEqual(image.pixels.shape[:2], (camera.height, camera.width))

    def test_deskewed_sweeps_are_those_of_infuse_decode(self):
        out = os.path.join(self.folder.name, "sweep.csv")
        subprocess.run([program("infuse"), "decode", self.drive, "--deskew", "--sweep", "3", "-o", out], check=True,
                       stdout=subprocess.DEVNULL)
        rows = np.genfromtxt(out, delimiter=",", names=True)
        sweep = list(infuse.open(self.drive).sweeps(deskew=True))[3]
        self.assertEqual(len(rows), len(sweep))
        np.testing.assert_allclose(np.stack([rows["x"], rows["y"], rows["z"]], 1), sweep.points, atol=1e-3)

    def test_odometry_from_samples_follows_the_truth(self):
        recording = infuse.open(self.drive)
        odometry = infuse.motion.Odometry()
        for sample in recording.samples():
            if not isinstance(sample, infuse.GyroReadings):
                odometry.add(sample)
        odometry.flush()
        trajectory = odometry.trajectory
        truth = np.loadtxt(os.path.join(self.drive, "truth/poses.tum"))
        driven = np.linalg.norm(np.diff(truth[:, 1:4], axis=0), axis=1).sum()
        estimated = np.linalg.norm(np.diff(trajectory.poses[:, :3, 3], axis=0), axis=1).sum()
        self.assertGreater(driven, 5)
        self.assertLess(abs(estimated - driven), 0.05 * driven + 0.5)

    def test_calibration_is_that_of_infuse_calibrate(self):
        said = subprocess.run([program("infuse"), "calibrate", self.drive, "--scenes", "4", "--measure", "mi", "--json"],
                              capture_output=True, check=False).stdout
        expected = json.loads(said)
        pairs = infuse.calibration.read_pairs([self.drive], max_scenes=4)
        result = infuse.calibration.calibrate(pairs, measure="mi")
        np.testing.assert_allclose(result.T_camera_lidar.ravel(), expected["T_camera_lidar"], rtol=0, atol=1e-12)
        self.assertEqual(result.usable, expected["usable"])
        self.assertEqual(result.reason, expected["reason"])
        poses = np.stack([result.T_camera_lidar, result.T_camera_lidar @ turned(0.1)])
        at, beside = infuse.calibration.evaluate(pairs, poses, measure="mi")
        self.assertGreater(at, beside)

    def test_pairs_are_read_as_they_come(self):
        pairs, expected = [], infuse.calibration.read_pairs([self.drive], max_scenes=10**6)
        infuse.calibration.each_pair(self.drive, lambda *pair: pairs.append(pair))
        self.assertEqual(len(pairs), len(expected))
        truth = np.loadtxt(os.path.join(self.drive, "truth/poses.tum"))
        for k, (image, sweep, twist) in enumerate(pairs):
            np.testing.assert_array_equal(image.pixels, expected.image(k).pixels)
            np.testing.assert_array_equal(sweep.x, expected.sweep(k).x)
            self.assertEqual(image.stamp_ns, expected.image(k).stamp_ns)
        at = pairs[20][0].stamp_ns * 1e-9
        around = [[np.interp(at + s, truth[:, 0], truth[:, c]) for c in (1, 2, 3)] for s in (-0.1, 0.1)]
        speed = np.linalg.norm(np.subtract(*around)) / 0.2
        self.assertLess(abs(np.linalg.norm(pairs[20][2][3:]) - speed), 0.05 * speed)
        with self.assertRaises(ZeroDivisionError):
            infuse.calibration.each_pair(self.drive, lambda *pair: 1 / 0)

    def test_a_measure_of_ones_own_sees_the_samples(self):
        pairs = infuse.calibration.read_pairs([self.drive], max_scenes=4)
        poses = np.stack([pairs.truth @ turned(angle) for angle in (-0.03, 0, 0.03)])
        seen = []

        def histogram(lidar, image):
            seen.append((lidar.dtype, len(lidar) == len(image), image.min() >= 0, image.max() <= 1))
            return float(infuse.dependence.histogram_measure(lidar, image, measure="mi"))

        beside, at, other = infuse.calibration.evaluate(pairs, poses, measure=histogram)
        self.assertGreater(at, max(beside, other))
        self.assertEqual(set(seen), {(np.dtype(np.float32), True, True, True)})
        with self.assertRaises(ZeroDivisionError):
            infuse.calibration.evaluate(pairs, poses, measure=lambda lidar, image: 1 / 0)

    def test_track_is_that_of_the_daemon(self):
        streets = infuse.streetmap.compile(os.path.join(self.drive, "map.osm"))
        x, y, yaw = start_of(os.path.join(self.drive, "truth/poses.tum"))
        track = infuse.streetmap.track(self.drive, streets, initial_pose=(x, y, yaw), program=program("infused"))
        self.assertGreater(len(track.stamps_ns), 20)
        self.assertEqual(track.covariances.shape, (len(track.stamps_ns), 6, 6))
        truth = np.loadtxt(os.path.join(self.drive, "truth/poses.tum"))
        true = np.stack([np.interp(track.stamps_ns * 1e-9, truth[:, 0], truth[:, c]) for c in (1, 2)], 1)
        self.assertLess(np.linalg.norm(track.poses[:, :2, 3] - true, axis=1).max(), 2)

    def test_replay_is_that_of_the_daemon(self):
        reports = os.path.join(self.folder.name, "reports.jsonl")
        infused = program("infused")
        subprocess.run([infused, "--replay", self.drive, "--reports", reports, "--socket",
                        os.path.join(self.folder.name, "s")], check=True, stdout=subprocess.DEVNULL,
                       stderr=subprocess.DEVNULL)
        replay = infuse.Replay(self.drive, program=infused)
        with open(reports, "rb") as file:
            self.assertEqual(file.read().splitlines(), replay.lines)
        self.assertIn("SWEEP", {report["class"] for report in replay})
        with self.assertRaisesRegex(infuse.Error, "no_drive"):
            infuse.Replay(self.folder.name + "/no_drive", program=infused)

    def test_the_client_reads_a_running_daemon(self):
        path = os.path.join(self.folder.name, "live.sock")
        daemon = subprocess.Popen([program("infused"), "--replay", self.drive, "--rate", "1", "--socket", path],
                                  stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        try:
            for _ in range(200):
                if os.path.exists(path):
                    break
                time.sleep(0.05)
            with infuse.client.Client(path) as client:
                self.assertEqual(client.version["protocol"][0], 2)
                reports = client.watch("SWEEP")
                self.assertEqual([next(reports)["class"] for _ in range(3)], ["SWEEP"] * 3)
            with infuse.client.Client(path) as client:
                self.assertIn("SWEEP", {report["class"] for report in client.status()})
                self.assertEqual(client.devices()["class"], "DEVICES")
                with self.assertRaises(infuse.client.ClientError):
                    client.apply(999)
        finally:
            daemon.kill()
            daemon.wait()
        with self.assertRaisesRegex(infuse.client.ClientError, "running"):
            infuse.client.Client(path + "x")


def start_of(path):
    """x, y, yaw of a trajectory's first pose."""
    pose = infuse.motion.read_trajectory(path)[1][0]
    return pose[0, 3], pose[1, 3], np.arctan2(pose[1, 0], pose[0, 0])


def turned(angle):
    pose = np.eye(4)
    pose[:2, :2] = [[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]]
    return pose


if __name__ == "__main__":
    unittest.main()
