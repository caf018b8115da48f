#include "scene/compile.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "bsdf/bsdf.h"
#include "camera/camera.h"
#include "lights/lamp_contents.h"
#include "lights/light_sampler.h"
#include "math/parallel.h"
#include "nodes/material.h"
#include "scene/geometry.h"
#include "scene/resolution.h"
#include "scene/source.h"
#include "textures/image.h"

namespace vernier {
namespace {

// What Cycles gives to a surface without a material: grey matter.
MaterialDesc default_material() {
  GraphDesc graph;
  graph.nodes.push_back({"ShaderNodeBsdfDiffuse", "Default", {}, {}});
  graph.nodes[0].inputs.push_back({"Color", {0.8f, 0.8f, 0.8f, 1.0f}, -1, ""});
  graph.surface = {0, "BSDF"};
  return {"Default", graph, 0.0f};
}

template <class Desc>
std::vector<const void*> identities_of(const std::vector<Desc>& descs) {
  std::vector<const void*> result;
  for (const Desc& desc : descs) {
    result.push_back(desc.identity);
  }
  return result;
}

}  // namespace

class SceneCompiler {
 public:
  SceneCompiler(const SceneDescription& desc, const CompileOptions& options)
      : desc_(desc),
        options_(options),
        scene_(std::make_shared<Scene>()),
        previous_(options.previous && options.previous->source_ ? options.previous.get()
                                                                : nullptr) {}

  std::shared_ptr<const Scene> run() {
    compile_images();
    compile_materials();
    list_slots();
    set_masks();
    compile_geometry_or_share();
    Scene& s = *scene_;
    s.film = desc_.film;
    s.camera = std::make_unique<Camera>(desc_.camera, desc_.film, s.origin_.data());
    compile_lights_or_share();
    collect_requirements();
    s.compiled.changed = differs();
    if (options_.interactive) {
      keep_source();
    }
    return scene_;
  }

 private:
  const SceneSource* source() const {
    return previous_ != nullptr ? previous_->source_.get() : nullptr;
  }

  void compile_images() {
    Scene& s = *scene_;
    for (size_t i = 0; i < desc_.images.size(); ++i) {
      const ImageDesc& image = desc_.images[i];
      const bool known = source() != nullptr && i < source()->images.size() &&
                         image.identity != nullptr && source()->images[i] == image.identity;
      if (known) {
        s.images.push_back(previous_->images[i]);
        continue;
      }
      s.images.push_back(std::make_shared<const ImageTexture>(image));
      ++s.compiled.images;
    }
  }

  // Materials refer to images and to attributes by number: both must mean what they meant.
  void compile_materials() {
    Scene& s = *scene_;
    if (previous_ != nullptr) {
      s.attribute_names = previous_->attribute_names;
    }
    const bool same_images = source() != nullptr && s.compiled.images == 0 &&
                             source()->images.size() == desc_.images.size();
    NodeContext context(s.images, s.attribute_names, s.warnings);
    if (options_.keep_uv) {
      s.uv_attribute = context.attribute_id(kActiveUvAttribute);
    }
    materials_ = desc_.materials;
    materials_.push_back(default_material());
    emission_changed_ = !same_images;
    for (size_t i = 0; i < materials_.size(); ++i) {
      const MaterialDesc& material = materials_[i];
      const bool was_there = source() != nullptr && i < source()->materials.size();
      const bool known = same_images && was_there && source()->materials[i] == material;
      s.material_pass_indices.push_back(material.pass_index);
      if (known) {
        s.materials.push_back(previous_->materials[i]);
        continue;
      }
      s.materials.push_back(compile_material(material.graph, material.name, context));
      ++s.compiled.materials;
      emission_changed_ = emission_changed_ || !was_there || s.materials[i]->traits().is_emissive ||
                          previous_->materials[i]->traits().is_emissive;
    }
    for (const LightDesc& light : desc_.lights) {
      lamp_shaders_.push_back(light.graph.surface.node < 0
                                  ? nullptr
                                  : compile_material(light.graph, light.name, context));
    }
    if (same_images && source()->world == desc_.world) {
      s.world = previous_->world;
    } else {
      emission_changed_ = true;
      if (desc_.world.graph.surface.node >= 0) {
        s.world = compile_material(desc_.world.graph, "World", context);
      }
    }
    s.world_visibility = desc_.world.visibility;
  }

  void list_slots() {
    Scene& s = *scene_;
    s.objects = desc_.objects;
    const auto fallback = static_cast<uint32_t>(s.materials.size() - 1);
    for (const auto& set : desc_.material_sets) {
      material_offsets_.push_back(static_cast<uint32_t>(s.slot_materials.size()));
      slot_counts_.push_back(std::max(1u, static_cast<uint32_t>(set.size())));
      for (const int32_t material : set) {
        s.slot_materials.push_back(material < 0 ? fallback : static_cast<uint32_t>(material));
      }
      if (set.empty()) {
        s.slot_materials.push_back(fallback);
      }
    }
  }

  // Shadow rays tell opaque instances from those that may let light through.
  void set_masks() {
    Scene& s = *scene_;
    std::vector<bool> transparent(desc_.material_sets.size(), false);
    for (size_t set = 0; set < transparent.size(); ++set) {
      for (uint32_t slot = 0; slot < slot_counts_[set]; ++slot) {
        const uint32_t material = s.slot_materials[material_offsets_[set] + slot];
        transparent[set] = transparent[set] || s.materials[material]->traits().maybe_transparent;
      }
    }
    const InstancesDesc& in = desc_.instances;
    masks_.resize(in.mesh.size());
    for (size_t i = 0; i < masks_.size(); ++i) {
      const bool through = transparent[static_cast<size_t>(in.material_set[i])];
      masks_[i] = in.visibility[i] & ~kVisibleShadow;
      if ((in.visibility[i] & kVisibleShadow) != 0u) {
        masks_[i] |= through ? kMaskTransparentShadow : kMaskOpaqueShadow;
        s.requirements.transparent_shadows |= through;
      }
    }
  }

  // Everything but what moves with the view and the lamps.
  bool same_geometry() const {
    const SceneSource* was = source();
    return was != nullptr && was->attributes == scene_->attribute_names.size() &&
           was->uv_attribute == scene_->uv_attribute && was->slot_counts == slot_counts_ &&
           was->masks == masks_ && same_identities<MeshDesc>(was->meshes, desc_.meshes) &&
           was->instances == desc_.instances;
  }

  void compile_geometry_or_share() {
    Scene& s = *scene_;
    if (same_geometry()) {
      s.geometry_ = previous_->geometry_;
      if (options_.large_parts_read) {
        options_.large_parts_read();
      }
    } else {
      s.compiled.geometry = true;
      GeometryInput input;
      const std::vector<Box> meshes = bounds_of_meshes(desc_, options_.threads);
      input.bounds = bounds_of_instances(desc_, meshes);
      input.origin = center_of(with_lamps(input.bounds));
      input.warnings = describe_unresolved(desc_, meshes, input.origin);
      input.attribute_names = s.attribute_names;
      input.masks = masks_;
      input.material_offsets = material_offsets_;
      input.slot_counts = slot_counts_;
      input.fast_build = options_.interactive;
      input.meshes_read = options_.large_parts_read;
      s.geometry_ = compile_geometry(desc_, input, options_.threads, options_.cancelled);
    }
    s.warnings.insert(s.warnings.end(), s.geometry_->warnings.begin(), s.geometry_->warnings.end());
    s.meshes = s.geometry_->meshes;
    s.instances = s.geometry_->instances;
    s.intersector_ = s.geometry_->intersector.get();
    s.origin_ = s.geometry_->origin;
    set_bounding_sphere();
  }

  Box with_lamps(Box all) const {
    for (const LightDesc& light : desc_.lights) {
      if (light.kind != LightKind::kSun) {
        all.add(transform_point(light.transform.m, {0, 0, 0}));
      }
    }
    if (all.empty()) {
      all.add(transform_point(desc_.camera.transform.m, {0, 0, 0}));
    }
    return all;
  }

  // The centre of everything, where float32 resolves what is there best. Rounded to float32, so
  // that differences to float32 coordinates are exact or nearly so.
  static std::array<double, 3> center_of(const Box& all) {
    std::array<double, 3> center{};
    for (size_t a = 0; a < 3; ++a) {
      center[a] = static_cast<double>(static_cast<float>(0.5 * (all.lower[a] + all.upper[a])));
    }
    return center;
  }

  void set_bounding_sphere() {
    const Box all = with_lamps(scene_->geometry_->bounds);
    const auto& origin = scene_->origin_;
    double radius2 = 0.0;
    for (size_t a = 0; a < 3; ++a) {
      const double half = std::max(all.upper[a] - origin[a], origin[a] - all.lower[a]);
      radius2 += half * half;
    }
    scene_->center = {};
    scene_->radius = static_cast<float>(std::sqrt(radius2));
  }

  // A light sampler goes on referring to the scene it was made for: that scene must be the same in
  // all that light sampling reads.
  void compile_lights_or_share() {
    Scene& s = *scene_;
    const bool share = previous_ != nullptr && !s.compiled.geometry && !emission_changed_ &&
                       s.slot_materials == previous_->slot_materials &&
                       s.objects == previous_->objects && source()->lights == desc_.lights;
    if (share) {
      s.lights = previous_->lights;
      s.lights_home_ = previous_->lights_home_ ? previous_->lights_home_ : options_.previous;
      return;
    }
    s.compiled.lights = true;
    s.lights =
        std::make_shared<const LightSampler>(s, desc_.lights, std::move(lamp_shaders_), s.warnings);
  }

  bool differs() const {
    const Scene& s = *scene_;
    const CompiledParts& parts = s.compiled;
    return previous_ == nullptr || parts.geometry || parts.lights || parts.materials > 0 ||
           parts.images > 0 || s.slot_materials != previous_->slot_materials ||
           s.objects != previous_->objects || s.world_visibility != previous_->world_visibility ||
           s.material_pass_indices != previous_->material_pass_indices;
  }

  void collect_requirements() {
    Scene& s = *scene_;
    Requirements& r = s.requirements;
    for (const Mesh& mesh : s.meshes) {
      r.triangles += mesh.triangles.size();
      r.instancing = r.instancing || mesh.instanced;
    }
    std::vector<bool> used(s.materials.size(), false);
    for (const Instance& instance : s.instances) {
      r.instanced_triangles += s.meshes[instance.mesh].triangles.size();
      r.hidden_from_rays = r.hidden_from_rays || instance.visibility != kVisibleAll;
      const uint32_t scattered = instance.visibility & kVisibleScattered;
      r.uneven_visibility =
          r.uneven_visibility || (scattered != 0u && scattered != kVisibleScattered);
      for (uint32_t slot = 0; slot < instance.slot_count; ++slot) {
        used[s.slot_materials[instance.material_offset + slot]] = true;
      }
    }
    bool matte = false;
    for (size_t i = 0; i < used.size(); ++i) {
      if (!used[i]) {
        continue;
      }
      const MaterialTraits& traits = s.materials[i]->traits();
      ++(traits.is_constant ? r.constant_materials : r.program_materials);
      r.programs = r.programs || !traits.is_constant;
      r.path_dependent = r.path_dependent || traits.path_dependent;
      constexpr uint8_t kThrough = kLobeTransmission | kLobeTransparent;
      r.transmits_by_side =
          r.transmits_by_side || (traits.side_dependent && (traits.lobes & kThrough) != 0);
      r.textured_emission =
          r.textured_emission || (traits.is_emissive && !traits.emission_constant);
      r.singular_lobes = r.singular_lobes || (traits.lobes & kLobeSingular) != 0;
      r.transmission = r.transmission || (traits.lobes & kLobeTransmission) != 0;
      matte = matte || (traits.lobes & kLobeDiffuse) != 0;
      r.caustics = r.caustics || (traits.lobes & (kLobeGlossy | kLobeSingular)) != 0;
    }
    r.caustics = r.caustics && matte;
    r.instances = s.instances.size();
    r.lamps = desc_.lights.size();
    r.environment = s.world != nullptr && s.world->traits().is_emissive;
    r.depth_of_field = !s.camera->is_pinhole();
    r.hidden_from_rays = r.hidden_from_rays || s.world_visibility != kVisibleAll;
    r.emissive_triangles = s.lights->emissive_triangle_count();
    r.uneven_lights = s.lights->uneven_count();
    r.light_tree = s.lights->has_tree();
    r.things_in_lamps = lamps_hold_things(s, desc_.lights);
  }

  void keep_source() {
    scene_->source_ = std::make_shared<const SceneSource>(SceneSource{
        .meshes = identities_of(desc_.meshes),
        .images = identities_of(desc_.images),
        .instances = InstanceArrays(desc_.instances),
        .slot_counts = std::move(slot_counts_),
        .masks = std::move(masks_),
        .attributes = scene_->attribute_names.size(),
        .uv_attribute = scene_->uv_attribute,
        .materials = std::move(materials_),
        .lights = desc_.lights,
        .world = desc_.world,
    });
  }

  const SceneDescription& desc_;
  const CompileOptions& options_;
  std::shared_ptr<Scene> scene_;
  const Scene* previous_;                // null: nothing can be shared
  std::vector<MaterialDesc> materials_;  // the description's, then the default
  std::vector<std::unique_ptr<Material>> lamp_shaders_;
  std::vector<uint32_t> material_offsets_, slot_counts_, masks_;
  bool emission_changed_ = true;  // some material that emits, or the world, is not as it was
};

std::shared_ptr<const Scene> compile(const SceneDescription& description,
                                     const CompileOptions& options) {
  return SceneCompiler(description, options).run();
}

std::shared_ptr<const Scene> with_view(const std::shared_ptr<const Scene>& scene,
                                       const CameraDesc& camera, const FilmDesc& film) {
  auto result = std::make_shared<Scene>();
  Scene& s = *result;
  s.meshes = scene->meshes;
  s.instances = scene->instances;
  s.objects = scene->objects;
  s.slot_materials = scene->slot_materials;
  s.attribute_names = scene->attribute_names;
  s.uv_attribute = scene->uv_attribute;
  s.images = scene->images;
  s.materials = scene->materials;
  s.material_pass_indices = scene->material_pass_indices;
  s.world = scene->world;
  s.world_visibility = scene->world_visibility;
  s.lights = scene->lights;
  s.lights_home_ = scene->lights_home_ ? scene->lights_home_ : scene;
  s.requirements = scene->requirements;
  s.center = scene->center;
  s.radius = scene->radius;
  s.origin_ = scene->origin_;
  s.geometry_ = scene->geometry_;
  s.intersector_ = scene->intersector_;
  s.source_ = scene->source_;
  s.film = film;
  s.camera = std::make_unique<const Camera>(camera, film, s.origin_.data());
  s.requirements.depth_of_field = !s.camera->is_pinhole();
  return result;
}

}  // namespace vernier
