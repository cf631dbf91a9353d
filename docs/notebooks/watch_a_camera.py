# %% [markdown]
# A camera is knocked while the vehicle drives. A monitor compares each image with the lidar's sweep at the present
# calibration and a step to every side of it: while the calibration holds no step is better; after the knock one is, image
# by image, until chance cannot explain it. The scenes since then give the new calibration.

# %%
import sys

import numpy as np

import infuse

drive = sys.argv[1] if len(sys.argv) > 1 else "knocked"
camera = infuse.open(drive).cameras[0]
monitor = infuse.Monitor(camera.intrinsics, camera.T_camera_lidar)
reports = []


def on_pair(image, sweep, twist):
    report = monitor.process(image, sweep, twist)
    if report.evaluated:
        reports.append(report)


infuse.calibration.each_pair(drive, on_pair)
seconds = np.array([report.stamp_ns - reports[0].stamp_ns for report in reports]) * 1e-9

# %% When it was seen, and what
confirmed = next(report for report in reports if report.drift == "confirmed")
suspected = next(report for report in reports if report.drift == "suspected")
for report in (suspected, confirmed):
    print(f"{(report.stamp_ns - reports[0].stamp_ns) * 1e-9:.1f} s: {report.drift}, {report}")

# %% The calibration anew, from what the camera saw since
repaired = monitor.reestimate(confirmed.since_ns)
print(f"{repaired.scenes} scenes:", "usable" if repaired.usable else repaired.reason)


def apart(a, b):
    """Degrees between two poses."""
    difference = a[:3, :3] @ b[:3, :3].T
    return np.degrees(np.arccos(np.clip((np.trace(difference) - 1) / 2, -1, 1)))


# %% Against the truth, which a simulated drive has
truth = np.loadtxt(f"{drive}/truth/extrinsics.csv", delimiter=",", skiprows=1, usecols=range(2, 18)).reshape(-1, 4, 4)
print(f"error: {apart(camera.T_camera_lidar, truth[-1]):.2f} deg before, "
      f"{apart(repaired.T_camera_lidar, truth[-1]):.2f} deg after")
knocked = np.loadtxt(f"{drive}/truth/extrinsics.csv", delimiter=",", skiprows=1, usecols=0, dtype=np.int64)
knocked_ns = knocked[np.abs(truth - truth[0]).max(axis=(1, 2)) > 1e-9].min()
print(f"knocked at {(knocked_ns - reports[0].stamp_ns) * 1e-9:.1f} s")
assert suspected.stamp_ns > knocked_ns
assert apart(repaired.T_camera_lidar, truth[-1]) < 0.5 * apart(camera.T_camera_lidar, truth[-1])

# %% A figure: the evidence, and the estimated error of the calibration
try:
    import matplotlib.pyplot as plt
    figure, (above, below) = plt.subplots(2, sharex=True, figsize=(8, 6))
    above.plot(seconds, [report.evidence for report in reports])
    above.axhline(confirmed.threshold, color="0.6", linewidth=1)
    above.set_ylabel("evidence, nats")
    offsets = np.degrees([report.offset[:3] for report in reports])
    below.plot(seconds, offsets, label=["about x", "about y", "about z"])
    below.set_ylabel("error of the calibration, °")
    below.set_ylim(-1, 1)
    below.set_xlabel("time, s")
    below.legend()
    figure.savefig("watch_a_camera.png")
except ImportError:
    print("no figure: python3-matplotlib is not installed")
