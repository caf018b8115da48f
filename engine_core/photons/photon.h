// What light leaves where it meets a surface.
#pragma once

#include <array>
#include <cmath>
#include <cstdint>

#include "math/vec.h"

namespace vernier {

// What a photon has been through before the surface on which it lies.
enum class PhotonKind : uint8_t {
  kDirect,    // nothing
  kCaustic,   // specular surfaces alone (lobe_split.h)
  kIndirect,  // some other surface
};

// A set of kinds, a bit each.
constexpr uint8_t kind_bit(PhotonKind kind) {
  return static_cast<uint8_t>(1u << static_cast<unsigned>(kind));
}

// 24 bytes; its position is with the index. A map divides the powers by its number of paths.
struct Photon {
  Color power;                       // W, over the squared index of refraction of where it is
  std::array<int16_t, 3> direction;  // back to where it came from
  std::array<int8_t, 3> normal;      // geometric, on the side it came from
  PhotonKind kind = PhotonKind::kDirect;
  uint8_t bounces = 0;  // scattering events before; 255: that many or more

  Photon() = default;
  Photon(Color power_, Vec3f wi, Vec3f ng, PhotonKind kind_, int bounces_)
      : power(power_),
        kind(kind_),
        bounces(static_cast<uint8_t>(std::min(bounces_, kMostBounces))) {
    for (int axis = 0; axis < 3; ++axis) {
      const auto i = static_cast<size_t>(axis);
      direction[i] = static_cast<int16_t>(std::lround(wi[axis] * 32767.0f));
      normal[i] = static_cast<int8_t>(std::lround(ng[axis] * 127.0f));
    }
  }

  // Unit, to within the 2e-5 of its storage.
  Vec3f wi() const {
    return normalize({static_cast<float>(direction[0]), static_cast<float>(direction[1]),
                      static_cast<float>(direction[2])});
  }
  // Unit to within kNormalRounding: to tell surfaces apart.
  Vec3f ng() const {
    return Vec3f{static_cast<float>(normal[0]), static_cast<float>(normal[1]),
                 static_cast<float>(normal[2])} *
           (1.0f / 127.0f);
  }

  static constexpr int kMostBounces = 255;
  // Three components, each to half of 1/127: sqrt(3) / 254.
  static constexpr float kNormalRounding = 0.00682f;
};

}  // namespace vernier
