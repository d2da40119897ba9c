#include "mesh/harmonic_surface.h"

#include <Eigen/Geometry>
#include <Eigen/IterativeLinearSolvers>
#include <Eigen/SparseCholesky>
#include <Eigen/SparseCore>
#include <algorithm>

#include "geometry/triangle_geometry.h"

namespace shrinkwrap {
namespace {

using Matrix = Eigen::SparseMatrix<double>;
using Entries = std::vector<Eigen::Triplet<double>>;

constexpr std::size_t kAggregate = 64;  // vertices
// Weights of edges: triangles of no area have neither.
constexpr double kLeastWeight = 1e-2, kGreatestWeight = 1e2;
constexpr double kTolerance = 1e-5;  // of the residual, x what it is at first
constexpr int kMostIterations = 300;

// For conjugate gradients: the diagonal, for what changes from vertex to vertex, and a coarse
// system with one unknown for each aggregate of vertices, for what changes slowly. The number of
// iterations hardly depends on that of the vertices then.
class TwoLevelPreconditioner {
 public:
  using StorageIndex = Matrix::StorageIndex;
  enum { ColsAtCompileTime = Eigen::Dynamic, MaxColsAtCompileTime = Eigen::Dynamic };

  /// What conjugate gradients call with the system, which `prepare` got.
  template <class M>
  TwoLevelPreconditioner& compute(const M&) {
    return *this;
  }
  void prepare(const Matrix& matrix, std::vector<Index> aggregate_of, Index count,
               Progress& progress) {
    progress_ = &progress;
    aggregate_of_ = std::move(aggregate_of);
    inverse_diagonal_ = matrix.diagonal().cwiseInverse();
    Entries entries;
    entries.reserve(static_cast<std::size_t>(matrix.nonZeros()));
    for (Eigen::Index column = 0; column < matrix.outerSize(); ++column)
      for (Matrix::InnerIterator entry(matrix, column); entry; ++entry)
        entries.emplace_back(aggregate_of_[entry.row()], aggregate_of_[entry.col()], entry.value());
    Matrix coarse(count, count);
    coarse.setFromTriplets(entries.begin(), entries.end());
    coarse_.compute(coarse);
  }
  Eigen::ComputationInfo info() const { return coarse_.info(); }

  Eigen::VectorXd solve(const Eigen::VectorXd& residual) const {
    progress_->update(0.5);
    Eigen::VectorXd sum = Eigen::VectorXd::Zero(coarse_.rows());
    for (Eigen::Index i = 0; i < residual.size(); ++i) sum[aggregate_of_[i]] += residual[i];
    const Eigen::VectorXd coarse = coarse_.solve(sum);
    Eigen::VectorXd result = inverse_diagonal_.cwiseProduct(residual);
    for (Eigen::Index i = 0; i < result.size(); ++i) result[i] += coarse[aggregate_of_[i]];
    return result;
  }

 private:
  std::vector<Index> aggregate_of_;  // per unknown
  Eigen::VectorXd inverse_diagonal_;
  Eigen::SimplicialLDLT<Matrix> coarse_;
  Progress* progress_ = nullptr;
};

class HarmonicSystem {
 public:
  HarmonicSystem(const SurfaceMesh& mesh, const std::vector<Index>& vertices)
      : mesh_(mesh), vertices_(vertices), place_(mesh.position.size(), kNone) {
    for (std::size_t i = 0; i < vertices.size(); ++i) place_[vertices[i]] = static_cast<Index>(i);
  }

  // How far each vertex has to go. Every iteration lowers the energy, so that what is not solved to
  // the end is no failure.
  bool solve(Eigen::MatrixX3d& way, Progress& progress) const {
    const Eigen::Index size = static_cast<Eigen::Index>(vertices_.size());
    Matrix matrix(size, size);
    Eigen::MatrixX3d residual(size, 3);
    assemble(matrix, residual);
    Index count = 0;
    std::vector<Index> aggregate_of = make_aggregates(count);
    Eigen::ConjugateGradient<Matrix, Eigen::Lower | Eigen::Upper, TwoLevelPreconditioner> solver;
    solver.preconditioner().prepare(matrix, std::move(aggregate_of), count, progress);
    if (solver.preconditioner().info() != Eigen::Success) return false;
    solver.setTolerance(kTolerance);
    solver.setMaxIterations(kMostIterations);
    solver.compute(matrix);
    way.resize(size, 3);
    for (int k = 0; k < 3; ++k) way.col(k) = solver.solve(residual.col(k));
    return way.allFinite();
  }

 private:
  double cotangent(Index h) const {
    const Vec3& apex = mesh_.position[mesh_.opposite(h)];
    const Vec3 a = mesh_.position[mesh_.origin(h)] - apex,
               b = mesh_.position[mesh_.target(h)] - apex;
    const double area = a.cross(b).norm();
    return area > 0.0 ? a.dot(b) / area : 0.0;
  }

  void assemble(Matrix& matrix, Eigen::MatrixX3d& residual) const {
    Entries entries;
    entries.reserve(7 * vertices_.size());
    residual.setZero();
    for (std::size_t i = 0; i < vertices_.size(); ++i) {
      const Index v = vertices_[i], row = static_cast<Index>(i);
      double sum = 0.0;
      mesh_.for_each_outgoing(v, [&](Index h) {
        const Index u = mesh_.target(h);
        const double weight = std::clamp(0.5 * (cotangent(h) + cotangent(mesh_.twin(h))),
                                         kLeastWeight, kGreatestWeight);
        sum += weight;
        residual.row(row) += weight * (mesh_.position[u] - mesh_.position[v]).transpose();
        if (place_[u] != kNone) entries.emplace_back(row, place_[u], -weight);
      });
      entries.emplace_back(row, row, sum);
    }
    matrix.setFromTriplets(entries.begin(), entries.end());
  }

  // Balls of neighbours, as far as they are not in another.
  std::vector<Index> make_aggregates(Index& count) const {
    std::vector<Index> aggregate_of(vertices_.size(), kNone);
    std::vector<Index> members;
    count = 0;
    for (std::size_t seed = 0; seed < vertices_.size(); ++seed) {
      if (aggregate_of[seed] != kNone) continue;
      aggregate_of[seed] = count;
      members = {static_cast<Index>(seed)};
      for (std::size_t i = 0; i < members.size() && members.size() < kAggregate; ++i)
        mesh_.for_each_outgoing(vertices_[members[i]], [&](Index h) {
          const Index place = place_[mesh_.target(h)];
          if (place == kNone || aggregate_of[place] != kNone) return;
          aggregate_of[place] = count;
          members.push_back(place);
        });
      ++count;
    }
    return aggregate_of;
  }

  const SurfaceMesh& mesh_;
  const std::vector<Index>& vertices_;
  std::vector<Index> place_;  // of a vertex among those that move; kNone for the others
};

}  // namespace

bool make_harmonic(SurfaceMesh& mesh, const std::vector<Index>& vertices, Progress& progress) {
  if (vertices.empty()) return true;
  Eigen::MatrixX3d way;
  if (!HarmonicSystem(mesh, vertices).solve(way, progress)) return false;
  for (std::size_t i = 0; i < vertices.size(); ++i)
    mesh.position[vertices[i]] += way.row(static_cast<Eigen::Index>(i)).transpose();
  return true;
}

}  // namespace shrinkwrap
