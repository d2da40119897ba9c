// The matrix of the sparse system of signs, of which Eigen's solvers know but the product.
#pragma once

#include <Eigen/IterativeLinearSolvers>
#include <Eigen/SparseCore>
#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "common/progress.h"
#include "common/types.h"

namespace shrinkwrap {
class SignMatrix;
}

template <>
struct Eigen::internal::traits<shrinkwrap::SignMatrix>
    : Eigen::internal::traits<Eigen::SparseMatrix<double>> {};

namespace shrinkwrap {

/// An edge between two unknowns; its weight is negative where their signs are to be opposed.
struct SignEdge {
  Index a, b;
  float weight;
};

/// Symmetric, positive definite: of each edge |w| at both places of the diagonal and -w beside it,
/// and what else is added to the diagonal. Kept as edges, in a third of the memory that it takes to
/// assemble a sparse matrix.
class SignMatrix : public Eigen::EigenBase<SignMatrix> {
 public:
  using Scalar = double;
  using RealScalar = double;
  using StorageIndex = Index;
  enum {
    ColsAtCompileTime = Eigen::Dynamic,
    MaxColsAtCompileTime = Eigen::Dynamic,
    IsRowMajor = false
  };

  /// `diagonal`: what is added to it, positive.
  SignMatrix(std::vector<SignEdge> edges, Eigen::VectorXd diagonal)
      : edges_(std::move(edges)), diagonal_(std::move(diagonal)) {
    for (const SignEdge& edge : edges_)
      for (const Index end : {edge.a, edge.b}) diagonal_[end] += std::abs(edge.weight);
  }

  Eigen::Index rows() const { return diagonal_.size(); }
  Eigen::Index cols() const { return diagonal_.size(); }
  const Eigen::VectorXd& diagonal() const { return diagonal_; }

  template <class Vector>
  Eigen::Product<SignMatrix, Vector, Eigen::AliasFreeProduct> operator*(
      const Eigen::MatrixBase<Vector>& x) const {
    return {*this, x.derived()};
  }
  /// result += scale * this * x.
  template <class Result, class Vector>
  void add_product(const Vector& x, double scale, Result& result) const {
    result.array() += scale * diagonal_.array() * x.array();
    for (const auto& [a, b, weight] : edges_) {
      const double factor = scale * weight;
      result[a] -= factor * x[b];
      result[b] -= factor * x[a];
    }
  }

 private:
  std::vector<SignEdge> edges_;
  Eigen::VectorXd diagonal_;
};

/// Jacobi's, which is asked at every iteration and so tells of progress.
class SignPreconditioner {
 public:
  void watch(Progress& progress, int most_iterations) {
    progress_ = &progress;
    most_iterations_ = most_iterations;
  }
  // The rest is what Eigen asks of a preconditioner.
  SignPreconditioner& compute(const SignMatrix& matrix) {
    inverse_diagonal_ = matrix.diagonal().cwiseInverse();
    return *this;
  }
  template <class Vector>
  Eigen::VectorXd solve(const Vector& residual) const {
    if (progress_)
      progress_->update(std::min(1.0, static_cast<double>(++iterations_) / most_iterations_));
    return inverse_diagonal_.cwiseProduct(residual);
  }
  Eigen::ComputationInfo info() const { return Eigen::Success; }

 private:
  Eigen::VectorXd inverse_diagonal_;
  Progress* progress_ = nullptr;
  int most_iterations_ = 1;
  mutable int iterations_ = 0;
};

}  // namespace shrinkwrap

template <class Vector>
struct Eigen::internal::generic_product_impl<shrinkwrap::SignMatrix, Vector, Eigen::SparseShape,
                                             Eigen::DenseShape, Eigen::GemvProduct>
    : Eigen::internal::generic_product_impl_base<
          shrinkwrap::SignMatrix, Vector,
          Eigen::internal::generic_product_impl<shrinkwrap::SignMatrix, Vector>> {
  using Scalar = double;
  template <class Result>
  static void scaleAndAddTo(Result& result, const shrinkwrap::SignMatrix& matrix, const Vector& x,
                            const Scalar& scale) {
    matrix.add_product(x, scale, result);
  }
};
