#include "cases.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

namespace shrinkwrap::robustness {
namespace {

using testing::Random;
using testing::SamplingDomain;

constexpr double kLeastFeature = 3.0;        // x spacing
constexpr double kLeastRandomFeature = 4.0;  // of samples that leave gaps
constexpr double kMostDisplacement = 0.1;    // x spacing
constexpr Index kFewestSamples = 200;
constexpr double kFarStray = 4.0;      // x spacing where the samples are farthest apart
constexpr Index kDrawnForDetail = 4;   // x the samples aimed at, as most are then left out
constexpr double kLineDistance = 3.0;  // of scan lines, x distance of samples within a line

template <class Value, std::size_t size>
Value one_of(const Value (&values)[size], Random& random) {
  return values[random.below(static_cast<Index>(size))];
}

double area_of(const Solid& solid, Random& random) {
  return testing::sample_implicit(solid.implicit, solid.domain, 500, random).area;
}

bool is_kept(const SamplingDomain& domain, const Vec3& p) {
  return !domain.keep || domain.keep(p);
}

// Moves the samples onto planes z = const, along the surface. Those that do not arrive are left
// out.
std::vector<Vec3> on_scan_lines(const Solid& solid, const std::vector<Vec3>& samples,
                                double distance) {
  std::vector<Vec3> moved;
  for (Vec3 p : samples) {
    p.z() = distance * (std::floor(p.z() / distance) + 0.5);
    double value = solid.implicit(p);
    for (int step = 0; step < 20 && std::abs(value) > 1e-9; ++step) {
      Vec3 direction = testing::outward_normal(solid.implicit, p);
      direction.z() = 0.0;
      const double slope = direction.norm();
      if (slope < 0.2) break;
      p -= value / slope * (direction / slope);
      value = solid.implicit(p);
    }
    if (std::abs(value) <= 1e-9 && is_kept(solid.domain, p)) moved.push_back(p);
  }
  // As a scanner delivers them: line by line.
  std::sort(moved.begin(), moved.end(), [](const Vec3& a, const Vec3& b) {
    return a.z() != b.z() ? a.z() < b.z() : std::atan2(a.y(), a.x()) < std::atan2(b.y(), b.x());
  });
  return moved;
}

// Where a line along an axis enters and leaves.
void add_crossings(const Solid& solid, Vec3 p, int axis, std::vector<Vec3>& crossings) {
  const double end = solid.radius, least_step = 2e-3 * solid.radius;
  p[axis] = -end;
  double value = solid.implicit(p);
  while (p[axis] < end) {
    Vec3 next = p;
    next[axis] += std::max(std::abs(value), least_step);
    const double next_value = solid.implicit(next);
    if ((value < 0.0) != (next_value < 0.0)) {
      double low = p[axis], high = next[axis];
      Vec3 q = p;
      for (int i = 0; i < 45; ++i) {
        q[axis] = 0.5 * (low + high);
        ((solid.implicit(q) < 0.0) == (value < 0.0) ? low : high) = q[axis];
      }
      if (is_kept(solid.domain, q)) crossings.push_back(q);
    }
    p = next;
    value = next_value;
  }
}

std::vector<Vec3> on_grid(const Solid& solid, double distance) {
  std::vector<Vec3> crossings;
  const int lines = static_cast<int>(std::ceil(solid.radius / distance));
  for (int axis = 0; axis < 3; ++axis)
    for (int i = -lines; i <= lines; ++i)
      for (int j = -lines; j <= lines; ++j) {
        Vec3 p = Vec3::Zero();
        // Half a cell off, so that no line runs within a face or through an edge of a shape.
        p[(axis + 1) % 3] = (i + 0.5) * distance;
        p[(axis + 2) % 3] = (j + 0.5) * distance;
        add_crossings(solid, p, axis, crossings);
      }
  return crossings;
}

std::vector<Vec3> sample(const Case& generated, const Solid& solid, Index count, double spacing,
                         Random& random) {
  if (generated.sampling == Sampling::blue_noise)
    return testing::sample_implicit_blue_noise(solid.implicit, solid.domain, count, random).points;
  // A line of a cubic grid of unit distance meets a surface 1.5 times per unit area.
  if (generated.sampling == Sampling::grid) return on_grid(solid, spacing * std::sqrt(1.5));
  std::vector<Vec3> samples =
      testing::sample_implicit(solid.implicit, solid.domain, count, random).points;
  if (generated.sampling == Sampling::scan_lines)
    return on_scan_lines(solid, samples, spacing * std::sqrt(kLineDistance));
  return samples;
}

// Thins the samples out from one side to the other, exponentially.
std::vector<Vec3> with_density_ratio(const std::vector<Vec3>& samples, double ratio, double radius,
                                     Random& random) {
  std::vector<Vec3> kept;
  for (const Vec3& p : samples) {
    const double along = std::clamp(0.5 + 0.5 * p.x() / radius, 0.0, 1.0);
    if (random.uniform() < std::pow(ratio, -along)) kept.push_back(p);
  }
  return kept;
}

// Keeps all samples in a ball about one of them, and thins the others out: a detail that was
// scanned more closely than the rest.
std::vector<Vec3> with_detail(const std::vector<Vec3>& samples, double ratio, double radius,
                              Random& random) {
  if (samples.empty()) return samples;
  const Vec3 centre = samples[random.below(static_cast<Index>(samples.size()))];
  const double reach = random.uniform(0.15, 0.5) * radius;
  std::vector<Vec3> kept;
  for (const Vec3& p : samples)
    if ((p - centre).norm() < reach || random.uniform() < 1.0 / ratio) kept.push_back(p);
  return kept;
}

// Share of the samples that survives, were they uniform along x.
double mean_density(double ratio) {
  return ratio > 1.0 ? (1.0 - 1.0 / ratio) / std::log(ratio) : 1.0;
}

void quantise(std::vector<Vec3>& points, double quantum) {
  for (Vec3& p : points)
    for (int axis = 0; axis < 3; ++axis) p[axis] = quantum * std::round(p[axis] / quantum);
}

// Those of `strays` that no sample is nearer to than `distance`; of several at one place the first.
std::vector<Index> far_from_samples(const std::vector<Vec3>& points,
                                    const std::vector<Index>& strays, double distance) {
  std::vector<Vec3> samples;
  for (std::size_t i = 0; i < points.size(); ++i)
    if (!std::binary_search(strays.begin(), strays.end(), static_cast<Index>(i)))
      samples.push_back(points[i]);
  std::vector<Index> far;
  for (const Index stray : strays) {
    const Vec3& p = points[static_cast<std::size_t>(stray)];
    const auto is_near = [&](const Vec3& sample) { return (sample - p).norm() < distance; };
    const auto is_here = [&](Index other) { return points[static_cast<std::size_t>(other)] == p; };
    if (std::none_of(samples.begin(), samples.end(), is_near) &&
        std::none_of(far.begin(), far.end(), is_here))
      far.push_back(stray);
  }
  return far;
}

// Of the samples where they are farthest from each other. `kept`: the share of them that was left
// when all but a detail was thinned out.
double widest_spacing(const Case& generated, double mean_spacing, double kept) {
  double spacing = mean_spacing * std::sqrt(generated.density_ratio) *
                   std::sqrt(mean_density(generated.density_ratio)) *
                   std::sqrt(generated.detail_ratio * kept);
  if (generated.sampling == Sampling::scan_lines) spacing *= std::sqrt(kLineDistance);
  return spacing;
}

bool is_resolved(const Case& generated, const Solid& solid, Index samples, double mean_spacing,
                 double widest, double rounding) {
  const bool misses_parts =
      generated.sampling == Sampling::scan_lines && (solid.has_level_faces || solid.has_limbs);
  if (misses_parts || samples < kFewestSamples) return false;
  if (generated.variant == Variant::every_sample && generated.outliers > 0.0) return false;
  if (generated.variant == Variant::genus_zero && solid.genus > 0) return false;
  const bool even =
      generated.sampling == Sampling::blue_noise || generated.sampling == Sampling::grid;
  const double displacement = generated.noise + 0.3 * generated.quantum + rounding / mean_spacing;
  return displacement <= kMostDisplacement &&
         solid.least_feature >= (even ? kLeastFeature : kLeastRandomFeature) * widest;
}

}  // namespace

const char* sampling_name(Sampling sampling) {
  static constexpr const char* names[] = {"random", "blue_noise", "scan_lines", "quantised",
                                          "grid"};
  return names[static_cast<int>(sampling)];
}

const char* variant_name(Variant variant) {
  static constexpr const char* names[] = {
      "standard",        "leave_open",          "stop_at_surface",
      "as_in_the_paper", "stop_and_leave_open", "automatic_openings",
      "genus_zero",      "every_sample",        "keep_stages"};
  return names[static_cast<int>(variant)];
}

Case case_of(std::uint64_t number) {
  Random random(number);
  Case made;
  made.number = number;
  made.solid = static_cast<SolidKind>(random.below(kSolidCount));
  made.drawn_thickness = random.uniform();
  made.sampling = static_cast<Sampling>(random.below(kSamplingCount));
  const auto now_and_then = [&](double share) { return random.uniform() < share; };
  // Mostly few, which is quick and as hard.
  const double size = random.uniform();
  made.count = now_and_then(0.1) ? 4 + random.below(496)
                                 : static_cast<Index>(500.0 * std::pow(10.0, size * size));
  if (made.sampling == Sampling::quantised) made.quantum = one_of({0.02, 0.1, 0.25, 1.0}, random);
  // Half of the clouds are clean, and most of the others have but one or two defects.
  if (now_and_then(0.5)) {
    if (now_and_then(0.5)) made.noise = one_of({0.02, 0.1, 0.25, 0.5, 1.0}, random);
    if (now_and_then(0.4)) made.density_ratio = one_of({3.0, 10.0, 100.0}, random);
    if (now_and_then(0.3)) made.outliers = one_of({0.001, 0.005, 0.05}, random);
  }
  made.rotated = now_and_then(0.5);
  if (now_and_then(0.4)) made.scale_exponent = static_cast<int>(random.below(25)) - 12;
  if (now_and_then(0.3))
    // The second: an object of 100 m in a national grid.
    made.offset =
        one_of({Vec3(1.0, -2.0, 0.5), Vec3(5e3, 5.4e4, 3.0), Vec3(1e8, 0.0, -1e9)}, random);
  // Single precision would leave nothing of an object that lies a billion times its size away.
  made.single_precision = now_and_then(0.5) && made.offset.norm() < 1e6;
  if (now_and_then(0.3)) made.variant = static_cast<Variant>(1 + random.below(kVariantCount - 1));
  if (now_and_then(0.1)) made.detail_ratio = one_of({10.0, 100.0}, random);
  made.clustered = made.outliers > 0.0 && made.outliers < 0.01 && now_and_then(0.5);
  return made;
}

ReconstructionOptions options_of(const Case& generated) {
  ReconstructionOptions options;
  if (generated.variant == Variant::as_in_the_paper) options = as_in_the_paper();
  if (generated.variant == Variant::leave_open || generated.variant == Variant::stop_and_leave_open)
    options.complete_matching.openings = CompleteMatchingOptions::Openings::leave_open;
  options.stop_at_parametric_surface = generated.variant == Variant::stop_at_surface ||
                                       generated.variant == Variant::stop_and_leave_open;
  if (generated.variant == Variant::automatic_openings)
    options.complete_matching.openings = CompleteMatchingOptions::Openings::automatic;
  if (generated.variant == Variant::genus_zero) options.initial_mesh.maximum_genus = 0;
  options.outliers.exclude = generated.variant != Variant::every_sample;
  options.keep_stages = generated.variant == Variant::keep_stages;
  options.host_scalar =
      generated.single_precision ? HostScalar::single_precision : HostScalar::double_precision;
  return options;
}

CaseCloud cloud_of(const Case& generated) {
  Random random(~generated.number);
  const Solid solid = solid_of(generated.solid, generated.drawn_thickness);
  const double area = area_of(solid, random);
  const double spacing = std::sqrt(area / generated.count);

  const double density = mean_density(generated.density_ratio);
  auto drawn = static_cast<Index>(std::ceil(generated.count / density));
  if (generated.detail_ratio > 1.0) drawn *= kDrawnForDetail;
  std::vector<Vec3> points = sample(generated, solid, drawn, std::sqrt(area / drawn), random);
  if (generated.density_ratio > 1.0)
    points = with_density_ratio(points, generated.density_ratio, solid.radius, random);
  double kept = 1.0;
  if (generated.detail_ratio > 1.0) {
    const auto before = static_cast<double>(points.size());
    points = with_detail(points, generated.detail_ratio, solid.radius, random);
    kept = static_cast<double>(points.size()) / std::max(before, 1.0);
  }

  CaseCloud cloud;
  // Fewer together than make a body, even if two such clusters meet.
  const std::size_t together =
      generated.clustered ? std::clamp<std::size_t>(points.size() / 400, 2, 14) : 1;
  Vec3 centre = Vec3::Zero();
  std::vector<Index>& strays = cloud.expectation.strays;
  for (std::size_t i = 0; i < points.size(); ++i) {
    Vec3& p = points[i];
    if (random.uniform() < generated.outliers) {
      if (strays.size() % together == 0) centre = 1.5 * solid.radius * random.in_cube();
      p = centre;
      if (together > 1) p += spacing * random.in_cube();
      strays.push_back(static_cast<Index>(i));
    }
    for (int axis = 0; axis < 3; ++axis) p[axis] += generated.noise * spacing * random.gaussian();
  }
  if (generated.quantum > 0.0) quantise(points, generated.quantum * spacing);

  const Eigen::Matrix3d rotation = Eigen::Quaterniond(random.uniform(), random.uniform(),
                                                      random.uniform(), 0.1 + random.uniform())
                                       .normalized()
                                       .toRotationMatrix();
  const double scale = std::pow(10.0, generated.scale_exponent);
  double largest = 0.0;
  for (Vec3& p : points) {
    if (generated.rotated) p = rotation * p;
    p = scale * (p + generated.offset);
    if (generated.single_precision) p = rounded_to_single(p);
    largest = std::max(largest, p.cwiseAbs().maxCoeff());
  }

  const double rounding = largest / scale * (generated.single_precision ? 0x1p-24 : 0x1p-53);
  const double mean_spacing = std::sqrt(area / std::max(1.0, static_cast<double>(points.size())));
  const double widest = widest_spacing(generated, mean_spacing, kept);
  cloud.least_feature = solid.least_feature / widest;
  cloud.expectation.far_strays = far_from_samples(points, strays, kFarStray * scale * widest);
  // The paper's start is a box, of genus 0, and cannot enter a cavity: nothing can be expected.
  cloud.expectation.resolved = generated.variant != Variant::as_in_the_paper &&
                               is_resolved(generated, solid, static_cast<Index>(points.size()),
                                           mean_spacing, widest, rounding);
  // Where the surface is level the lines leave openings.
  cloud.expectation.open = !solid.closed || generated.sampling == Sampling::scan_lines;
  cloud.expectation.genus = solid.genus;
  cloud.expectation.components = solid.components;
  cloud.points = std::move(points);
  return cloud;
}

benchmarking::JsonLine describe(const Case& generated) {
  return benchmarking::JsonLine()
      .add("case", generated.number)
      .add("solid", solid_of(generated.solid, generated.drawn_thickness).name)
      .add("sampling", sampling_name(generated.sampling))
      .add("variant", variant_name(generated.variant))
      .add("count", generated.count)
      .add("quantum", generated.quantum)
      .add("noise", generated.noise)
      .add("density_ratio", generated.density_ratio)
      .add("detail_ratio", generated.detail_ratio)
      .add("outliers", generated.outliers)
      .add("clustered", generated.clustered)
      .add("rotated", generated.rotated)
      .add("scale_exponent", generated.scale_exponent)
      .add("offset", generated.offset.cwiseAbs().maxCoeff())
      .add("single_precision", generated.single_precision);
}

}  // namespace shrinkwrap::robustness
