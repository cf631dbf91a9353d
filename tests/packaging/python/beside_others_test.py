"""Results beside SciPy and Matplotlib, where they are installed, and against closed forms where they are not."""

import unittest

import numpy as np

import infuse
from common import moved, room

try:
    from scipy.spatial.transform import Rotation
except ImportError:
    Rotation = None
try:
    import matplotlib
    matplotlib.use("Agg")
except ImportError:
    matplotlib = None


class BesideOthers(unittest.TestCase):
    def test_covariances_of_positions(self):
        random = np.random.default_rng(1)
        pose = np.eye(4)
        pose[:3, 3] = 30, -20, 2
        sigma = np.array([1, 2, 3, 50, 40, 30]) * 1e-3
        r, t = np.split(random.normal(0, sigma, (200_000, 6)), 2, axis=1)
        moved_by = np.cross(r, pose[:3, 3]) + t  # of exp(r, t) to first order
        covariance = infuse.plot.position_covariances([pose], [np.diag(sigma**2)])[0]
        np.testing.assert_allclose(covariance, np.cov(moved_by.T), atol=0.02 * covariance.max())

    @unittest.skipIf(Rotation is None, "python3-scipy is not installed")
    def test_rotations_are_those_of_scipy(self):
        source, pose = moved(room())
        found = infuse.registration.align(room(seed=2), source).T_target_source
        error = Rotation.from_matrix(found[:3, :3]) * Rotation.from_matrix(pose[:3, :3]).inv()
        self.assertLess(error.magnitude(), 0.01)
        turn = np.eye(4)
        turn[:3, :3] = Rotation.from_euler("zyx", [0.1, 0.2, 0.3]).as_matrix()
        infuse.registration.align(room(), room(), turn)

    @unittest.skipIf(matplotlib is None, "python3-matplotlib is not installed")
    def test_figures_show_what_they_are_given(self):
        camera = infuse.Intrinsics(64, 48, 40, 40, 32, 24)
        points = np.array([[0, 0, 5], [1, 0, 5], [0, 0, -5], [100, 0, 5]], float)
        axes = infuse.plot.projection(infuse.Image(np.zeros((48, 64), np.uint8)), points, camera, np.eye(4))
        np.testing.assert_allclose(axes.collections[0].get_offsets(), [[32, 24], [40, 24]], atol=1e-4)
        axes = infuse.plot.profile([-1, 0, 1], {"a": [1, 3, 2], "b": [0, 0, 0]})
        np.testing.assert_allclose(axes.lines[0].get_ydata(), [0, 1, 0.5])
        poses = np.tile(np.eye(4), (11, 1, 1))
        poses[:, 0, 3] = np.arange(11)
        covariances = np.tile(np.diag([0, 0, 0, 4, 1, 1.0]), (11, 1, 1))
        axes = infuse.plot.trajectory(poses, covariances, every=5, sigmas=2)
        self.assertEqual(len(axes.patches), 3)
        self.assertAlmostEqual(axes.patches[0].width, 8)
        self.assertAlmostEqual(axes.patches[0].height, 4)
        self.assertAlmostEqual(axes.patches[0].angle % 180, 0)


if __name__ == "__main__":
    unittest.main()
