#pragma once

#include "drivers/measurement/sweep.hpp"
#include "fusion/geometry/project_points.hpp"

namespace infuse::registration {

/// Reserves a quarter more than is needed when the memory has to grow, so that slightly larger
/// sweeps do not allocate again.
template <class Vector>
void reserve_with_headroom(Vector& vector, size_t size) {
  if (size > vector.capacity()) vector.reserve(size + size / 4);
}

/// Points with the normals of their local planes, as a structure of arrays in a frame whose origin
/// is within a few hundred metres.
struct PointCloud {
  FieldVector<float> x, y, z;     ///< m
  FieldVector<float> nx, ny, nz;  ///< unit normals; (0, 0, 0) where there is no plane

  size_t size() const { return x.size(); }
  geometry::PointsView points() const { return {x, y, z}; }

  /// Sets the length of every array; new entries are not initialised. Keeps the memory.
  void resize(size_t points) {
    for (FieldVector<float>* field : {&x, &y, &z, &nx, &ny, &nz}) {
      reserve_with_headroom(*field, points);
      field->resize(points);
    }
  }
};

}  // namespace infuse::registration
