// Ways from a coordinate to a position in an image (Cycles: kernel/svm/image.h).
#pragma once

#include <cstdint>

#include "math/vec.h"
#include "scene/surface_point.h"
#include "textures/image.h"

namespace vernier {

// In the order of the nodes' enum items, with box projection apart.
enum class ImageProjection : uint8_t { kFlat, kSphere, kTube };
enum class EnvironmentProjection : uint8_t { kEquirectangular, kMirrorBall };

// How an image is read; packed into an instruction's variant.
struct ImageUse {
  uint8_t projection = 0;  // ImageProjection or EnvironmentProjection
  Interpolation interpolation = Interpolation::kLinear;
  Extension extension = Extension::kRepeat;
  bool straight = false;

  uint8_t pack() const;
  static ImageUse unpack(uint8_t bits);
};

// `image` null: drawn as missing.
Vec4f image_texture(const ImageTexture* image, const ImageUse& use, Vec3f coordinate);
// Projected along the three axes of object space, by the direction of the normal; `blend` [0, 1].
Vec4f box_texture(const ImageTexture* image, const ImageUse& use, Vec3f coordinate, float blend,
                  const SurfacePoint& point);
Vec4f environment_texture(const ImageTexture* image, const ImageUse& use, Vec3f direction);

}  // namespace vernier
