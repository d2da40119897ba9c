#include "neighbour_edges.h"

namespace shrinkwrap {

SideAgreement::SideAgreement(const PointCloud& cloud) : cloud_(cloud) {
  // Bends of the surface and sheets near each other deviate from a plane as well, but not
  // everywhere.
  constexpr double kEvenest = 0.1;
  if (cloud.size() == 0) return;
  std::vector<float> deviation(cloud.position.size());
  for (Index i = 0; i < cloud.size(); ++i)
    deviation[i] = cloud.deviation[i] / cloud.local_spacing[i];
  const auto noise = deviation.begin() +
                     static_cast<std::ptrdiff_t>(kEvenest * static_cast<double>(deviation.size()));
  std::nth_element(deviation.begin(), noise, deviation.end());
  noise_ = *noise;
}

}  // namespace shrinkwrap
