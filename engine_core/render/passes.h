// The passes that a render can make besides the picture.
#pragma once

#include <array>
#include <cstdint>
#include <string_view>

namespace vernier {

enum class Pass : int {
  kCombined,
  kDepth,
  kPosition,
  kNormal,
  kUv,
  kDiffuseDirect,
  kDiffuseIndirect,
  kDiffuseColor,
  kGlossyDirect,
  kGlossyIndirect,
  kGlossyColor,
  kTransmissionDirect,
  kTransmissionIndirect,
  kTransmissionColor,
  kEmission,
  kEnvironment,
  kDenoisingNormal,
  kDenoisingAlbedo,
  kDenoisingDepth,
  kSampleCount,
  kError,
  kCount,
};

inline constexpr int kPassCount = static_cast<int>(Pass::kCount);

// How a pass is stored and read.
enum class PassKind : uint8_t {
  kAverage,      // mean over the samples
  kFirstSample,  // of the pixel's first sample: averages of it mean nothing
  kLight,        // mean over the samples, divided by the colour pass that follows its group
  kDerived,      // computed from the picture's own sums
};

struct PassInfo {
  std::string_view name;         // Blender 5's name of the pass
  std::string_view legacy_name;  // Blender 4.5's
  std::string_view channels;     // "RGBA", "XYZ", ...: one letter a channel
  std::string_view type;         // Blender's: COLOR, VECTOR, VALUE
  PassKind kind;
  Pass color = Pass::kCount;  // of kLight: the pass it is divided by
};

inline constexpr std::array<PassInfo, kPassCount> kPasses{{
    {"Combined", "Combined", "RGBA", "COLOR", PassKind::kAverage},
    {"Depth", "Depth", "Z", "VALUE", PassKind::kFirstSample},
    {"Position", "Position", "XYZ", "VECTOR", PassKind::kFirstSample},
    {"Normal", "Normal", "XYZ", "VECTOR", PassKind::kAverage},
    {"UV", "UV", "UVA", "VECTOR", PassKind::kAverage},
    {"Diffuse Direct", "DiffDir", "RGB", "COLOR", PassKind::kLight, Pass::kDiffuseColor},
    {"Diffuse Indirect", "DiffInd", "RGB", "COLOR", PassKind::kLight, Pass::kDiffuseColor},
    {"Diffuse Color", "DiffCol", "RGB", "COLOR", PassKind::kAverage},
    {"Glossy Direct", "GlossDir", "RGB", "COLOR", PassKind::kLight, Pass::kGlossyColor},
    {"Glossy Indirect", "GlossInd", "RGB", "COLOR", PassKind::kLight, Pass::kGlossyColor},
    {"Glossy Color", "GlossCol", "RGB", "COLOR", PassKind::kAverage},
    {"Transmission Direct", "TransDir", "RGB", "COLOR", PassKind::kLight, Pass::kTransmissionColor},
    {"Transmission Indirect", "TransInd", "RGB", "COLOR", PassKind::kLight,
     Pass::kTransmissionColor},
    {"Transmission Color", "TransCol", "RGB", "COLOR", PassKind::kAverage},
    {"Emission", "Emit", "RGB", "COLOR", PassKind::kAverage},
    {"Environment", "Env", "RGB", "COLOR", PassKind::kAverage},
    {"Denoising Normal", "Denoising Normal", "XYZ", "VECTOR", PassKind::kAverage},
    {"Denoising Albedo", "Denoising Albedo", "RGB", "COLOR", PassKind::kAverage},
    {"Denoising Depth", "Denoising Depth", "Z", "VALUE", PassKind::kAverage},
    {"Debug Sample Count", "Debug Sample Count", "X", "VALUE", PassKind::kDerived},
    {"Error", "Error", "X", "VALUE", PassKind::kDerived},
}};

constexpr const PassInfo& info(Pass pass) { return kPasses[static_cast<size_t>(pass)]; }

// A set of passes.
class PassSet {
 public:
  constexpr void add(Pass pass) { bits_ |= 1u << static_cast<unsigned>(pass); }
  friend constexpr bool operator==(PassSet, PassSet) = default;
  constexpr bool has(Pass pass) const { return (bits_ >> static_cast<unsigned>(pass) & 1u) != 0; }
  // True where a sample has more to deliver than its colour.
  constexpr bool any_sampled() const {
    constexpr uint32_t derived = 1u << static_cast<unsigned>(Pass::kCombined) |
                                 1u << static_cast<unsigned>(Pass::kSampleCount) |
                                 1u << static_cast<unsigned>(Pass::kError);
    return (bits_ & ~derived) != 0;
  }

 private:
  uint32_t bits_ = 1u;  // the picture itself is always there
};

}  // namespace vernier
