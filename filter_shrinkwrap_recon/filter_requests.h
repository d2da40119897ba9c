// What the values of a filter's parameters mean to the algorithm. No Qt, no host types.
#pragma once

#include "filter_parameters.h"
#include "reconstruct.h"

namespace shrinkwrap {

/// What the values of a filter's parameters ask for.
struct FilterRequest {
  ReconstructionOptions options;
  bool selected_only = false;
  bool fail_if_incomplete = false;  ///< matching_report: an incomplete matching is an error
  /// Fill in `ResultMesh::data_index` too: set by the host if the samples carry anything.
  bool carries_data = false;
};

/// Translates values to options. Throws InvalidInput, naming the parameter and its range, if a
/// value is missing, out of range or no number.
FilterRequest request_of(Filter filter, const ParameterValues& values);

}  // namespace shrinkwrap
