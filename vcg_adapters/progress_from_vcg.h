// The progress callback of vcglib and of MeshLab.
#pragma once

#include <wrap/callback.h>

#include "common/progress.h"

namespace shrinkwrap {

/// Calls `callback` with percents and the name of the stage; cancels if it returns false. A null
/// callback is fine.
inline Progress::Callback progress_from_vcg(vcg::CallBackPos* callback) {
  if (callback == nullptr) return {};
  return [callback](double fraction, const char* stage) {
    return callback(static_cast<int>(100.0 * fraction), stage);
  };
}

}  // namespace shrinkwrap
