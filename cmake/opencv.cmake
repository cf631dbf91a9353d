# The separate OpenCV modules as imported targets opencv::calib3d, opencv::imgproc, ... Debian ships OpenCV's own
# CMake configuration only with the metapackage libopencv-dev, which brings 245 packages.
find_path(OPENCV_INCLUDE opencv2/core.hpp REQUIRED PATH_SUFFIXES opencv4)
foreach(module core imgproc flann features2d calib3d)
  find_library(OPENCV_${module} opencv_${module} REQUIRED)
  add_library(opencv::${module} UNKNOWN IMPORTED)
  set_target_properties(opencv::${module} PROPERTIES
    IMPORTED_LOCATION ${OPENCV_${module}}
    INTERFACE_INCLUDE_DIRECTORIES ${OPENCV_INCLUDE}
    INTERFACE_SYSTEM_INCLUDE_DIRECTORIES ${OPENCV_INCLUDE})
endforeach()
