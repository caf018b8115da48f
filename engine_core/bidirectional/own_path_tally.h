// How many samples should have a light path of their own.
#pragma once

#include <vector>

#include "bidirectional/coarse_picture.h"
#include "bidirectional/technique_set.h"

namespace vernier {

// Notes what the light paths of a pilot's samples cost and what noise their light has, beside the
// camera's paths.
class OwnPathTally {
 public:
  explicit OwnPathTally(const FilmDesc& film) : picture_(film) {}

  void traced_light(uint64_t rays) { light_rays_ += rays; }
  void found(const FoundPath& path) {
    const float amount = max_component(path.contribution);
    if (path.t == 1) {
      const uint32_t pixel = picture_.pixel(path.raster);
      picture_.add(pixel, amount);
      splats_.push_back({amount, pixel});
    } else {
      (path.s >= 2 ? joined_ : met_) += amount;
    }
  }
  // The sample whose paths were found is done.
  void sampled(Vec2f raster) {
    const uint32_t pixel = picture_.pixel(raster);
    picture_.add(pixel, met_ + joined_);
    picture_.count_sample();
    samples_.push_back({met_, joined_, pixel});
    met_ = joined_ = 0.0f;
  }
  void add(const OwnPathTally& other);

  // The part of the samples that should have one, of `rays` that all took: see own_path_tally.cpp.
  // `shared`: they are not what camera vertices are joined to.
  double part(uint64_t rays, bool shared) const;

  const CoarsePicture& picture() const { return picture_; }

 private:
  struct Splat {
    float amount;
    uint32_t pixel;
  };
  struct Sample {
    float met, joined;  // by the camera's path alone, and by joins
    uint32_t pixel;
  };

  CoarsePicture picture_;
  std::vector<Splat> splats_;
  std::vector<Sample> samples_;
  float met_ = 0.0f, joined_ = 0.0f;
  uint64_t light_rays_ = 0;
};

}  // namespace vernier
