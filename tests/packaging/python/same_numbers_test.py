"""Every call gives C++'s numbers, to the bit, whatever the layout of the arrays."""

import os
import subprocess
import unittest

import numpy as np

import infuse
from common import SOURCES, capture, moved, program, room, scratch


class SameNumbers(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = scratch()
        at = cls.folder.name
        cls.capture = capture(at)
        cls.target = room()
        cls.source, cls.pose = moved(room(seed=2))
        random = np.random.default_rng(3)
        cls.x = random.uniform(0, 1, 500).astype(np.float32)
        cls.y = (0.6 * cls.x + 0.4 * random.uniform(0, 1, 500)).astype(np.float32)
        for name in ("target", "source"):
            getattr(cls, name).T.tofile(os.path.join(at, name + ".f32"))
        for name in ("x", "y"):
            getattr(cls, name).tofile(os.path.join(at, name + ".f32"))
        cls.image = random.integers(0, 256, (240, 320), dtype=np.uint8)
        cls.image[:, 100:220] //= 4
        cls.image.tofile(os.path.join(at, "image.u8"))
        cls.T_camera_lidar = np.array([[0., -1, 0, 0.1], [0, 0, -1, -0.2], [1, 0, 0, -0.3], [0, 0, 0, 1]])
        cls.T_camera_lidar.tofile(os.path.join(at, "camera.f64"))
        cls.map = infuse.streetmap.compile(os.path.join(SOURCES, "fixtures/maps/altfeld.osm"))
        cls.map.save(os.path.join(at, "street.map"))
        subprocess.run([program("python-reference"), at], check=True)

    @classmethod
    def tearDownClass(cls):
        cls.folder.cleanup()

    def expected(self, name):
        return np.fromfile(os.path.join(self.folder.name, name + ".out"))

    def same(self, name, *values):
        got = np.concatenate([np.asarray(value, dtype=np.float64).ravel() for value in values])
        np.testing.assert_array_equal(got, self.expected(name))

    def test_align(self):
        results = [infuse.registration.align(self.target, self.source, factor=factor) for factor in ("gicp", "plane")]
        self.same("align", *(value for r in results for value in (r.T_target_source, r.covariance)))
        for result in results:
            self.assertTrue(result.usable, result.reason)
            np.testing.assert_allclose(result.T_target_source, self.pose, atol=0.01)

    def test_layout_of_points_does_not_matter(self):
        expected = infuse.registration.align(self.target, self.source).T_target_source
        wide = np.hstack([self.source, np.ones((len(self.source), 1), np.float32)])
        for given in (self.source.astype(np.float64), np.asfortranarray(self.source), wide,
                      np.repeat(self.source, 2, axis=0)[::2], self.source.tolist()):
            np.testing.assert_array_equal(infuse.registration.align(self.target, given).T_target_source, expected)

    def test_dependence(self):
        measures = infuse.dependence
        histogram = measures.Histogram(self.x)
        values = []
        for name in ("mi", "nmi", "chi2", "smi"):
            estimate, gradient = histogram.value_and_gradient(self.y, name)
            values += [float(estimate), gradient]
            self.assertEqual(float(measures.histogram_measure(self.x, self.y, measure=name)), float(estimate))
        for name in ("smi", "qmi", "sce"):
            values.append(float(measures.LeastSquares(self.x, measure=name).evaluate(self.y)))
        values += map(lambda part: part if isinstance(part, np.ndarray) else float(part),
                      measures.LeastSquares(self.x).value_and_gradient(self.y))
        values += map(lambda part: part if isinstance(part, np.ndarray) else float(part),
                      measures.BaggedLsmi(self.x, bags=5, bag_size=100).value_and_gradient(self.y))
        self.same("measure", *values)

    def test_decode(self):
        sweeps = list(infuse.decode(self.capture, "HDL-32E"))
        self.assertGreater(len(sweeps), 15)
        values = []
        for sweep in sweeps:
            values += [len(sweep), sweep.x, sweep.y, sweep.z, sweep.reflectivity, sweep.ring, sweep.time_offset_ns]
        self.same("decode", *values)
        with open(self.capture, "rb") as file:
            of_bytes = list(infuse.decode(file.read(), "HDL-32E"))
        np.testing.assert_array_equal(of_bytes[3].points, sweeps[3].points)
        # A recording is cut behind the vehicle, a decoder's sweeps ahead of it.
        opened = list(infuse.open(self.capture).sweeps())
        self.assertEqual(sum(map(len, opened)), sum(map(len, sweeps)))

    def test_odometry_and_deskewing(self):
        odometry = infuse.registration.LidarOdometry()
        sweeps = list(infuse.decode(self.capture, "HDL-32E"))
        self.same("odometry", *(odometry.add(sweep).T_map_vehicle for sweep in sweeps))
        poses = np.tile(np.eye(4), (2, 1, 1))
        poses[1, 0, 3] = 2
        stamps = sweeps[1].stamp_ns + np.array([0, 150_000_000])
        deskewed = infuse.motion.deskew(sweeps[1], infuse.motion.Trajectory(stamps, poses))
        self.same("deskew", deskewed.x, deskewed.y, deskewed.z)

    def test_monitor(self):
        monitor = infuse.Monitor(infuse.Intrinsics(320, 240, 160, 160, 160, 120), self.T_camera_lidar)
        values, evaluated = [], 0
        for k, sweep in enumerate(infuse.decode(self.capture, "HDL-32E")):
            image = infuse.Image((self.image + np.uint8(7 * k)).astype(np.uint8), stamp_ns=sweep.stamp_ns)
            report = monitor.process(image, sweep, [0, 0, 0.1, 8, 0, 0])
            evaluated += report.evaluated
            values += [report.evaluated, report.dependence, report.evidence, report.offset, report.sigma]
        self.same("monitor", *values)
        self.assertGreater(evaluated, 2)
        refused = monitor.reestimate()
        self.assertFalse(refused.usable)
        self.assertTrue(refused.reason)

    def test_street_map(self):
        tracker = infuse.streetmap.Tracker(self.map)
        tracker.start([3, 4, 0.5], np.diag([1, 1, 0.01]))
        values = []
        for sweep in infuse.decode(self.capture, "HDL-32E"):
            tracker.predict([0.5, 0, 0.01], np.diag([1e-4, 1e-4, 1e-6]), 0.1)
            tracker.add_sweep(sweep)
            tracker.update()
            estimate = tracker.estimate
            values += [estimate.pose, estimate.covariance, estimate.score, estimate.p_value]
        self.same("track", *values)
        self.assertGreater(len(tracker.particles), 50)
        again = infuse.streetmap.Map(os.path.join(self.folder.name, "street.map"))
        west, east, south, north = again.extent
        places = np.random.default_rng(1).uniform([west - 50, south - 50], [east + 50, north + 50], (2000, 2))
        ids = self.map.ids_at(places)
        np.testing.assert_array_equal(ids, again.ids_at(places))
        outside = (places < [west, south]).any(1) | (places > [east, north]).any(1)
        self.assertFalse(ids[outside].any())
        kinds = {self.map.kind_of(int(k)) for k in ids}
        self.assertLessEqual({"carriageway", "building", "open land"}, kinds)
        self.assertLessEqual(kinds, set(infuse.streetmap.KINDS))
        self.assertIn(max(self.map.image(300).pixels.shape[:2]), range(150, 301))

    def test_trajectories(self):
        stamps = 1_700_000_000_123_456_789 + np.arange(4) * 100_000_000
        poses = np.tile(np.eye(4), (4, 1, 1))
        angle = 0.3 * np.arange(4)
        poses[:, 0, 0] = poses[:, 1, 1] = np.cos(angle)
        poses[:, 1, 0], poses[:, 0, 1] = np.sin(angle), -np.sin(angle)
        poses[:, :3, 3] = np.arange(12).reshape(4, 3)
        tum, kitti = (os.path.join(self.folder.name, name) for name in ("path.tum", "path.txt"))
        infuse.motion.write_tum(tum, stamps, poses)
        infuse.motion.write_kitti(kitti, poses)
        columns = np.loadtxt(tum)  # the format: https://cvg.cit.tum.de/data/datasets/rgbd-dataset/file_formats
        np.testing.assert_allclose(columns[:, 1:4], poses[:, :3, 3], atol=1e-6)
        np.testing.assert_allclose(columns[:, 6:], np.stack([np.sin(angle / 2), np.cos(angle / 2)], 1), atol=1e-8)
        np.testing.assert_allclose(np.loadtxt(kitti), poses[:, :3].reshape(4, 12), atol=1e-6)
        read_stamps, read = infuse.motion.read_trajectory(tum)
        np.testing.assert_array_equal(read_stamps, stamps)
        np.testing.assert_allclose(read, poses, atol=1e-6)
        np.testing.assert_allclose(infuse.motion.read_trajectory(kitti)[1], poses, atol=1e-6)

    def test_projection(self):
        camera = infuse.Intrinsics(640, 480, 400, 410, 320, 240, [0.1, -0.05, 1e-3, 2e-3, 0.01])
        points = room(100) + [0, 0, 5]
        pixels, depth = infuse.calibration.project(points, camera, np.eye(4))
        x, y = points[:, 0] / points[:, 2], points[:, 1] / points[:, 2]
        r2 = x * x + y * y
        k1, k2, p1, p2, k3 = camera.distortion
        radial = 1 + k1 * r2 + k2 * r2**2 + k3 * r2**3  # OpenCV's documentation
        u = 320 + 400 * (x * radial + 2 * p1 * x * y + p2 * (r2 + 2 * x * x))
        v = 240 + 410 * (y * radial + p1 * (r2 + 2 * y * y) + 2 * p2 * x * y)
        near = ~np.isnan(pixels[:, 0])
        self.assertGreater(near.sum(), 50)
        np.testing.assert_allclose(pixels[near], np.stack([u, v], 1)[near], atol=0.01)
        np.testing.assert_allclose(depth, points[:, 2], rtol=1e-6)


if __name__ == "__main__":
    unittest.main()
