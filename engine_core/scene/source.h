// What a scene was compiled from, as far as a later compilation compares with it.
#pragma once

#include <algorithm>
#include <cstdint>
#include <span>
#include <vector>

#include "scene/description.h"

namespace vernier {

// Copies of an InstancesDesc's arrays.
struct InstanceArrays {
  std::vector<int32_t> mesh, material_set, object;
  std::vector<float> transform, random;
  std::vector<uint32_t> visibility;

  explicit InstanceArrays(const InstancesDesc& desc)
      : mesh(desc.mesh.begin(), desc.mesh.end()),
        material_set(desc.material_set.begin(), desc.material_set.end()),
        object(desc.object.begin(), desc.object.end()),
        transform(desc.transform.begin(), desc.transform.end()),
        random(desc.random.begin(), desc.random.end()),
        visibility(desc.visibility.begin(), desc.visibility.end()) {}

  bool operator==(const InstancesDesc& desc) const {
    return std::ranges::equal(mesh, desc.mesh) &&
           std::ranges::equal(material_set, desc.material_set) &&
           std::ranges::equal(object, desc.object) &&
           std::ranges::equal(transform, desc.transform) &&
           std::ranges::equal(random, desc.random) &&
           std::ranges::equal(visibility, desc.visibility);
  }
};

struct SceneSource {
  std::vector<const void*> meshes, images;  // identities
  InstanceArrays instances;
  std::vector<uint32_t> slot_counts;  // of each material set
  std::vector<uint32_t> masks;        // of each instance
  size_t attributes = 0;              // how many of the attribute names the meshes carry
  uint32_t uv_attribute = 0;
  std::vector<MaterialDesc> materials;
  std::vector<LightDesc> lights;
  WorldDesc world;
};

// Whether all of `descs` are what `identities` names, none of them unknown.
template <class Desc>
bool same_identities(std::span<const void* const> identities, std::span<const Desc> descs) {
  return std::ranges::equal(identities, descs, [](const void* known, const Desc& desc) {
    return known != nullptr && known == desc.identity;
  });
}

}  // namespace vernier
