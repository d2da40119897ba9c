// Degenerate and hostile clouds, by name.
#pragma once

#include <string>
#include <vector>

#include "attempt.h"
#include "common/types.h"

namespace shrinkwrap::robustness {

struct Exhibit {
  std::string name;
  std::vector<Vec3> points;
  Expectation expectation;
};

/// All of them; what is random in them follows from the seed.
std::vector<Exhibit> gallery(unsigned seed);

}  // namespace shrinkwrap::robustness
