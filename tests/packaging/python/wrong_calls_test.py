"""Wrong shapes, types, strides, values and threads raise; nothing crashes; memory stays flat."""

import os
import random
import threading
import unittest

import numpy as np

import infuse
from common import SOURCES, capture, moved, room, scratch

NAN = float("nan")
WRONG_POINTS = [None, 3, "points", [], np.zeros((0, 3)), np.zeros(3), np.zeros((5, 2)), np.zeros((5, 5)),
                np.zeros((2, 2, 3)), np.full((9, 3), NAN), np.full((9, 3), np.inf), np.full((9, 3), 1e300),
                np.zeros((4, 3), complex), np.array([["a", "b", "c"]]), np.array([[object()] * 3]), b"bytes", {}]
WRONG_POSES = [3, "pose", np.eye(3), np.zeros((4, 4)), np.full((4, 4), NAN), np.diag([1., 1, -1, 1]), np.eye(4) * 2,
               np.eye(4, dtype=complex), [np.eye(4)], np.ones((4, 4))]
WRONG_SAMPLES = [None, 3, "x", [], np.zeros((0,)), np.zeros(7), np.zeros((2, 3, 4)), np.full(200, NAN),
                 np.full(200, -np.inf), np.zeros(200, complex), np.array(["a"] * 200), {}]
WRONG_NAMES = ["", "gcip", "HDL-33", 3, None, b"im", "m" * 10000]
WRONG_COUNTS = [-1, 0, 10**9, 10**30, 1.5, "many", None]
WRONG_LABELS = [None, [], np.zeros(3, int), np.full(200, -1), np.full(200, 10**6), np.full(200, 10**12),
                np.full(200, 0.5), np.zeros((200, 2), int)]

ALLOWED = (ValueError, TypeError, IndexError, infuse.Error, OverflowError)


class WrongCalls(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = scratch()
        cls.before = os.getcwd()
        os.chdir(cls.folder.name)  # what a wrong path names is written here
        cls.sweeps = list(infuse.decode(capture(cls.folder.name, 1), "HDL-32E"))
        cls.points = room(600)
        generator = np.random.default_rng(1)
        cls.x = generator.uniform(0, 1, 200)
        cls.y = cls.x + generator.uniform(0, 1, 200)

    @classmethod
    def tearDownClass(cls):
        os.chdir(cls.before)
        cls.folder.cleanup()

    def calls(self):
        """(function, right keyword arguments, wrong values by argument)"""
        r, d, m, c = infuse.registration, infuse.dependence, infuse.motion, infuse.calibration
        camera = infuse.Intrinsics(64, 48, 40, 40, 32, 24)
        stamps, poses = np.array([0, 10**8]), np.tile(np.eye(4), (2, 1, 1))
        image = infuse.Image(np.zeros((48, 64), np.uint8))
        yield r.prepare, {"points": self.points}, {"points": WRONG_POINTS, "voxel_size": [-1, NAN, "x"]}
        yield (r.align, {"target": self.points, "source": self.points},
               {"target": WRONG_POINTS, "source": WRONG_POINTS, "guess": WRONG_POSES, "factor": WRONG_NAMES,
                "max_correspondence_distance": [-1, 0, NAN], "robust_width": [-1, NAN], "max_iterations": [-1, 1.5]})
        yield (r.global_align, {"target": self.points, "source": self.points},
               {"target": WRONG_POINTS, "source": WRONG_POINTS, "voxel_size": [-1, 0, NAN]})
        yield r.LidarOdometry, {}, {"T_vehicle_lidar": WRONG_POSES, "min_range": [-1, NAN]}
        yield r.LidarOdometry().add, {"sweep": self.sweeps[0]}, {"sweep": WRONG_POINTS, "guess": WRONG_POSES}
        yield (d.Histogram, {"x": self.x},
               {"x": [w for w in WRONG_SAMPLES if not isinstance(w, np.ndarray) or w.shape != (7,)],
                "bins": WRONG_COUNTS, "window": WRONG_NAMES, "weights": [[1], -np.ones(200), np.full(200, NAN)],
                "x_range": [(1, 0), (0, NAN), 3, (1,)]})
        histogram = d.Histogram(self.x)
        for call in (histogram.value, histogram.value_and_gradient):
            yield call, {"y": self.y}, {"y": WRONG_SAMPLES, "measure": WRONG_NAMES}
        yield histogram.table, {"y": self.y}, {"y": WRONG_SAMPLES}
        yield (d.LeastSquares, {"x": self.x},
               {"x": [None, "x", [], np.zeros((2, 3, 4)), np.full(9, NAN)], "measure": WRONG_NAMES, "form": WRONG_NAMES,
                "sigmas": [[-1], [NAN], [0], "x"], "lambdas": [[-1], [NAN]], "folds": [-1, 0, "x"],
                "centres": [-1, 0, "x"]})
        fit = d.LeastSquares(self.x)
        yield fit.evaluate, {"y": self.y}, {"y": WRONG_SAMPLES}
        yield fit.value_and_gradient, {"y": self.y}, {"y": WRONG_SAMPLES}
        yield fit.evaluate_labels, {"labels": np.arange(200) % 3}, {"labels": WRONG_LABELS}
        yield (d.BaggedLsmi, {"x": self.x, "bags": 2, "bag_size": 50},
               {"x": WRONG_SAMPLES, "bags": WRONG_COUNTS, "bag_size": WRONG_COUNTS})
        yield d.BaggedLsmi(self.x, bags=2, bag_size=50).evaluate, {"y": self.y}, {"y": WRONG_SAMPLES}
        yield (d.shrunk_information, {"x": [0, 1], "y": [0, 1], "target": [0.5, 0.5]},
               {"x": [[0], [0, 2], [0, -1], [0.5, 1], None], "y": [[0], [9, 9]],
                "target": [[], [1, 1], [1.5, -0.5], [NAN, 1], "x"], "shrinkage": [-1, 2, NAN, "x"]})
        yield d.entropy, {"counts": [3, 2, 1]}, {
            "counts": [None, [], [-1], [NAN], [0, 0], "x"], "estimator": WRONG_NAMES}
        yield (d.directed_information, {"x": [0, 1] * 20, "y": [1, 0] * 20},
               {"x": WRONG_LABELS[:1] + [[0] * 3, [0.5] * 40, "x"], "memory": [-1, 17, 0.5, None],
                "estimator": WRONG_NAMES + ["james-stein"]})
        t = infuse.study
        yield t.estimate, {"key": "dcor", "x": self.x, "y": self.y}, {
            "key": WRONG_NAMES, "x": WRONG_SAMPLES, "y": WRONG_SAMPLES}
        yield t.distance_correlation, {"x": self.x, "y": self.y}, {"x": WRONG_SAMPLES, "y": WRONG_SAMPLES}
        yield (t.place_information, {"place": self.sweeps[0], "query": self.sweeps[1]},
               {"place": [None, 3, self.points], "query": [None, "x"], "T_vehicle_lidar": WRONG_POSES,
                "yaw": [NAN, "x", None]})
        words = np.random.default_rng(1).normal(size=(5, 4))
        yield t.quantise, {"features": words, "words": words}, {
            "features": [None, [], np.zeros((3, 5)), np.full((2, 4), NAN)], "words": [None, [], np.zeros((3, 5))]}
        yield (m.Trajectory, {"stamps_ns": stamps, "poses": poses},
               {"stamps_ns": [[], [0], [1, 0], [0, 0], [0.5, 1], None, "xy"],
                "poses": [np.eye(4), np.zeros((2, 4, 4)), poses[:1], None, np.full((2, 4, 4), NAN)],
                "max_gap_ns": [-1, "x"]})
        yield m.Trajectory(stamps, poses).at, {"stamp_ns": 5}, {"stamp_ns": [-1, 10**9, 0.5, 10**30, None]}
        first = self.sweeps[0]
        long = m.Trajectory(first.stamp_ns + np.array([-10**8, 0, 10**8, 2 * 10**8]), np.tile(np.eye(4), (4, 1, 1)))
        yield (m.deskew, {"sweep": first, "trajectory": long},
               {"sweep": WRONG_POINTS, "trajectory": [None, poses], "T_vehicle_lidar": WRONG_POSES,
                "reference_ns": [0, 10**30, "x"]})
        yield m.Odometry, {}, {"wheelbase": [-1, NAN], "track": [-1, NAN], "capacity": [-1, 10**12]}
        yield m.Odometry().add, {"sample": infuse.ImuSample(0, [0] * 3, [0] * 3)}, {"sample": [None, 3, first]}
        yield c.project, {"points": self.points, "intrinsics": camera, "T_camera_lidar": np.eye(4)}, {
            "points": WRONG_POINTS, "intrinsics": [None, 3], "T_camera_lidar": WRONG_POSES}
        yield c.make_pairs, {"sweeps": [first], "images": [image], "intrinsics": camera}, {
            "sweeps": [[], [None], None, 3, [first] * 2], "images": [[], [None], 3],
            "intrinsics": [None, infuse.Intrinsics(65, 48, 40, 40, 32, 24)]}
        pairs = c.make_pairs([first], [image], camera)
        yield pairs.sweep, {"index": 0}, {"index": [1, -1, "x", 10**30]}
        yield c.evaluate, None, {
            "pairs": [None, 3], "poses": [[], np.eye(4), np.zeros((1, 4, 4)), None], "measure": WRONG_NAMES,
            "sigma": [-1, NAN, 1e9]}
        yield c.calibrate, None, {"pairs": [None, 3], "initial": WRONG_POSES, "measure": WRONG_NAMES}
        yield c.read_pairs, None, {"drives": [[], ["/nowhere"], [""], None, 3]}
        yield c.each_pair, None, {"drive": ["/nowhere", "", None, 3], "on_pair": [None, 3]}
        yield (infuse.Monitor, {"intrinsics": camera, "T_camera_lidar": np.eye(4)},
               {"intrinsics": [None, 3], "T_camera_lidar": WRONG_POSES, "min_interval_s": [-1, NAN, "x"],
                "min_distance": [-1, NAN]})
        monitor = infuse.Monitor(camera, np.eye(4))
        yield (monitor.process, {"image": image, "sweep": first, "twist": [0, 0, 0.1, 8, 0, 0]},
               {"image": [None, 3, np.zeros((48, 64), np.uint8), infuse.Image(np.zeros((4, 6), np.uint8))],
                "sweep": WRONG_POINTS, "twist": [3, [0] * 5, [NAN] * 6, np.zeros((6, 1)), "sixsix"]})
        yield monitor.set_calibration, {"T_camera_lidar": np.eye(4)}, {"T_camera_lidar": WRONG_POSES}
        yield monitor.inject_miscalibration, {"T_camera_lidar": np.eye(4)}, {"T_camera_lidar": WRONG_POSES}
        yield monitor.reestimate, {}, {"since_ns": [0.5, 10**30, "x"], "seed": [-1, 0.5]}
        s = infuse.streetmap
        osm = os.path.join(SOURCES, "fixtures/maps/landstrasse.osm")
        yield (s.compile, {"source": osm, "cell_size": 1.0},
               {"source": [None, 3, "", "/nowhere", __file__, "\0"], "cell_size": [-1, 0, NAN, "x"],
                "clip_deg": [[1], [0, 0, 0, 0], "x", [NAN] * 4, [170, 80, 171, 81]], "metres_per_pixel": [-1, 0, NAN, 1]})
        yield s.Map, None, {"path": [None, 3, "/nowhere", __file__, osm]}
        streets = s.compile(osm, cell_size=1.0)
        yield streets.ids_at, {"places": [[0, 0]]}, {"places": [None, [], [0, 0], [[0] * 3], [[NAN, 0]], "x"]}
        yield streets.save, {"path": self.folder.name + "/map"}, {"path": [None, 3, "", "/nowhere/at/all", "\0"]}
        yield streets.image, {"largest": 100}, {"largest": [-1, 0, 10**9, 1.5, None]}
        yield s.Tracker, {"map": streets}, {"map": [None, 3, osm], "seed": [-1, 0.5]}
        tracker = s.Tracker(streets)
        wrong_covariances = [3, np.eye(2), -np.eye(3), np.full((3, 3), NAN), [[1, 2, 0], [0, 1, 0], [0, 0, 1]], "x"]
        yield (tracker.start, {"pose": [0, 0, 0], "covariance": np.eye(3)},
               {"pose": [3, [0, 0], [NAN] * 3, "xyz"], "covariance": wrong_covariances})
        yield (tracker.predict, {"motion": [1, 0, 0], "covariance": np.eye(3) * 1e-4, "seconds": 0.1},
               {"motion": [3, [0, 0], [NAN] * 3], "covariance": wrong_covariances, "seconds": [-1, NAN, 1e9, "x"]})
        yield (tracker.add_sweep, {"sweep": first, "image": image, "intrinsics": camera},
               {"sweep": WRONG_POINTS, "T_vehicle_lidar": WRONG_POSES, "image": [None, 3], "intrinsics": [None, 3],
                "T_camera_lidar": WRONG_POSES, "image_step": [0, -1, 1000, 1.5]})
        yield tracker.add_fix, {"position": [0, 0]}, {
            "position": [3, [0], [NAN, 0], "xy"], "yaw": [NAN, "x"], "hdop": [-1, NAN, 1e9]}
        yield (m.write_tum, {"path": self.folder.name + "/t", "stamps_ns": stamps, "poses": poses},
               {"path": [None, 3, "/nowhere/at/all", ""], "stamps_ns": [[0], [1, 0], [0.5, 1], "xy"],
                "poses": [np.eye(4), poses[:1], np.zeros((2, 4, 4)), None]})
        yield (m.write_kitti, {"path": self.folder.name + "/t", "poses": poses},
               {"path": [None, "/nowhere/at/all"], "poses": [np.eye(4), np.zeros((2, 4, 4)), None]})
        yield m.read_trajectory, {"path": self.folder.name + "/t"}, {"path": [None, "/nowhere", __file__]}
        yield infuse.Intrinsics, {"width": 64, "height": 48, "fx": 40, "fy": 40, "cx": 32, "cy": 24}, {
            "width": WRONG_COUNTS[:2], "fx": [0, -1, NAN], "distortion": [[NAN], [0] * 6, 3], "model": WRONG_NAMES}
        yield infuse.Image, {"pixels": np.zeros((4, 6), np.uint8)}, {
            "pixels": [None, "x", np.zeros((4, 6)), np.zeros((0, 6), np.uint8), np.zeros((4, 6, 2), np.uint8)]}
        yield infuse.Sweep, {"points": self.points}, {
            "points": WRONG_POINTS, "ring": [[1], np.full(600, -1), np.full(600, 70000), np.full(600, 0.5)],
            "time_offset_ns": [[1], np.full(600, -1), np.full(600, 2**31)], "reflectivity": [[1], np.full(600, NAN)]}
        yield infuse.decode, {"source": self.folder.name + "/capture.pcap", "model": "HDL-32E"}, {
            "source": [None, 3, b"", b"no capture" * 100, "/nowhere", self.folder.name], "model": WRONG_NAMES,
            "calibration": ["/nowhere", 3]}
        yield infuse.Decoder, {"model": "VLP-16"}, {"model": WRONG_NAMES, "calibration": ["/nowhere"]}
        yield infuse.Decoder("VLP-16").push, {"payload": b"x" * 1206, "stamp_ns": 0}, {
            "payload": [None, "text", 3], "stamp_ns": ["x", 10**30, 0.5], "port": [-1, 70000]}
        yield infuse.results.read, {"name": "decode", "text": '{"sweeps": 1, "returns": 2, "not_deskewed": 0}'}, {
            "name": WRONG_NAMES, "text": [None, 3, "", "{}", "[]", b"\xff", '{"sweeps": NaN}']}
        yield infuse.results.run, None, {"command": WRONG_NAMES}
        yield infuse.open, {"path": self.folder.name + "/capture.pcap"}, {
            "path": [None, "/nowhere", os.path.dirname(__file__), __file__, "", "\0"], "model": ["HDL-33", 3]}

    def test_one_wrong_argument_is_named(self):
        count = 0
        for function, right, wrong in self.calls():
            if right is not None:
                function(**right)
            for argument, values in wrong.items():
                for value in values:
                    with self.subTest(function=str(function), argument=argument, value=repr(value)[:60]):
                        with self.assertRaises(ALLOWED) as raised:
                            function(**{**(right or {}), argument: value})
                        self.assertTrue(str(raised.exception))
                        count += 1
        self.assertGreater(count, 300)

    def test_many_wrong_arguments_never_crash(self):
        pool = WRONG_POINTS + WRONG_POSES + WRONG_SAMPLES + WRONG_NAMES + WRONG_COUNTS[:2] + WRONG_LABELS + [
            self.sweeps[0], self.points, self.x]
        choose = random.Random(7)
        functions = [(function, list(wrong)) for function, _, wrong in self.calls()]
        failed = 0
        for _ in range(2000):
            function, names = choose.choice(functions)
            try:
                function(**{name: choose.choice(pool) for name in names if choose.random() < 0.8})
            except ALLOWED:
                failed += 1
        self.assertGreater(failed, 1500)

    def test_a_second_thread_is_refused_while_the_first_works(self):
        odometry = infuse.registration.LidarOdometry()
        stop = threading.Event()

        def work():
            while not stop.is_set():
                for sweep in self.sweeps:
                    try:
                        odometry.add(sweep)
                    except RuntimeError:
                        pass

        other = threading.Thread(target=work)
        other.start()
        try:
            with self.assertRaisesRegex(RuntimeError, "another thread"):  # only if the lock is released in work
                for _ in range(200000):
                    odometry.reset()
        finally:
            stop.set()
            other.join()

    def test_arrays_of_a_sweep_are_its_memory(self):
        sweep = self.sweeps[1]
        x = sweep.x
        self.assertTrue(np.shares_memory(x, sweep.x))
        with self.assertRaises(ValueError):
            x[0] = 1
        with self.assertRaises(ValueError):
            x.flags.writeable = True
        copy = infuse.Sweep(self.points)
        y = copy.y
        expected = self.points[:, 1].copy()
        del copy
        np.testing.assert_array_equal(y, expected)

    def test_memory_is_flat(self):
        points, (other, _) = room(6000), moved(room(6000, 2))
        cloud = infuse.registration.prepare(points)
        x = np.random.default_rng(1).uniform(0, 1, 20000).astype(np.float32)
        histogram = infuse.dependence.Histogram(x)
        labels = np.random.default_rng(2).integers(0, 8, 20000)
        camera = infuse.Intrinsics(640, 480, 400, 400, 320, 240)
        with open(self.folder.name + "/capture.pcap", "rb") as file:
            data = file.read()

        def each():
            infuse.registration.align(cloud, other, max_iterations=3)
            histogram.value_and_gradient(x)
            infuse.calibration.project(points, camera, np.eye(4))
            infuse.dependence.directed_information(labels, labels[::-1])
            infuse.study.estimate("mi-spline-window", x, x)
            infuse.study.quantise(points, points[:50])
            infuse.results.read("decode", b'{"sweeps": 1, "returns": 2, "not_deskewed": 0}')
            sweep = infuse.Sweep(points)
            sum(len(getattr(sweep, name)) for name in ("x", "ring", "points"))
            next(infuse.decode(data, "HDL-32E"))
            try:
                infuse.registration.align(points * NAN, points)
            except ValueError:
                pass

        for _ in range(30):
            each()
        before = resident()
        for _ in range(100):
            each()
        # Each pass makes arrays of a megabyte and more.
        self.assertLess(resident() - before, 8e6)


def resident():
    with open("/proc/self/statm") as file:
        return int(file.read().split()[1]) * 4096


if __name__ == "__main__":
    unittest.main()
