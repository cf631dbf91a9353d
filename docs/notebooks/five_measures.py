# %% [markdown]
# Where two sensors depend on each other most, they are calibrated. Five measures of dependence between the lidar's
# reflectivity and the image, with the camera turned about its vertical axis: three of the library on its own features, the
# same reflectivity and grey as the sensors state them by LSMI, and a measure of your own in NumPy.

# %%
import sys

import numpy as np

import infuse

drive = sys.argv[1] if len(sys.argv) > 1 else "drive"
pairs = infuse.calibration.read_pairs([drive], max_scenes=6)
camera = pairs.cameras[0].intrinsics
truth = pairs.truth if pairs.truth is not None else pairs.initial

degrees = np.linspace(-2, 2, 17)


def turned(angle):
    """The true pose, the camera turned by an angle about its vertical axis."""
    c, s = np.cos(np.radians(angle)), np.sin(np.radians(angle))
    turn = np.eye(4)
    turn[[0, 0, 2, 2], [0, 2, 0, 2]] = c, s, -s, c
    return turn @ truth


poses = np.stack([turned(angle) for angle in degrees])

# %% Three of the library: features relative to their surroundings
profiles = {name: np.array(infuse.calibration.evaluate(pairs, poses, measure=name)) for name in ("joint", "mi", "chi2")}


# %% Samples of your own: reflectivity and grey of the points that are in view at every pose
def samples():
    reflectivity, grey = [], []
    for k in range(len(pairs)):
        sweep, image = pairs.sweep(k), pairs.image(k)
        pixels = image.pixels if image.pixels.ndim == 2 else image.pixels.mean(axis=2)
        columns = []
        for pose in poses:
            uv, depth = infuse.calibration.project(sweep, camera, pose)
            u, v = np.nan_to_num(uv, nan=-9).round().astype(int).T
            inside = (depth > 1) & (u >= 0) & (v >= 0) & (u < camera.width) & (v < camera.height)
            columns.append(np.where(inside, pixels[v % camera.height, u % camera.width] / 255, np.nan))
        columns = np.stack(columns, 1)
        seen = ~np.isnan(columns).any(axis=1)
        reflectivity.append(sweep.reflectivity[seen])
        grey.append(columns[seen])
    return np.concatenate(reflectivity), np.concatenate(grey)


reflectivity, grey = samples()
print(f"{len(reflectivity)} points are in view at every pose")

# %% LSMI of a thousand of them, of unit variance
few = np.random.default_rng(1).choice(len(reflectivity), min(1000, len(reflectivity)), replace=False)
x = reflectivity[few] / reflectivity[few].std()
fit = infuse.dependence.LeastSquares(x, sigmas=[0.5], lambdas=[1e-2])
profiles["lsmi, raw"] = np.array([float(fit.evaluate(y / y.std())) for y in grey[few].T])


# %% Yours: Spearman's correlation, squared
def ranks(values):
    return values.argsort().argsort() / len(values)


profiles["spearman, raw"] = np.array([np.corrcoef(ranks(reflectivity), ranks(y))[0, 1] ** 2 for y in grey.T])

# %% Where each is largest
for name, profile in profiles.items():
    print(f"{name:14} largest at {degrees[profile.argmax()]:+.2f} deg, there {profile.max():.4f}, "
          f"at the ends {profile[0]:.4f}, {profile[-1]:.4f}")
assert abs(degrees[profiles["joint"].argmax()]) <= 0.5

# %% A figure
try:
    infuse.plot.profile(degrees, profiles).figure.savefig("five_measures.png")
except ImportError:
    print("no figure: python3-matplotlib is not installed")
