#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "metropolis/mutators.h"

namespace vernier {
namespace {

constexpr double kNever = -std::numeric_limits<double>::infinity();

// The probability of deleting d of k surfaces: two most often, as one alone keeps both directions
// at its neighbours nearly as they were (Veach 1997, section 11.4.2.1).
double deletion_weight(size_t d) { return std::exp2(-std::abs(static_cast<double>(d) - 1.5)); }

double deletion_total(size_t k) {
  double sum = 0.0;
  for (size_t d = 0; d < k; ++d) {
    sum += deletion_weight(d);
  }
  return sum;
}

// ...of d in a given place.
double log_deletion(size_t k, size_t d) {
  return std::log(deletion_weight(d) / deletion_total(k) / static_cast<double>(k - d + 1));
}

// Numbers of surfaces that may come in the place of d, where at least `least` are needed.
struct Growth {
  static constexpr size_t kMore = 4;
  size_t first, last;

  Growth(size_t d, size_t least) : first(least), last(std::max(d + kMore, least)) {}
  static double weight(size_t d, size_t c) {
    return std::exp2(-std::abs(static_cast<double>(c) - static_cast<double>(d)));
  }
  double total(size_t d) const {
    double sum = 0.0;
    for (size_t c = first; c <= last; ++c) {
      sum += weight(d, c);
    }
    return sum;
  }
  double log_probability(size_t d, size_t c) const {
    return c >= first && c <= last ? std::log(weight(d, c) / total(d)) : kNever;
  }
};

template <class Weight>
size_t choose(double u, size_t first, size_t last, const Weight& weight) {
  for (size_t i = first; i < last; ++i) {
    u -= weight(i);
    if (u < 0.0) {
      return i;
    }
  }
  return last;
}

// Grows c surfaces between the first a and the last b of `from`, by technique number j of those
// that PathSpace::log_grown() has: j surfaces from the light, or, where none is kept there, j
// vertices.
bool grow(PathSpace& space, const PathState& from, size_t a, size_t b, size_t c, size_t j,
          PathState& to) {
  const size_t by_light = b > 0 ? j : (j > 0 ? j - 1 : 0);
  if (by_light > c || (a == 0 && c == 0 && b == 0)) {
    return false;
  }
  const size_t by_camera = c - by_light;
  to.v.assign(from.v.begin(), from.v.begin() + static_cast<ptrdiff_t>(a));
  to.raster = from.raster;
  to.pdf_across = from.pdf_across;
  to.end = from.end;
  for (size_t i = 0; i < by_camera; ++i) {
    const bool grown = to.v.empty() ? space.begin_at_lens(space.film.raster(space.random_2d()), to)
                                    : space.extend(to);
    if (!grown) {
      return false;
    }
  }
  // The light's side, from its end on.
  std::vector<ChainVertex> tail(from.v.end() - static_cast<ptrdiff_t>(b), from.v.end());
  std::reverse(tail.begin(), tail.end());
  for (size_t i = 0; i < by_light; ++i) {
    ChainVertex next;
    if (!(tail.empty() ? space.emit(next, to.end) : space.extend_from_light(tail.back(), next))) {
      return false;
    }
    tail.push_back(next);
  }
  const size_t joint = to.v.size();
  to.v.insert(to.v.end(), tail.rbegin(), tail.rend());
  if (tail.empty()) {
    return j == 0 ? space.meet_light(to, true) : space.join_light(to);
  }
  if (!(joint == 0 ? space.join_lens(to) : space.join(to, joint - 1))) {
    return false;
  }
  // A light that has been sampled anew, or sees another surface.
  return b > 0 || space.see_light(to);
}

}  // namespace

double mutate_bidirectionally(PathSpace& space, const PathState& from, PathState& to) {
  const size_t k = from.v.size();
  const size_t d =
      choose(static_cast<double>(space.random()) * deletion_total(k), 0, k - 1, deletion_weight);
  const size_t a =
      std::min(static_cast<size_t>(space.random() * static_cast<float>(k - d + 1)), k - d);
  const size_t b = k - d - a;
  const size_t least = space.least > a + b ? space.least - a - b : 0;
  const Growth there(d, least);
  const size_t c = choose(static_cast<double>(space.random()) * there.total(d), there.first,
                          there.last, [&](size_t i) { return Growth::weight(d, i); });
  if ((c == 0 && d == 0) || a + b + c > space.most) {
    return kNever;
  }
  const size_t techniques = b > 0 ? c + 1 : c + 2;
  const size_t j = std::min(static_cast<size_t>(space.random() * static_cast<float>(techniques)),
                            techniques - 1);
  if (!grow(space, from, a, b, c, j, to) || !space.evaluate(to)) {
    return kNever;
  }
  const double forth = log_deletion(k, d) + there.log_probability(d, c) + space.log_grown(to, a, b);
  const double back = log_deletion(to.v.size(), c) + Growth(c, least).log_probability(c, d) +
                      space.log_grown(from, a, b);
  return to.log_geometry - from.log_geometry + back - forth;
}

double propose_new_path(PathSpace& space, const PathState& from, PathState& to) {
  const int length = space.plan.lengths.sample(space.random());
  const auto c = static_cast<size_t>(length) - 2;
  const size_t j = std::min(static_cast<size_t>(space.random() * static_cast<float>(c + 2)), c + 1);
  if (!grow(space, from, 0, 0, c, j, to) || !space.evaluate(to)) {
    return kNever;
  }
  const auto log_density = [&](const PathState& path) {
    return std::log(space.plan.lengths.probability(static_cast<int>(path.v.size()) + 2)) +
           space.log_grown(path, 0, 0);
  };
  return to.log_geometry - from.log_geometry + log_density(from) - log_density(to);
}

}  // namespace vernier
