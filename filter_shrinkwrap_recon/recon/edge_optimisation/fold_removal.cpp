#include "edge_optimisation/fold_removal.h"

#include <cmath>

#include "common/parallel.h"
#include "geometry/triangle_geometry.h"
#include "mesh/face_patches.h"

namespace shrinkwrap {
namespace {

constexpr Index kGrain = 1 << 12;
constexpr int kMostPasses = 32;  // of flips
// Slivers are made only where the folds stay without them.
constexpr FlipLimits kLimits[] = {{-1.0, 1e-2}, {-1.0, 1e-8}};

// Flips at the folds and in the ring of faces around them, while one of the five edges of the hinge
// is a fold and they bend less for the flip.
Index flip_folds(HingeFlips& hinges, const std::vector<Index>& faces, double fold_cosine,
                 const FlipLimits& limits) {
  Index flips = 0;
  for (const Index h : edges_of(hinges.mesh(), faces_near(hinges.mesh(), faces, 1))) {
    const auto most_pairs = [&](const HingeShape& now, const HingeShape& then) {
      return now.sharpest < fold_cosine && bends_less(then, now) ? hinges.pair_count_at(h) : -1;
    };
    if (hinges.try_flip(h, limits, most_pairs)) ++flips;
  }
  return flips;
}

}  // namespace

std::vector<Index> folded_faces(const SurfaceMesh& mesh, const FoldOptions& options,
                                Progress& progress, const std::vector<Index>& fixed_faces) {
  const double fold_cosine = std::cos(options.angle);
  std::vector<char> is_fixed(fixed_faces.empty() ? 0 : mesh.face_slots());
  for (const Index f : fixed_faces) is_fixed[f] = 1;
  std::vector<char> is_folded(static_cast<std::size_t>(mesh.face_slots()));
  parallel_for_each(mesh.face_slots(), kGrain, progress, [&](Index f) {
    if (mesh.is_removed_face(f)) return;
    const Vec3 area = mesh.area_vector(f);
    for (Index h = 3 * f; h < 3 * f + 3; ++h) {
      const Index g = SurfaceMesh::face(mesh.twin(h));
      if (!is_fixed.empty() && (is_fixed[f] || is_fixed[g])) continue;
      const Vec3 across = mesh.area_vector(g);
      if (area.dot(across) < fold_cosine * area.norm() * across.norm()) is_folded[f] = 1;
    }
  });
  std::vector<Index> faces;
  for (Index f = 0; f < mesh.face_slots(); ++f)
    if (is_folded[f]) faces.push_back(f);
  return faces;
}

FoldReport remove_folds(HingeFlips& hinges, const FoldOptions& options, Progress& progress) {
  const SurfaceMesh& mesh = hinges.mesh();
  const auto folded = [&] { return folded_faces(mesh, options, progress, hinges.fixed_faces()); };
  FoldReport report;
  std::vector<Index> faces = folded();
  report.faces_before = report.faces_after = static_cast<Index>(faces.size());
  if (faces.empty() || report.faces_before > options.most_folded * mesh.face_count()) return report;
  std::int64_t moves_left = most_moves(mesh);
  hinges.meetings().grant(kTestsPerMove * moves_left);
  for (const FlipLimits& limits : kLimits) {
    for (int pass = 0; pass < kMostPasses && !faces.empty(); ++pass) {
      const Index flips = flip_folds(hinges, faces, std::cos(options.angle), limits);
      if (flips == 0) break;
      report.flips += flips;
      faces = folded();
    }
    const Index annealed =
        static_cast<Index>(anneal_around(hinges, clusters_of(mesh, faces), 1, limits,
                                         options.annealing, moves_left, progress, 1.0)
                               .size());
    if (annealed == 0) continue;
    report.annealed += annealed;
    faces = folded();
  }
  report.faces_after = static_cast<Index>(faces.size());
  return report;
}

}  // namespace shrinkwrap
