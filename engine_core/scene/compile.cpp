#include "scene/compile.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "bsdf/bsdf.h"
#include "camera/camera.h"
#include "lights/light_sampler.h"
#include "math/parallel.h"
#include "nodes/material.h"
#include "scene/compile_mesh.h"
#include "textures/image.h"

namespace vernier {
namespace {

// An axis-aligned box in float64: world coordinates before an origin is chosen.
struct Box {
  std::array<double, 3> lower{HUGE_VAL, HUGE_VAL, HUGE_VAL};
  std::array<double, 3> upper{-HUGE_VAL, -HUGE_VAL, -HUGE_VAL};

  bool empty() const { return lower[0] > upper[0]; }
  void add(const std::array<double, 3>& p) {
    for (size_t a = 0; a < 3; ++a) {
      lower[a] = std::min(lower[a], p[a]);
      upper[a] = std::max(upper[a], p[a]);
    }
  }
};

std::array<double, 3> transform_point(std::span<const float> m, const std::array<double, 3>& p) {
  std::array<double, 3> q{};
  for (size_t r = 0; r < 3; ++r) {
    q[r] = static_cast<double>(m[4 * r + 3]);
    for (size_t c = 0; c < 3; ++c) {
      q[r] += static_cast<double>(m[4 * r + c]) * p[c];
    }
  }
  return q;
}

// Bounds of the eight transformed corners of a box.
void add_transformed(const Box& box, std::span<const float> m, Box& result) {
  for (unsigned corner = 0; corner < 8 && !box.empty(); ++corner) {
    std::array<double, 3> p{};
    for (unsigned a = 0; a < 3; ++a) {
      p[a] = (corner >> a & 1u) != 0u ? box.upper[a] : box.lower[a];
    }
    result.add(transform_point(m, p));
  }
}

Box bounds_of(const MeshDesc& mesh) {
  Box box;
  for (size_t i = 0; i + 2 < mesh.positions.size(); i += 3) {
    box.add({static_cast<double>(mesh.positions[i]), static_cast<double>(mesh.positions[i + 1]),
             static_cast<double>(mesh.positions[i + 2])});
  }
  return box;
}

// What Cycles gives to a surface without a material: grey matter.
GraphDesc default_graph() {
  GraphDesc graph;
  graph.nodes.push_back({"ShaderNodeBsdfDiffuse", "Default", {}, {}});
  graph.nodes[0].inputs.push_back({"Color", {0.8f, 0.8f, 0.8f, 1.0f}, -1, ""});
  graph.surface = {0, "BSDF"};
  return graph;
}

}  // namespace

class SceneCompiler {
 public:
  SceneCompiler(const SceneDescription& desc, const CompileOptions& options)
      : desc_(desc), options_(options), scene_(std::make_shared<Scene>()) {}

  std::shared_ptr<const Scene> run() {
    compile_materials();
    choose_origin();
    compile_meshes();
    if (options_.large_parts_read) {
      options_.large_parts_read();
    }
    compile_instances();
    build_intersector();
    scene_->film = desc_.film;
    scene_->camera = std::make_unique<Camera>(desc_.camera, desc_.film, scene_->origin_.data());
    scene_->lights = std::make_unique<LightSampler>(*scene_, desc_.lights, std::move(lamp_shaders_),
                                                    scene_->warnings);
    collect_requirements();
    return scene_;
  }

 private:
  bool cancelled() const { return options_.cancelled && options_.cancelled(); }
  void stop_if_cancelled() const {
    if (cancelled()) {
      throw std::runtime_error("cancelled");
    }
  }

  void compile_materials() {
    Scene& s = *scene_;
    for (const ImageDesc& image : desc_.images) {
      s.images.push_back(std::make_unique<ImageTexture>(image));
    }
    NodeContext context(s.images, s.attribute_names, s.warnings);
    if (options_.keep_uv) {
      s.uv_attribute = context.attribute_id(kActiveUvAttribute);
    }
    for (const MaterialDesc& material : desc_.materials) {
      s.materials.push_back(compile_material(material.graph, material.name, context));
      s.material_pass_indices.push_back(material.pass_index);
    }
    s.materials.push_back(compile_material(default_graph(), "Default", context));
    s.material_pass_indices.push_back(0.0f);
    for (const LightDesc& light : desc_.lights) {
      lamp_shaders_.push_back(light.graph.surface.node < 0
                                  ? nullptr
                                  : compile_material(light.graph, light.name, context));
    }
    if (desc_.world.graph.surface.node >= 0) {
      s.world = compile_material(desc_.world.graph, "World", context);
    }
    s.world_visibility = desc_.world.visibility;
  }

  std::span<const float> matrix(size_t instance) const {
    return desc_.instances.transform.subspan(12 * instance, 12);
  }

  // The centre of everything, where float32 resolves what is there best.
  void choose_origin() {
    std::vector<Box> boxes(desc_.meshes.size());
    parallel_for(boxes.size(), options_.threads,
                 [&](size_t i) { boxes[i] = bounds_of(desc_.meshes[i]); });
    Box all;
    for (size_t i = 0; i < desc_.instances.mesh.size(); ++i) {
      add_transformed(boxes[static_cast<size_t>(desc_.instances.mesh[i])], matrix(i), all);
    }
    for (const LightDesc& light : desc_.lights) {
      if (light.kind != LightKind::kSun) {
        all.add(transform_point(light.transform.m, {0, 0, 0}));
      }
    }
    if (all.empty()) {
      all.add(transform_point(desc_.camera.transform.m, {0, 0, 0}));
    }
    double radius2 = 0.0;
    for (size_t a = 0; a < 3; ++a) {
      // Rounded to float32, so that differences to float32 coordinates are exact or nearly so.
      scene_->origin_[a] =
          static_cast<double>(static_cast<float>(0.5 * (all.lower[a] + all.upper[a])));
      const double half =
          std::max(all.upper[a] - scene_->origin_[a], scene_->origin_[a] - all.lower[a]);
      radius2 += half * half;
    }
    scene_->center = {};
    scene_->radius = static_cast<float>(std::sqrt(radius2));
  }

  void to_render_matrix(size_t instance, double* m) const {
    const auto t = matrix(instance);
    for (size_t i = 0; i < 12; ++i) {
      m[i] = static_cast<double>(t[i]) - (i % 4 == 3 ? scene_->origin_[i / 4] : 0.0);
    }
  }

  bool is_singular(size_t instance) const {
    Transform t;
    std::copy_n(matrix(instance).begin(), 12, t.m.begin());
    const Transform inv = inverse(t);
    return std::none_of(inv.m.begin(), inv.m.end(), [](float v) { return v != 0.0f; }) ||
           std::any_of(inv.m.begin(), inv.m.end(), [](float v) { return !std::isfinite(v); });
  }

  // A mesh of one instance is moved to render space, and so is a copy for every instance whose
  // transform cannot be inverted; other meshes are shared.
  void compile_meshes() {
    const auto& uses = desc_.instances.mesh;
    std::vector<uint32_t> count(desc_.meshes.size(), 0);
    for (const int32_t mesh : uses) {
      ++count[static_cast<size_t>(mesh)];
    }
    constexpr uint32_t kNone = kNoIndex;
    std::vector<uint32_t> shared(desc_.meshes.size(), kNone);
    struct Task {
      size_t desc;
      size_t instance;  // whose transform to apply; kShared: none
    };
    constexpr size_t kShared = ~size_t{0};
    std::vector<Task> tasks;
    mesh_of_instance_.resize(uses.size());
    for (size_t i = 0; i < uses.size(); ++i) {
      const auto m = static_cast<size_t>(uses[i]);
      if (count[m] == 1 || is_singular(i)) {
        mesh_of_instance_[i] = static_cast<uint32_t>(tasks.size());
        tasks.push_back({m, i});
      } else {
        if (shared[m] == kNone) {
          shared[m] = static_cast<uint32_t>(tasks.size());
          tasks.push_back({m, kShared});
        }
        mesh_of_instance_[i] = shared[m];
      }
    }
    scene_->meshes.resize(tasks.size());
    const auto compile_one = [&](size_t i, int threads) {
      stop_if_cancelled();
      const Task& task = tasks[i];
      double to_render[12];
      if (task.instance != kShared) {
        to_render_matrix(task.instance, to_render);
      }
      scene_->meshes[i] = compile_mesh(desc_.meshes[task.desc], scene_->attribute_names,
                                       task.instance == kShared ? nullptr : to_render, threads);
      scene_->meshes[i].instanced = task.instance == kShared;
      if (task.instance != kShared) {
        Transform t;
        std::transform(to_render, to_render + 12, t.m.begin(),
                       [](double v) { return static_cast<float>(v); });
        scene_->meshes[i].to_object = inverse(t);
      }
    };
    // Many meshes: one thread each; few: threads within each.
    if (tasks.size() >= static_cast<size_t>(4 * resolve_threads(options_.threads))) {
      parallel_for(tasks.size(), options_.threads, [&](size_t i) { compile_one(i, 1); });
    } else {
      for (size_t i = 0; i < tasks.size(); ++i) {
        compile_one(i, options_.threads);
      }
    }
  }

  void compile_instances() {
    const InstancesDesc& in = desc_.instances;
    Scene& s = *scene_;
    const auto fallback = static_cast<uint32_t>(s.materials.size() - 1);
    std::vector<uint32_t> set_offsets;
    for (const auto& set : desc_.material_sets) {
      set_offsets.push_back(static_cast<uint32_t>(s.slot_materials.size()));
      for (const int32_t material : set) {
        s.slot_materials.push_back(material < 0 ? fallback : static_cast<uint32_t>(material));
      }
      if (set.empty()) {
        s.slot_materials.push_back(fallback);
      }
    }
    s.objects = desc_.objects;
    s.instances.resize(in.mesh.size());
    parallel_for((in.mesh.size() + 4095) / 4096, options_.threads, [&](size_t chunk) {
      const size_t end = std::min(in.mesh.size(), (chunk + 1) * 4096);
      for (size_t i = chunk * 4096; i < end; ++i) {
        Instance& instance = s.instances[i];
        const auto set = static_cast<size_t>(in.material_set[i]);
        instance.mesh = mesh_of_instance_[i];
        instance.object = static_cast<uint32_t>(in.object[i]);
        instance.visibility = in.visibility[i];
        instance.material_offset = set_offsets[set];
        instance.slot_count = std::max(1u, static_cast<uint32_t>(desc_.material_sets[set].size()));
        instance.random = in.random[i];
        std::copy_n(matrix(i).begin(), 12, instance.object_to_world.m.begin());
        instance.world_to_object = inverse(instance.object_to_world);
        instance.mirrored = instance.object_to_world.determinant() < 0.0;
        if (s.meshes[instance.mesh].instanced) {
          double m[12];
          to_render_matrix(i, m);
          std::transform(m, m + 12, instance.to_render.m.begin(),
                         [](double v) { return static_cast<float>(v); });
          instance.from_render = inverse(instance.to_render);
        }
      }
    });
  }

  void build_intersector() {
    Scene& s = *scene_;
    std::vector<uint32_t> masks(s.instances.size());
    for (size_t i = 0; i < masks.size(); ++i) {
      const Instance& instance = s.instances[i];
      bool transparent = false;
      for (uint32_t slot = 0; slot < instance.slot_count; ++slot) {
        const uint32_t material = s.slot_materials[instance.material_offset + slot];
        transparent = transparent || s.materials[material]->traits().maybe_transparent;
      }
      masks[i] = instance.visibility & ~kVisibleShadow;
      if ((instance.visibility & kVisibleShadow) != 0u) {
        masks[i] |= transparent ? kMaskTransparentShadow : kMaskOpaqueShadow;
        s.requirements.transparent_shadows |= transparent;
      }
    }
    if (!s.instances.empty()) {
      s.intersector_ = std::make_unique<Intersector>(s.meshes, s.instances, masks, options_.threads,
                                                     options_.cancelled);
    }
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
    r.light_tree = s.lights->has_tree();
  }

  const SceneDescription& desc_;
  const CompileOptions& options_;
  std::shared_ptr<Scene> scene_;
  std::vector<uint32_t> mesh_of_instance_;
  std::vector<std::unique_ptr<Material>> lamp_shaders_;
};

std::shared_ptr<const Scene> compile(const SceneDescription& description,
                                     const CompileOptions& options) {
  return SceneCompiler(description, options).run();
}

}  // namespace vernier
