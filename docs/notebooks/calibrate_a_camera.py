# %% [markdown]
# A camera calibrated to a lidar without targets, and judged: by its own covariance, by what each scene says, and on images
# from which it was not estimated.

# %%
import sys

import numpy as np

import infuse

drive = sys.argv[1] if len(sys.argv) > 1 else "drive"
pairs = infuse.calibration.read_pairs([drive], max_scenes=int(sys.argv[2]) if len(sys.argv) > 2 else 12)
kept, held_out = pairs.split()
print(f"{len(kept)} pairs to calibrate with, {len(held_out)} to compare on; {pairs.notes}")

# %% The guess: the camera turned by a degree and moved by two centimetres
angle = np.radians(1)
turn = np.eye(4)
turn[[0, 0, 2, 2], [0, 2, 0, 2]] = np.cos(angle), np.sin(angle), -np.sin(angle), np.cos(angle)
turn[0, 3] = 0.02
guess = turn @ pairs.initial

# %% The calibration
result = infuse.calibration.calibrate(kept, guess, check_intrinsics=False)
print("usable" if result.usable else f"not usable: {result.reason}")
print(f"{result.points} points, {result.effective_scenes:.1f} effective scenes, support {result.support:.2f}, "
      f"{result.converged_restarts} of {result.restarts} restarts led here")
sigma = np.sqrt(np.diag(result.covariance))
print(f"stated: {np.degrees(sigma[:3]).round(3)} deg, {sigma[3:].round(3)} m")


# %% Judged: against the truth, where there is one, and on what was held out
def apart(a, b):
    """Degrees between two poses."""
    difference = a[:3, :3] @ b[:3, :3].T
    return np.degrees(np.arccos(np.clip((np.trace(difference) - 1) / 2, -1, 1)))


if pairs.truth is not None:
    print(f"error: {apart(guess, pairs.truth):.3f} deg before, {apart(result.T_camera_lidar, pairs.truth):.3f} deg after")
    assert apart(result.T_camera_lidar, pairs.truth) < 0.5 * apart(guess, pairs.truth)
comparison = infuse.calibration.compare(held_out, guess, result.T_camera_lidar)
print(f"on held-out images: {comparison.better} is better, p = {comparison.p_value:.2g} {comparison.reason}")
assert comparison.better != "old"

# %% A figure: returns over an image
try:
    axes = infuse.plot.projection(held_out.image(0), held_out.sweep(0), pairs.cameras[0].intrinsics, result.T_camera_lidar)
    axes.figure.savefig("calibrate_a_camera.png")
except ImportError:
    print("no figure: python3-matplotlib is not installed")
