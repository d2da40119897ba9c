// The plane through a point on which most of what lies around it does.
#pragma once

#include <Eigen/Core>

#include "common/types.h"

namespace shrinkwrap {

/// Neighbours of a point, and by how much each of them supports a plane through it: the more the
/// nearer it is to both. A plane that fits all neighbours best lies askew where they are of several
/// faces; that with the most support is the plane of one of them.
class PlaneSupport {
 public:
  static constexpr int kMostNeighbours = 64;
  using Vectors = Eigen::Array<float, 3, Eigen::Dynamic, 0, 3, kMostNeighbours>;
  using Row = Eigen::Array<float, 1, Eigen::Dynamic, Eigen::RowMajor, 1, kMostNeighbours>;

  /// `offset`: of the neighbours, from the point, which is the first of them (or one at its place);
  /// lengths, also of the `thickness` of a face, x the radius of the neighbourhood. Pre: 1 to
  /// kMostNeighbours columns.
  PlaneSupport(Vectors offset, double thickness);
  /// Neighbours support a plane on one side only, that to which they look. `normal`: of the
  /// neighbours, unit; that of the first is not asked for.
  PlaneSupport(Vectors offset, Vectors normal, double thickness);

  const Vectors& offset() const { return offset_; }
  Row heights_over(const Vec3f& normal) const {
    return normal[0] * offset_.row(0) + normal[1] * offset_.row(1) + normal[2] * offset_.row(2);
  }
  /// Of the plane, by each neighbour: about exp(-1.5 r^2 - h^2), r its distance and h its height in
  /// thicknesses; by the point itself 1.
  Row support_of(const Vec3f& normal) const;
  /// How many neighbours lie within a thickness of the plane, and look to its side; the point is
  /// one of them.
  int members_of(const Vec3f& normal) const;
  /// The mean cosine between the plane's normal and those of the neighbours that support it,
  /// weighted by their support; 0 if none does beside the point. Pre: sides matter.
  float agreement_with(const Vec3f& normal) const;

  /// The normal of the plane with the most support, of those through the point and any two of the
  /// eight nearest, fitted again twice to what supports it. Unit; zero if these all lie on a line.
  Vec3f normal_of_most_support() const;

 private:
  Vec3f normal_of_best_pair() const;
  Vec3f refined(const Vec3f& normal) const;
  Row cosines_with(const Vec3f& normal) const {
    return normal[0] * normal_.row(0) + normal[1] * normal_.row(1) + normal[2] * normal_.row(2);
  }
  // 1 for those that look to the side, and the point, 0 for the others.
  Row looking_to(const Vec3f& side) const;

  Vectors offset_;
  Vectors normal_;  // none if sides do not matter
  Row nearness_;
  float per_thickness_;
};

}  // namespace shrinkwrap
