// Signs that are never wrong: orientation tests on double coordinates, filtered, exact when in doubt (CGAL).
#pragma once

#include "types.h"

namespace shrinkwrap {

/// +1 if d lies on the side of the plane abc from which a, b, c appear counter-clockwise, -1 on the other, 0 on it.
int orientation_sign(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d);

}  // namespace shrinkwrap
