"""infuse.plot: figures of results, by Matplotlib (python3-matplotlib, which is needed only when they are drawn).

Each function draws into `axes`, or into new ones, and returns them: axes.figure.savefig("figure.png").
"""

import numpy as np

__all__ = ["position_covariances", "profile", "projection", "trajectory"]


def projection(image, points, intrinsics, T_camera_lidar, *, values=None, axes=None):
    """Draws points of a lidar over an image.

    image: an Image or its pixels. points: (N, 3), a Sweep or a DeskewedSweep. values: (N,), the colour; None: distance
    along the optical axis, m, by its logarithm.
    """
    from .calibration import project
    axes = _axes(axes)
    pixels = np.asarray(getattr(image, "pixels", image))
    uv, depth = project(points, intrinsics, T_camera_lidar)
    seen = np.flatnonzero((depth > 0) & (uv > -0.5).all(1) & (uv[:, 0] < intrinsics.width - 0.5)
                          & (uv[:, 1] < intrinsics.height - 0.5))
    colour = np.log10(depth[seen]) if values is None else np.asarray(values)[seen]
    axes.imshow(pixels[..., ::-1] if pixels.ndim == 3 else pixels, cmap="gray", vmin=0, vmax=255)
    axes.scatter(*uv[seen].T, c=colour, s=2, cmap="turbo" if values is None else "viridis", linewidths=0)
    axes.set_axis_off()
    return axes


def profile(offsets, values, *, truth=0, label=None, unit="°", axes=None):
    """Draws a measure along offsets of a pose, (K,), and where the truth lies; None: it is not drawn.

    values: (K,), or a dict of them by name; each is scaled to 0 ... 1, so that measures of different units compare.
    """
    axes = _axes(axes)
    for name, given in (values.items() if isinstance(values, dict) else [(label, values)]):
        given = np.asarray(given, dtype=float)
        span = np.ptp(given)
        axes.plot(offsets, (given - given.min()) / (span if span > 0 else 1), label=name)
    if truth is not None:
        axes.axvline(truth, color="0.6", linewidth=1, zorder=0)
    axes.set_xlabel(f"offset, {unit}")
    axes.set_ylabel("measure, scaled")
    if axes.get_legend_handles_labels()[1]:
        axes.legend()
    return axes


def trajectory(poses, covariances=None, *, every=10, sigmas=3.03, label=None, axes=None):
    """Draws a path from above, x and y, with the ellipse of every so many poses.

    poses: (N, 4, 4). covariances: (N, 6, 6), (rx, ry, rz, tx, ty, tz). sigmas: 3.03 holds 99 % of a plane's errors,
    exp(-sigmas² / 2).
    """
    from matplotlib.patches import Ellipse
    axes = _axes(axes)
    poses = np.asarray(poses)
    line, = axes.plot(poses[:, 0, 3], poses[:, 1, 3], label=label)
    if covariances is not None:
        for pose, covariance in list(zip(poses, position_covariances(poses, covariances)))[::every]:
            size, directions = np.linalg.eigh(covariance[:2, :2])
            axes.add_patch(Ellipse(pose[:2, 3], *(2 * sigmas * np.sqrt(np.maximum(size[::-1], 0))),
                                   angle=np.degrees(np.arctan2(directions[1, 1], directions[0, 1])),
                                   facecolor=line.get_color(), alpha=0.25, linewidth=0))
    axes.set_aspect("equal", adjustable="datalim")
    axes.set_xlabel("x, m")
    axes.set_ylabel("y, m")
    if label is not None:
        axes.legend()
    return axes


def position_covariances(poses, covariances):
    """(N, 3, 3): covariances of the positions of poses, (N, 4, 4), from (N, 6, 6) of left perturbations.

    A left perturbation turns about the origin of the target frame: it moves a position p by t - p x r.
    """
    poses, covariances = np.asarray(poses, dtype=float), np.asarray(covariances, dtype=float)
    moves = np.zeros((len(poses), 3, 6))
    x, y, z = poses[:, :3, 3].T
    moves[:, 0, 1], moves[:, 0, 2] = z, -y
    moves[:, 1, 0], moves[:, 1, 2] = -z, x
    moves[:, 2, 0], moves[:, 2, 1] = y, -x
    moves[:, :, 3:] = np.eye(3)
    return moves @ covariances @ moves.transpose(0, 2, 1)


def _axes(axes):
    if axes is not None:
        return axes
    import matplotlib.pyplot as plt
    return plt.figure(figsize=(8, 5)).add_subplot()
