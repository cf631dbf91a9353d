# %% [markdown]
# A registration factor of your own in C++, and a measure of dependence of your own, in Python and in C++. The C++ is
# [your_own.cpp](your_own.cpp), compiled against libinfuse-dev and called by ctypes.

# %%
import ctypes
import os
import subprocess
import sys
import tempfile

import numpy as np

import infuse

drive = sys.argv[1] if len(sys.argv) > 1 else "drive"
here = os.path.dirname(os.path.abspath(__file__))
folder = tempfile.mkdtemp()
flags = subprocess.run(["pkg-config", "--cflags", "--libs", "infuse"], check=True, capture_output=True, text=True).stdout
subprocess.run(["g++", "-std=c++20", "-O2", "-Wno-psabi", "-shared", "-fPIC", f"{here}/your_own.cpp", "-o", f"{folder}/your_own.so",
                *flags.split()], check=True)
own = ctypes.CDLL(f"{folder}/your_own.so")
floats = np.ctypeslib.ndpointer(np.float32, flags="C_CONTIGUOUS")
own.align_by_cauchy.argtypes = [floats, ctypes.c_size_t, floats, ctypes.c_size_t, np.ctypeslib.ndpointer(np.float64)]
own.align_by_cauchy.restype = ctypes.c_char_p
own.correlation_ratio.argtypes = [floats, floats, ctypes.c_size_t]
own.correlation_ratio.restype = ctypes.c_double


def align_by_cauchy(target, source):
    """T_target_source by the factor of your_own.cpp."""
    pose = np.zeros((4, 4))
    reason = own.align_by_cauchy(target, len(target), source, len(source), pose)
    assert not reason, reason
    return pose


# %% Two scans of a street, one of them 0.4 m further on, where a crowd has moved by a metre meanwhile
sweep = next(infuse.open(drive).sweeps()).points
random = np.random.default_rng(1)
crowd = random.uniform([3, -8, -1.9], [12, 8, 0.5], (6000, 3))
target = np.concatenate([sweep, crowd]).astype(np.float32)
moved = np.concatenate([sweep + random.normal(0, 0.02, sweep.shape), crowd + [1, 0, 0]])
truth = np.eye(4)
truth[0, 3] = 0.4
source = (moved - truth[:3, 3]).astype(np.float32)
for name, pose in [("the library's plane factor",
                    infuse.registration.align(target, source, factor="plane").T_target_source),
                   ("yours", align_by_cauchy(target, source))]:
    error = np.linalg.norm(pose[:3, 3] - truth[:3, 3])
    print(f"{name}: {1000 * error:.1f} mm from the truth")

# %% A measure of your own is a function of two vectors: slow, but right
pairs = infuse.calibration.read_pairs([drive], max_scenes=6)
truth = pairs.truth if pairs.truth is not None else pairs.initial
degrees = np.linspace(-2, 2, 17)
poses = np.tile(np.eye(4), (len(degrees), 1, 1))
poses[:, 0, 0] = poses[:, 2, 2] = np.cos(np.radians(degrees))
poses[:, 0, 2] = np.sin(np.radians(degrees))
poses[:, 2, 0] = -poses[:, 0, 2]
poses = poses @ truth


def correlation_ratio(lidar, image):
    """The share of the image's variance that the lidar explains by one of 16 levels."""
    level = np.clip(16 * lidar, 0, 15).astype(int)
    count, total = np.bincount(level, minlength=16), np.bincount(level, image.astype(float), minlength=16)
    explained = (total[count > 0] ** 2 / count[count > 0]).sum() / len(image)
    mean = image.mean(dtype=float)
    return (explained - mean**2) / ((image.astype(float) ** 2).mean() - mean**2)


profiles = {
    "joint": infuse.calibration.evaluate(pairs, poses),
    "yours": infuse.calibration.evaluate(pairs, poses, measure=correlation_ratio),
    "yours, C++": infuse.calibration.evaluate(
        pairs, poses, measure=lambda lidar, image: own.correlation_ratio(lidar, image, len(lidar))),
}
np.testing.assert_allclose(profiles["yours"], profiles["yours, C++"], rtol=1e-6)
for name, profile in profiles.items():
    print(f"{name}: largest at {degrees[np.argmax(profile)]:+.2f} deg, there {max(profile):.4f}, at the ends "
          f"{profile[0]:.4f}, {profile[-1]:.4f}")
assert abs(degrees[np.argmax(profiles["yours"])]) <= 0.5

# %% A figure
try:
    infuse.plot.profile(degrees, profiles).figure.savefig("your_own.png")
except ImportError:
    print("no figure: python3-matplotlib is not installed")
