# Ceres, as a shared library. Debian's target is the static one; it brings compiled templates of Eigen, of which the
# linker takes one for all that call it: on arm64 theirs are fused, and `infuse` gave other bytes than on amd64.
find_package(Ceres REQUIRED)
get_target_property(location Ceres::ceres IMPORTED_LOCATION_RELEASE)
string(REPLACE ".a" ".so" location "${location}")
set_target_properties(Ceres::ceres PROPERTIES IMPORTED_LOCATION_RELEASE ${location}
  INTERFACE_LINK_LIBRARIES "Eigen3::Eigen;glog::glog")
