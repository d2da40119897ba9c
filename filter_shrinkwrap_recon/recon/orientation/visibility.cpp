#include "orientation/visibility.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

#include "common/parallel.h"

namespace shrinkwrap {
namespace {

constexpr int kDirectionsAtOnce = 8;       // depth buffers and votes that are held at a time ...
constexpr double kPixelsHeld = 32.0;       // ... of no more pixels per sample than this, in all
constexpr double kPixelsPerSample = 16.0;  // of one, at most
constexpr double kSeenOpenly = 0.25;       // part of the views on one side
// Mean closedness up to which samples are of an open sheet, and from which on they are of a body.
constexpr double kSheet = 0.3, kBody = 0.6;
constexpr float kAlong = 0.8f;  // cosine of the normals of sheets along each other
constexpr float kNothing = -std::numeric_limits<float>::infinity();

// Directions spread evenly over the sphere along a spiral (the golden angle between neighbours).
Vec3 view_direction(int index, int count) {
  constexpr double kGoldenAngle = 2.399963229728653;
  const double z = 1.0 - (2.0 * index + 1.0) / count;
  const double radius = std::sqrt(std::max(0.0, 1.0 - z * z));
  return {radius * std::cos(index * kGoldenAngle), radius * std::sin(index * kGoldenAngle), z};
}

std::vector<Vec3f> view_directions(const VisibilityOptions& options) {
  std::vector<Vec3f> directions;
  for (int i = 0; i < options.directions; ++i) {
    const Vec3 direction = view_direction(i, options.directions);
    if (direction.dot(options.front) >= 0.0) directions.push_back(direction.cast<float>());
  }
  return directions;
}

// An orthographic depth buffer looking along -direction; larger depth is nearer to the viewer.
class DepthBuffer {
 public:
  struct Pixel {
    std::int32_t x, y;
    float depth;
  };

  // Projects and draws the points. `pixels` receives where each fell.
  void draw(const std::vector<Vec3f>& points, const Vec3f& direction, float pixel,
            std::vector<Pixel>& pixels) {
    const Vec3f helper = std::abs(direction.x()) < 0.9f ? Vec3f::UnitX() : Vec3f::UnitY();
    const Vec3f right = helper.cross(direction).normalized();
    const Vec3f up = direction.cross(right);
    float low_x = std::numeric_limits<float>::infinity(), low_y = low_x;
    float high_x = -low_x, high_y = -low_x;
    for (const Vec3f& p : points) {
      const float x = p.dot(right), y = p.dot(up);
      low_x = std::min(low_x, x);
      high_x = std::max(high_x, x);
      low_y = std::min(low_y, y);
      high_y = std::max(high_y, y);
    }
    const float per_length = 1.0f / pixel;
    width_ = static_cast<std::int32_t>((high_x - low_x) * per_length) + 3;
    const std::int32_t height = static_cast<std::int32_t>((high_y - low_y) * per_length) + 3;
    depth_.assign(static_cast<std::size_t>(width_) * static_cast<std::size_t>(height), kNothing);
    foremost_.resize(depth_.size());
    pixels.resize(points.size());
    for (std::size_t i = 0; i < points.size(); ++i) {
      const Vec3f& p = points[i];
      const Pixel at{static_cast<std::int32_t>((p.dot(right) - low_x) * per_length) + 1,
                     static_cast<std::int32_t>((p.dot(up) - low_y) * per_length) + 1,
                     p.dot(direction)};
      pixels[i] = at;
      for (std::int32_t y = at.y - 1; y <= at.y + 1; ++y) {
        const std::size_t first = static_cast<std::size_t>(y) * width_ + at.x - 1;
        for (std::size_t k = first; k < first + 3; ++k) {
          if (!(at.depth > depth_[k])) continue;
          depth_[k] = at.depth;
          foremost_[k] = static_cast<Index>(i);
        }
      }
    }
  }

  // Of the points.
  Index foremost(const Pixel& at) const {
    return foremost_[static_cast<std::size_t>(at.y) * width_ + at.x];
  }

 private:
  std::int32_t width_ = 0;
  std::vector<float> depth_;
  std::vector<Index> foremost_;
};

double diagonal_of(const std::vector<Vec3f>& points) {
  Vec3f low = points[0], high = points[0];
  for (const Vec3f& p : points) {
    low = low.cwiseMin(p);
    high = high.cwiseMax(p);
  }
  return (high - low).norm();
}

// The smallest pixel for which no buffer has more than a fixed number of pixels per sample.
double affordable_pixel(double diagonal, std::size_t samples, double pixel) {
  const double pixels = 1e4 + kPixelsPerSample * static_cast<double>(samples);
  return std::max({pixel, diagonal / std::sqrt(pixels), 1e-6});
}

// How many of its buffers to hold at a time.
int directions_at_once(double diagonal, std::size_t samples, double pixel) {
  const double pixels = (diagonal / pixel) * (diagonal / pixel);
  const double most = (8e4 + kPixelsHeld * static_cast<double>(samples)) / pixels;
  return static_cast<int>(std::clamp<double>(most, 1.0, kDirectionsAtOnce));
}

// The views in front of a sample and behind it: half of those possible each, from all around.
VisibilityVote vote_of(double possible, double in_front, double behind, double foremost) {
  const double more = std::max(in_front, behind), less = std::min(in_front, behind);
  if (more <= 0.0) return {possible, 0.0, 0.0, possible};
  const double unlike = 1.0 - less / more;
  return {possible, more + less, (in_front - behind) * unlike * unlike,
          possible * std::max(0.0, 1.0 - 2.0 * less / (kSeenOpenly * possible)), foremost};
}

// Whether a sample, such a `way` before another, is of another sheet, along that of this one. From
// sample to sample of one sheet, however it bends, the way is square to the mean of their normals.
bool is_wall(const Vec3f& way, const Vec3f& normal, const Vec3f& foremost, float tolerance) {
  const float cosine = normal.dot(foremost);
  if (!(std::abs(cosine) > kAlong)) return false;
  const Vec3f sum = cosine > 0.0f ? Vec3f(normal + foremost) : Vec3f(normal - foremost);
  return std::abs(sum.dot(way)) > tolerance * sum.norm();
}

}  // namespace

double VisibilityVote::trust() const {
  const double closedness = possible > 0.0 ? closed / possible : 0.0;
  return std::clamp((closedness - kSheet) / (kBody - kSheet), 0.0, 1.0);
}

std::vector<VisibilityVote> visibility_votes(const PointCloud& cloud,
                                             const std::vector<Index>& drawn,
                                             const VisibilityOptions& options, Progress& progress,
                                             const std::vector<Index>* component_of_sample) {
  if (drawn.empty()) return {};
  std::vector<Vec3f> points;
  std::vector<Index> component;  // of each point, if they count
  points.reserve(drawn.size());
  for (Index sample : drawn) {
    points.push_back(cloud.position[sample].cast<float>());
    if (component_of_sample) component.push_back((*component_of_sample)[sample]);
  }
  const double diagonal = diagonal_of(points);
  const float pixel = static_cast<float>(affordable_pixel(diagonal, points.size(), options.pixel));
  const int at_once = directions_at_once(diagonal, points.size(), pixel);
  const float tolerance = static_cast<float>(options.depth_tolerance);
  const float min_cosine = static_cast<float>(options.min_cosine);

  // One view at a time per block; votes of a batch of views are kept apart and summed in order.
  struct View {
    DepthBuffer buffer;
    std::vector<DepthBuffer::Pixel> pixels;
    std::vector<float> cosine;  // of each sample drawn: 0 no vote
    std::vector<char> seen, foremost;
  };
  std::vector<View> views(static_cast<std::size_t>(at_once));
  const std::vector<Vec3f> directions = view_directions(options);
  const int direction_count = static_cast<int>(directions.size());
  struct Sums {
    double possible = 0.0, in_front = 0.0, behind = 0.0, foremost = 0.0;
  };
  std::vector<Sums> sums(drawn.size());
  Progress silent;
  for (int first = 0; first < direction_count; first += at_once) {
    const int count = std::min(at_once, direction_count - first);
    parallel_for_each(count, 1, silent, [&](Index v) {
      View& view = views[v];
      const Vec3f& direction = directions[first + v];
      view.buffer.draw(points, direction, pixel, view.pixels);
      view.cosine.assign(points.size(), 0.0f);
      view.seen.assign(points.size(), 0);
      view.foremost.assign(points.size(), 0);
      for (std::size_t i = 0; i < points.size(); ++i) {
        const float cosine = cloud.normal[drawn[i]].dot(direction);
        if (std::abs(cosine) < min_cosine) continue;
        const Index foremost = view.buffer.foremost(view.pixels[i]);
        const Vec3f way = points[foremost] - points[i];
        // Across the splat, 1.5 pixels to the middle of its diagonal, the surface itself rises.
        const float slope = std::sqrt(std::max(0.0f, 1.0f - cosine * cosine)) / std::abs(cosine);
        const bool is_near = way.dot(direction) < 2.1f * slope * pixel + tolerance;
        view.cosine[i] = cosine;
        view.seen[i] = is_near && !is_wall(way, cloud.normal[drawn[i]],
                                           cloud.normal[drawn[foremost]], tolerance);
        view.foremost[i] =
            view.seen[i] && (component.empty() || component[foremost] == component[i]);
      }
    });
    for (int v = 0; v < count; ++v)
      for (std::size_t i = 0; i < points.size(); ++i) {
        const double cosine = views[v].cosine[i];
        sums[i].possible += std::abs(cosine);
        if (views[v].seen[i])
          (cosine > 0.0 ? sums[i].in_front : sums[i].behind) += std::abs(cosine);
        if (views[v].foremost[i]) sums[i].foremost += std::abs(cosine);
      }
    progress.update(static_cast<double>(first + count) / direction_count);
  }
  std::vector<VisibilityVote> votes;
  votes.reserve(sums.size());
  for (const Sums& of : sums)
    votes.push_back(vote_of(of.possible, of.in_front, of.behind, of.foremost));
  return votes;
}

}  // namespace shrinkwrap
