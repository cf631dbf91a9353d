"""What methods are compared with, against closed forms and brute force."""

import unittest

import numpy as np

import infuse
from common import capture, scratch


def distances(x):
    """Doubly centred distances between samples."""
    d = np.abs(x[:, None] - x)
    return d - d.mean(0) - d.mean(1)[:, None] + d.mean()


class Study(unittest.TestCase):
    def test_distance_correlation_is_that_of_its_definition(self):
        random = np.random.default_rng(1)
        x = random.normal(size=200)
        y = x**2 + random.normal(size=200)
        a, b = distances(x), distances(y)
        expected = np.sqrt((a * b).mean() / np.sqrt((a * a).mean() * (b * b).mean()))
        for found in (infuse.study.distance_correlation(x, y), infuse.study.estimate("dcor", x, y)):
            self.assertAlmostEqual(float(found), expected, places=12)
        two = random.normal(size=(200, 2))
        self.assertAlmostEqual(float(infuse.study.distance_correlation(two, 3 * two + 1)), 1, places=12)
        self.assertLess(abs(float(infuse.study.distance_correlation(x, two, corrected=True))), 0.05)

    def test_estimators_find_the_information_of_a_gaussian(self):
        random = np.random.default_rng(2)
        x = random.normal(size=5000)
        y = 0.8 * x + 0.6 * random.normal(size=5000)
        keys = [key for key, _, _ in infuse.study.estimators()]
        self.assertIn("mi-gaussian-window", keys)
        self.assertAlmostEqual(float(infuse.study.estimate("mi-gaussian-window", x, 7 * y - 3)),
                               -np.log(1 - 0.64) / 2, delta=0.1)  # a window lowers it

    def test_entropies_and_directed_information(self):
        counts = np.array([30, 20, 10])
        expected = -np.sum(counts / 60 * np.log(counts / 60))
        self.assertAlmostEqual(float(infuse.dependence.entropy(counts)), expected, places=12)
        self.assertAlmostEqual(float(infuse.dependence.entropy(counts, "miller-madow")), expected + 2 / 120, places=12)
        x = np.random.default_rng(3).integers(0, 4, 50000)
        of_past = infuse.dependence.directed_information(x[1:], x[:-1], delayed=True)  # y is what x was before
        of_future = infuse.dependence.directed_information(x[:-1], x[1:], delayed=True)
        self.assertAlmostEqual(float(of_past), np.log(4), delta=0.01)
        self.assertAlmostEqual(float(of_future), 0, delta=0.01)

    def test_words_are_the_nearest(self):
        words, frequencies = infuse.study.codebook()
        self.assertEqual(words.shape[0], len(frequencies))
        self.assertAlmostEqual(frequencies.sum(), 1, places=9)
        features = words[[5, 0, 7]] + 1e-4
        np.testing.assert_array_equal(infuse.study.quantise(features, words), [5, 0, 7])

    def test_a_place_informs_about_itself(self):
        with scratch() as folder:
            sweeps = list(infuse.decode(capture(folder, 2), "HDL-32E"))
        random = np.random.default_rng(4)
        noise = infuse.Sweep(random.uniform([-30, -30, -1], [30, 30, 3], (20000, 3)).astype(np.float32),
                             ring=random.integers(0, 32, 20000), reflectivity=random.uniform(0, 1, 20000))
        here, pose = infuse.study.place_information(sweeps[2], sweeps[2])
        self.assertLess(np.abs(pose).max(), 0.3)
        self.assertGreater(here, infuse.study.place_information(noise, sweeps[2])[0] + 0.1)


if __name__ == "__main__":
    unittest.main()
