#include "bsdf/bsdf.h"

#include <memory>

#include "bsdf/layering.h"
#include "bsdf/microfacet_lobe.h"
#include "bsdf/normals.h"

namespace vernier {

// Removes a lobe that is no layer, and closes the gap.
void Bsdf::drop(int index) {
  for (int i = index + 1; i < count_; ++i) {
    if (lobes_[i].above > index) {
      --lobes_[i].above;
    }
    lobes_[i - 1] = lobes_[i];
  }
  --count_;
}

Lobe* Bsdf::add(LobeKind kind, Color weight, Vec3f normal) {
  // As in Cycles: weights that are too small, and not numbers, add nothing.
  constexpr float kCutoff = 1e-5f;
  weight = min(max(weight, Color{}), splat(kMaxWeight));
  const float strength = average(weight);
  if (!(strength >= kCutoff)) {
    return nullptr;
  }
  if (count_ == kMaxLobes) {
    ++overflow_;
    int weakest = -1;
    float least = strength;
    for (int i = 0; i < count_; ++i) {
      if (!lobes_[i].is_layer && average(lobes_[i].weight) < least) {
        least = average(lobes_[i].weight);
        weakest = i;
      }
    }
    if (weakest < 0) {
      return nullptr;
    }
    drop(weakest);
  }
  Lobe* lobe = &lobes_[count_++];
  if (is_microfacet(kind)) {
    std::construct_at(lobe);
  } else {
    static_cast<LobeTraits&>(*lobe) = LobeTraits{};
  }
  lobe->kind = kind;
  lobe->weight = weight;
  lobe->normal = normal;
  if (is_microfacet(kind)) {
    lobe->corrected = !(normal == ng_);
    if (kind != LobeKind::kRefraction) {
      lobe->reflection_bits = kLobeGlossy | kLobeReflection;
    }
    if (kind != LobeKind::kReflection) {
      lobe->transmission_bits = kLobeGlossy | kLobeTransmission;
    }
  } else {
    lobe->reflection_bits = kLobeDiffuse | kLobeReflection;
    if (!(normal == ns_)) {
      lobe->bumped = true;
      lobe->bump_alpha2 = bump_alpha2(normal, ns_);
    }
  }
  return lobe;
}

void Bsdf::reuse(const Bsdf& prepared) {
  count_ = prepared.count_;
  overflow_ = prepared.overflow_;
  transparency = prepared.transparency;
  holdout = prepared.holdout;
  const bool smooth_shaded = !(ns_ == ng_);
  for (int i = 0; i < count_; ++i) {
    Lobe& lobe = lobes_[i];
    lobe = prepared.lobes_[i];
    lobe.normal = ns_;
    // Only lobes with a mirror direction ever are.
    lobe.corrected =
        smooth_shaded && (is_microfacet(lobe.kind) || lobe.kind == LobeKind::kAshikhminShirley);
  }
}

Color Bsdf::attenuation(int layer) const {
  if (layer < 0) {
    return splat(1.0f);
  }
  Color below = splat(1.0f);
  const SurfaceSide side{ng_, wo_, 1.0f};
  see_lobe(lobes_[layer], attenuation(lobes_[layer].above), side, false, below);
  return below;
}

float Bsdf::see_all(const SurfaceSide& side, RawArray<LobeSide, kMaxLobes>& seen) const {
  RawArray<Color, kMaxLobes> below;
  const float transparent = average(transparency);
  const bool alone = count_ == 1 && !(transparent > 0.0f);
  float total = transparent;
  for (int i = 0; i < count_; ++i) {
    const Lobe& lobe = lobes_[i];
    const Color above = lobe.above < 0 ? splat(1.0f) : below[lobe.above];
    if (lobe.kind == LobeKind::kLambert) {  // what see_lobe does, for the commonest base
      LobeSide& base = seen[i];
      base.normal = lobe.normal * side.sign;
      base.scale = min(lobe.weight * above, splat(kMaxWeight));
      base.select = average(base.scale);
      base.energy = 1.0f;
    } else {
      seen[i] = see_lobe(lobe, above, side, alone, below[i]);
    }
    total += seen[i].select;
  }
  if (!(total > 0.0f)) {
    return 0.0f;
  }
  const float scale = 1.0f / total;
  for (int i = 0; i < count_; ++i) {
    seen[i].select *= scale;
  }
  return transparent * scale;
}

void Bsdf::finish() {
  transparency = min(transparency, splat(kMaxWeight));
  const bool transparent = !is_black(transparency);
  if (count_ == 1 && lobes_[0].kind == LobeKind::kLambert && !transparent && !lobes_[0].mirrored &&
      !lobes_[0].bumped && lobes_[0].above < 0) {
    lambert_ = smooth_ = true;
    bits_ = lobes_[0].reflection_bits;
    return;
  }
  transparent_select_ = see_all({ng_, wo_, 1.0f}, near_);
  for (int i = 0; i < count_; ++i) {
    bits_ |= lobes_[i].reflection_bits;
    bits_ |= lobes_[i].transmission_bits;
    smooth_ = smooth_ || !lobes_[i].singular;
  }
  if (transparent) {
    bits_ |= kLobeSingular | kLobeTransparent;
  }
}

Color Bsdf::albedo(uint8_t mask) const {
  if (lambert_) {
    return permits(mask, bits_) ? lobes_[0].weight : Color{};
  }
  Color sum = permits(mask, kLobeSingular | kLobeTransparent) ? transparency : Color{};
  for (int i = 0; i < count_; ++i) {
    const Lobe& lobe = lobes_[i];
    const Vec3f n = near_[i].normal;
    LobeAlbedo parts = lobe_albedo(lobe, dot(n, wo_), lobe.eta, lobe.film.ior);
    Color part;
    if (permits(mask, lobe.reflection_bits)) {
      part += parts.r;
    }
    if (permits(mask, lobe.transmission_bits)) {
      part += parts.t;
    }
    sum += near_[i].scale * (1.0f / near_[i].energy) * part;
  }
  return sum;
}

namespace {

// Not of microfacets: without a roughness that could make it near specular.
bool is_wide(const Lobe& lobe) {
  return !is_microfacet(lobe.kind) && lobe.kind != LobeKind::kAshikhminShirley;
}

// Singular 0, and 1 where the lobe is no microfacets.
float squared_roughness(const Lobe& lobe) {
  return lobe.singular ? 0.0f : (is_wide(lobe) ? 1.0f : lobe.alpha_x * lobe.alpha_y);
}

}  // namespace

float Bsdf::widest_alpha() const {
  if (lambert_) {
    return 1.0f;
  }
  float widest = 0.0f;
  for (int i = 0; i < count_; ++i) {
    const Lobe& lobe = lobes_[i];
    if (!lobe.singular) {
      widest = std::max(widest, is_wide(lobe) ? 1.0f : std::min(lobe.alpha_x, lobe.alpha_y));
    }
  }
  return widest;
}

float Bsdf::mean_squared_roughness() const {
  if (lambert_) {
    return 1.0f;
  }
  float sum = 0.0f, total = transparent_select_;
  for (int i = 0; i < count_; ++i) {
    sum += near_[i].select * squared_roughness(lobes_[i]);
    total += near_[i].select;
  }
  return total > 0.0f ? sum / total : 0.0f;
}

float Bsdf::sharpest_glossy() const {
  float least = kInfinity;
  for (int i = 0; i < count_; ++i) {
    const Lobe& lobe = lobes_[i];
    if (((lobe.reflection_bits | lobe.transmission_bits) & kLobeGlossy) != 0) {
      least = std::min(least, squared_roughness(lobe));
    }
  }
  return least;
}

Vec3f Bsdf::mean_normal() const {
  if (lambert_) {
    return ns_;
  }
  Vec3f sum{};
  for (int i = 0; i < count_; ++i) {
    sum += near_[i].normal * near_[i].select;
  }
  return length_squared(sum) > 0.0f ? normalize(sum) : ns_;
}

}  // namespace vernier
