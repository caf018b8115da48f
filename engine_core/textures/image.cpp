#include "textures/image.h"

#include <array>
#include <bit>
#include <cstring>
#include <stdexcept>

#include "textures/srgb.h"

namespace vernier {
namespace {

constexpr Vec4f kMissing{1.0f, 0.0f, 1.0f, 1.0f};

int wrap_repeat(int x, int size) {
  const int r = x % size;
  return r < 0 ? r + size : r;
}

int wrap_mirror(int x, int size) {
  const int m = wrap_repeat(x, 2 * size);
  return m >= size ? 2 * size - m - 1 : m;
}

// A pixel index inside the image. Clipping leaves indices as they are: readers test them.
int wrap(int x, int size, Extension extension) {
  if (x >= 0 && x < size) {
    return x;
  }
  switch (extension) {
    case Extension::kRepeat:
      return wrap_repeat(x, size);
    case Extension::kExtend:
      return std::min(std::max(x, 0), size - 1);
    case Extension::kMirror:
      return wrap_mirror(x, size);
    case Extension::kClip:
      break;
  }
  return x;
}

// A pixel coordinate taken apart. The integer is kept where its neighbours still fit an int.
struct PixelCoordinate {
  int index;
  float fraction;

  explicit PixelCoordinate(float x)
      : index(static_cast<int>(clamp(std::floor(x), -1e9f, 1e9f))), fraction(x - std::floor(x)) {}
};

// Product of two bytes that stand for [0, 1], rounded down as in Cycles.
uint8_t multiply_bytes(uint8_t a, uint8_t b) {
  return static_cast<uint8_t>(static_cast<unsigned>(a) * b / 255u);
}

// Coordinates that are no numbers read the image's corner.
float finite_or_zero(float x) { return std::isfinite(x) ? x : 0.0f; }

// Weights of the uniform cubic B-spline for the four pixels around a fraction t.
std::array<float, 4> spline_weights(float t) {
  const float s = 1.0f - t;
  return {s * s * s / 6.0f, (4.0f + t * t * (3.0f * t - 6.0f)) / 6.0f,
          (4.0f + s * s * (3.0f * s - 6.0f)) / 6.0f, t * t * t / 6.0f};
}

}  // namespace

ImageTexture::ImageTexture(const ImageDesc& desc)
    : name_(desc.name), encoding_(desc.encoding), alpha_(desc.alpha) {
  if (desc.width <= 0 || desc.height <= 0) {
    return;
  }
  const size_t count = static_cast<size_t>(desc.width) * static_cast<size_t>(desc.height) *
                       static_cast<size_t>(std::max(desc.channels, 0));
  const size_t item = desc.type == PixelType::kUint8 ? 1 : sizeof(float);
  if ((desc.channels != 1 && desc.channels != 3 && desc.channels != 4) ||
      desc.pixels.size() != count * item) {
    throw std::invalid_argument("image '" + desc.name + "': " + std::to_string(desc.pixels.size()) +
                                " bytes do not hold " + std::to_string(desc.width) + " x " +
                                std::to_string(desc.height) + " pixels of " +
                                std::to_string(desc.channels) + " channels");
  }
  width_ = desc.width;
  height_ = desc.height;
  channels_ = desc.channels;
  if (desc.type == PixelType::kUint8) {
    bytes_.resize(count);
    std::memcpy(bytes_.data(), desc.pixels.data(), count);
  } else {
    floats_.resize(count);
    std::memcpy(floats_.data(), desc.pixels.data(), count * sizeof(float));
    // A pixel that is not finite is black, as in Cycles.
    for (size_t i = 0; i < count; i += static_cast<size_t>(channels_)) {
      bool finite = true;
      for (size_t c = 0; c < static_cast<size_t>(channels_); ++c) {
        finite = finite && std::isfinite(floats_[i + c]);
      }
      if (!finite) {
        std::fill_n(floats_.begin() + static_cast<std::ptrdiff_t>(i), channels_, 0.0f);
      }
    }
  }
  if (channels_ == 4 && alpha_ == AlphaMode::kStraight) {
    for (size_t i = 0; i < count; i += 4) {
      for (size_t c = 0; c < 3; ++c) {
        if (!bytes_.empty()) {
          bytes_[i + c] = multiply_bytes(bytes_[i + c], bytes_[i + 3]);
        } else {
          floats_[i + c] *= floats_[i + 3];
        }
      }
    }
  }
}

// A pixel as stored, in [0, 1] for bytes. x and y are inside.
inline Floats4 ImageTexture::encoded(int x, int y) const {
  const size_t i = (static_cast<size_t>(y) * static_cast<size_t>(width_) + static_cast<size_t>(x)) *
                   static_cast<size_t>(channels_);
  const float opaque = 1.0f;
  if (!bytes_.empty()) {
    constexpr float kScale = 1.0f / 255.0f;
    const uint8_t* p = bytes_.data() + i;
    const float r = static_cast<float>(p[0]) * kScale;
    if (channels_ == 1) {
      return Floats4{r, r, r, opaque};
    }
    return Floats4{r, static_cast<float>(p[1]) * kScale, static_cast<float>(p[2]) * kScale,
                   has_alpha() ? static_cast<float>(p[3]) * kScale : opaque};
  }
  const float* p = floats_.data() + i;
  if (channels_ == 1) {
    return Floats4{p[0], p[0], p[0], opaque};
  }
  return Floats4{p[0], p[1], p[2], has_alpha() ? p[3] : opaque};
}

inline Floats4 ImageTexture::encoded_or_clear(int x, int y) const {
  return x < 0 || x >= width_ || y < 0 || y >= height_ ? Floats4{} : encoded(x, y);
}

Vec4f ImageTexture::decoded(Vec4f c) const {
  if (encoding_ == ImageEncoding::kLinear) {
    return c;
  }
  return {srgb_to_linear(c.x), srgb_to_linear(c.y), srgb_to_linear(c.z), c.w};
}

Vec4f ImageTexture::texel(int x, int y) const {
  return missing() ? kMissing : decoded(std::bit_cast<Vec4f>(encoded(x, y)));
}

Floats4 ImageTexture::interpolate_linear(float x, float y, Extension extension) const {
  const PixelCoordinate px(x - 0.5f), py(y - 0.5f);
  const float tx = px.fraction, ty = py.fraction;
  const int x0 = wrap(px.index, width_, extension), x1 = wrap(px.index + 1, width_, extension);
  const int y0 = wrap(py.index, height_, extension), y1 = wrap(py.index + 1, height_, extension);
  const Floats4 p00 = encoded_or_clear(x0, y0), p10 = encoded_or_clear(x1, y0);
  const Floats4 p01 = encoded_or_clear(x0, y1), p11 = encoded_or_clear(x1, y1);
  const Floats4 lower = p00 * (1.0f - tx) + p10 * tx, upper = p01 * (1.0f - tx) + p11 * tx;
  return upper * ty + lower * (1.0f - ty);
}

Floats4 ImageTexture::interpolate_cubic(float x, float y, Extension extension) const {
  const PixelCoordinate px(x - 0.5f), py(y - 0.5f);
  const std::array<float, 4> wx = spline_weights(px.fraction);
  const std::array<float, 4> wy = spline_weights(py.fraction);
  Floats4 sum{};
  for (int j = 0; j < 4; ++j) {
    Floats4 row{};
    for (int i = 0; i < 4; ++i) {
      row = row + encoded_or_clear(wrap(px.index + i - 1, width_, extension),
                                   wrap(py.index + j - 1, height_, extension)) *
                      wx[static_cast<size_t>(i)];
    }
    sum = sum + row * wy[static_cast<size_t>(j)];
  }
  return sum;
}

Vec4f ImageTexture::sample(float u, float v, Interpolation interpolation, Extension extension,
                           bool straight) const {
  if (missing()) {
    return kMissing;
  }
  const float x = finite_or_zero(u * static_cast<float>(width_));
  const float y = finite_or_zero(v * static_cast<float>(height_));
  Floats4 pixel{};
  switch (interpolation) {
    case Interpolation::kLinear:
      pixel = interpolate_linear(x, y, extension);
      break;
    case Interpolation::kCubic:
      pixel = interpolate_cubic(x, y, extension);
      break;
    case Interpolation::kClosest:
      pixel = encoded_or_clear(wrap(PixelCoordinate(x).index, width_, extension),
                               wrap(PixelCoordinate(y).index, height_, extension));
  }
  auto c = std::bit_cast<Vec4f>(pixel);
  if (straight && c.w != 0.0f && c.w != 1.0f) {
    const float inverse = 1.0f / c.w;
    c = {c.x * inverse, c.y * inverse, c.z * inverse, c.w};
  }
  return decoded(c);
}

Color ImageTexture::average() const {
  if (missing()) {
    return kMissing.xyz();
  }
  double sum[3] = {};
  for (int y = 0; y < height_; ++y) {
    for (int x = 0; x < width_; ++x) {
      const Vec4f c = texel(x, y);
      sum[0] += c.x;
      sum[1] += c.y;
      sum[2] += c.z;
    }
  }
  const double n = static_cast<double>(width_) * static_cast<double>(height_);
  return {static_cast<float>(sum[0] / n), static_cast<float>(sum[1] / n),
          static_cast<float>(sum[2] / n)};
}

}  // namespace vernier
