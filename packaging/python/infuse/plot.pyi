from typing import Any, Mapping, Optional, Union

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import Image, Intrinsics
from .registration import Points

Axes = Any  # of Matplotlib

def projection(image: Union[Image, NDArray[np.uint8]], points: Points, intrinsics: Intrinsics,
               T_camera_lidar: ArrayLike, *, values: Optional[ArrayLike] = None,
               axes: Optional[Axes] = None) -> Axes: ...
def profile(offsets: ArrayLike, values: Union[ArrayLike, Mapping[str, ArrayLike]], *, truth: Optional[float] = 0,
            label: Optional[str] = None, unit: str = "°", axes: Optional[Axes] = None) -> Axes: ...
def trajectory(poses: ArrayLike, covariances: Optional[ArrayLike] = None, *, every: int = 10, sigmas: float = 3.03,
               label: Optional[str] = None, axes: Optional[Axes] = None) -> Axes: ...
def position_covariances(poses: ArrayLike, covariances: ArrayLike) -> NDArray[np.float64]: ...
