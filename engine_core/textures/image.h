// Images as textures: storage, decoding and the four ways to leave the unit square.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "math/lanes.h"
#include "math/vec.h"
#include "scene/description.h"

namespace vernier {

enum class Interpolation : uint8_t { kLinear, kClosest, kCubic };
enum class Extension : uint8_t { kRepeat, kExtend, kClip, kMirror };

// Pixels of an image, owned. Bytes stay bytes; they are decoded as they are read.
class ImageTexture {
 public:
  // Throws std::invalid_argument naming the image when its pixels do not fill width x height x
  // channels. Width or height 0: a missing image.
  explicit ImageTexture(const ImageDesc& desc);

  bool missing() const { return width_ == 0; }
  int width() const { return width_; }
  int height() const { return height_; }
  const std::string& name() const { return name_; }
  AlphaMode alpha_mode() const { return alpha_; }
  bool has_alpha() const { return channels_ == 4 && alpha_ != AlphaMode::kNone; }

  // Scene-linear RGBA at (u, v), (0, 0) the lower left corner of the image. As in Cycles, colours
  // are associated with alpha and interpolated as they are encoded; `straight` divides the colour
  // by alpha afterwards. A missing image is opaque magenta everywhere; outside a clipped one it is
  // transparent black.
  Vec4f sample(float u, float v, Interpolation interpolation, Extension extension,
               bool straight = false) const;
  // Scene-linear RGBA of one pixel, colour associated with alpha; x in [0, width), y in
  // [0, height), row 0 at the bottom.
  Vec4f texel(int x, int y) const;
  // Average colour over all pixels.
  Color average() const;

  // Bytes of memory that the pixels take.
  size_t size_bytes() const { return bytes_.size() + floats_.size() * sizeof(float); }

 private:
  Floats4 encoded(int x, int y) const;
  Floats4 encoded_or_clear(int x, int y) const;
  Floats4 interpolate_linear(float x, float y, Extension extension) const;
  Floats4 interpolate_cubic(float x, float y, Extension extension) const;
  Vec4f decoded(Vec4f color) const;
  std::string name_;
  int width_ = 0, height_ = 0, channels_ = 0;
  ImageEncoding encoding_ = ImageEncoding::kLinear;
  AlphaMode alpha_ = AlphaMode::kStraight;
  std::vector<uint8_t> bytes_;
  std::vector<float> floats_;
};

}  // namespace vernier
