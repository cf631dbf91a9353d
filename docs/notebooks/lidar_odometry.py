# %% [markdown]
# The path of a vehicle from its lidar alone. Each sweep is deskewed by the motion before, registered to a local map, and
# deskewed again by the motion found.

# %%
import sys

import numpy as np

import infuse

drive = sys.argv[1] if len(sys.argv) > 1 else "drive"
recording = infuse.open(drive)
lidar = recording.lidars[0]

# %% Ten lines
odometry = infuse.registration.LidarOdometry(lidar.T_vehicle_lidar)
stamps, poses = [], []
for sweep in recording.sweeps(lidar.name):
    result = odometry.add(sweep)
    if result.usable:
        stamps.append(result.stamp_ns)
        poses.append(result.T_map_vehicle)
path = np.stack(poses)
length = np.linalg.norm(np.diff(path[:, :3, 3], axis=0), axis=1).sum()
print(f"{len(path)} poses, {length:.1f} m driven")

# %% Against the truth: distance between the first and the last pose
truth = np.loadtxt(f"{drive}/truth/poses.tum")
when = truth[:, 0]
true_path = np.stack([np.interp(np.array(stamps) * 1e-9, when, truth[:, k]) for k in (1, 2, 3)], 1)
driven = np.linalg.norm(np.diff(true_path, axis=0), axis=1).sum()
error = np.linalg.norm(path[-1, :3, 3] - path[0, :3, 3]) - np.linalg.norm(true_path[-1] - true_path[0])
print(f"true: {driven:.1f} m; error of the distance covered: {100 * abs(error) / driven:.2f} %")
assert abs(error) < 0.02 * driven + 0.2

# %% A figure
try:
    infuse.plot.trajectory(path, label="lidar").figure.savefig("lidar_odometry.png")
except ImportError:
    print("no figure: python3-matplotlib is not installed")
