#include "textures/sky.h"

namespace vernier {
namespace {

// Polynomial in the sun's angle from the zenith, highest power first.
float cubic(const std::array<float, 4>& c, float t) {
  return ((c[0] * t + c[1]) * t + c[2]) * t + c[3];
}

}  // namespace

// Equation 3: the distribution of Perez et al., relative to the zenith.
float PreethamSky::Channel::operator()(float theta, float gamma) const {
  const float cos_gamma = std::cos(gamma);
  return zenith * (1.0f + perez[0] * std::exp(perez[1] / std::cos(theta))) *
         (1.0f + perez[2] * std::exp(perez[3] * gamma) + perez[4] * cos_gamma * cos_gamma);
}

// Appendix A.2 of the paper.
PreethamSky::PreethamSky(Vec3f sun, float t) : sun_(sun) {
  constexpr float kScale = 0.06f;  // of luminance, Cycles'
  const float theta = std::acos(clamp(sun.z, -1.0f, 1.0f));
  const float chi = (4.0f / 9.0f - t / 120.0f) * (kPi - 2.0f * theta);
  luminance_.zenith = kScale * ((4.0453f * t - 4.9710f) * std::tan(chi) - 0.2155f * t + 2.4192f);
  x_.zenith = cubic({0.00166f, -0.00375f, 0.00209f, 0.0f}, theta) * t * t +
              cubic({-0.02903f, 0.06377f, -0.03202f, 0.00394f}, theta) * t +
              cubic({0.11693f, -0.21196f, 0.06052f, 0.25886f}, theta);
  y_.zenith = cubic({0.00275f, -0.00610f, 0.00317f, 0.0f}, theta) * t * t +
              cubic({-0.04214f, 0.08970f, -0.04153f, 0.00516f}, theta) * t +
              cubic({0.15346f, -0.26756f, 0.06670f, 0.26688f}, theta);
  luminance_.perez = {0.1787f * t - 1.4630f, -0.3554f * t + 0.4275f, -0.0227f * t + 5.3251f,
                      0.1206f * t - 2.5771f, -0.0670f * t + 0.3703f};
  x_.perez = {-0.0193f * t - 0.2592f, -0.0665f * t + 0.0008f, -0.0004f * t + 0.2125f,
              -0.0641f * t - 0.8989f, -0.0033f * t + 0.0452f};
  y_.perez = {-0.0167f * t - 0.2608f, -0.0950f * t + 0.0092f, -0.0079f * t + 0.2102f,
              -0.0441f * t - 1.6537f, -0.0109f * t + 0.0529f};
  for (Channel* channel : {&luminance_, &x_, &y_}) {
    const float zenith = channel->zenith;
    channel->zenith = 1.0f;
    channel->zenith = zenith / (*channel)(0.0f, theta);
  }
}

Color PreethamSky::radiance(Vec3f d) const {
  constexpr float kHorizon = 0.5f * kPi - 0.001f;  // below it the horizon's colour goes on
  const float theta = std::acos(clamp(d.z, -1.0f, 1.0f));
  const float gamma = std::acos(clamp(dot(d, sun_), -1.0f, 1.0f));
  const float above = std::min(theta, kHorizon);
  const float x = x_(above, gamma), y = y_(above, gamma), luminance = luminance_(above, gamma);
  if (y == 0.0f) {
    return {};
  }
  const float big_x = luminance * x / y, big_z = luminance * (1.0f - x - y) / y;
  // XYZ to linear Rec.709 (ITU-R BT.709-6 primaries, D65).
  return max({3.2404542f * big_x - 1.5371385f * luminance - 0.4985314f * big_z,
              -0.9692660f * big_x + 1.8760108f * luminance + 0.0415560f * big_z,
              0.0556434f * big_x - 0.2040259f * luminance + 1.0572252f * big_z},
             Color{});
}

}  // namespace vernier
