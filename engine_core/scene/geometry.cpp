#include "scene/geometry.h"

#include <algorithm>
#include <stdexcept>

#include "math/parallel.h"
#include "scene/compile_mesh.h"

namespace vernier {

void Box::add(const std::array<double, 3>& p) {
  for (size_t a = 0; a < 3; ++a) {
    lower[a] = std::min(lower[a], p[a]);
    upper[a] = std::max(upper[a], p[a]);
  }
}

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

void Box::add_transformed(const Box& box, std::span<const float> m) {
  for (unsigned corner = 0; corner < 8 && !box.empty(); ++corner) {
    std::array<double, 3> p{};
    for (unsigned a = 0; a < 3; ++a) {
      p[a] = (corner >> a & 1u) != 0u ? box.upper[a] : box.lower[a];
    }
    add(transform_point(m, p));
  }
}

namespace {

Box bounds_of(const MeshDesc& mesh) {
  Box box;
  for (size_t i = 0; i + 2 < mesh.positions.size(); i += 3) {
    box.add({static_cast<double>(mesh.positions[i]), static_cast<double>(mesh.positions[i + 1]),
             static_cast<double>(mesh.positions[i + 2])});
  }
  return box;
}

std::span<const float> matrix(const SceneDescription& desc, size_t instance) {
  return desc.instances.transform.subspan(12 * instance, 12);
}

class GeometryCompiler {
 public:
  GeometryCompiler(const SceneDescription& desc, const GeometryInput& input, int threads,
                   const std::function<bool()>& cancelled)
      : desc_(desc),
        input_(input),
        threads_(threads),
        cancelled_(cancelled),
        result_(std::make_shared<Geometry>()) {}

  std::shared_ptr<const Geometry> run() {
    result_->bounds = input_.bounds;
    result_->origin = input_.origin;
    result_->warnings = input_.warnings;
    compile_meshes();
    if (input_.meshes_read) {
      input_.meshes_read();
    }
    compile_instances();
    if (!result_->instances.empty()) {
      result_->intersector =
          std::make_unique<Intersector>(result_->meshes, result_->instances, input_.masks, threads_,
                                        input_.fast_build, cancelled_);
    }
    return result_;
  }

 private:
  void stop_if_cancelled() const {
    if (cancelled_ && cancelled_()) {
      throw std::runtime_error("cancelled");
    }
  }

  void to_render_matrix(size_t instance, double* m) const {
    const auto t = matrix(desc_, instance);
    for (size_t i = 0; i < 12; ++i) {
      m[i] = static_cast<double>(t[i]) - (i % 4 == 3 ? result_->origin[i / 4] : 0.0);
    }
  }

  bool is_singular(size_t instance) const {
    Transform t;
    std::copy_n(matrix(desc_, instance).begin(), 12, t.m.begin());
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
    result_->meshes.resize(tasks.size());
    const auto compile_one = [&](size_t i, int threads) {
      stop_if_cancelled();
      const Task& task = tasks[i];
      double to_render[12];
      if (task.instance != kShared) {
        to_render_matrix(task.instance, to_render);
      }
      result_->meshes[i] = compile_mesh(desc_.meshes[task.desc], input_.attribute_names,
                                        task.instance == kShared ? nullptr : to_render, threads);
      result_->meshes[i].instanced = task.instance == kShared;
      if (task.instance != kShared) {
        Transform t;
        std::transform(to_render, to_render + 12, t.m.begin(),
                       [](double v) { return static_cast<float>(v); });
        Mesh& mesh = result_->meshes[i];
        mesh.to_object = inverse(t);
        for (Vec3f& n : mesh.normals) {
          n = mesh.to_object.transposed_vector(n);
        }
      }
    };
    // Many meshes: one thread each; few: threads within each.
    if (tasks.size() >= static_cast<size_t>(4 * resolve_threads(threads_))) {
      parallel_for(tasks.size(), threads_, [&](size_t i) { compile_one(i, 1); });
    } else {
      for (size_t i = 0; i < tasks.size(); ++i) {
        compile_one(i, threads_);
      }
    }
  }

  void compile_instances() {
    const InstancesDesc& in = desc_.instances;
    result_->instances.resize(in.mesh.size());
    parallel_for((in.mesh.size() + 4095) / 4096, threads_, [&](size_t chunk) {
      const size_t end = std::min(in.mesh.size(), (chunk + 1) * 4096);
      for (size_t i = chunk * 4096; i < end; ++i) {
        Instance& instance = result_->instances[i];
        const auto set = static_cast<size_t>(in.material_set[i]);
        instance.mesh = mesh_of_instance_[i];
        instance.object = static_cast<uint32_t>(in.object[i]);
        instance.visibility = in.visibility[i];
        instance.material_offset = input_.material_offsets[set];
        instance.slot_count = input_.slot_counts[set];
        instance.random = in.random[i];
        std::copy_n(matrix(desc_, i).begin(), 12, instance.object_to_world.m.begin());
        instance.world_to_object = inverse(instance.object_to_world);
        instance.mirrored = instance.object_to_world.determinant() < 0.0;
        if (result_->meshes[instance.mesh].instanced) {
          double m[12];
          to_render_matrix(i, m);
          std::transform(m, m + 12, instance.to_render.m.begin(),
                         [](double v) { return static_cast<float>(v); });
          instance.from_render = inverse(instance.to_render);
        }
      }
    });
  }

  const SceneDescription& desc_;
  const GeometryInput& input_;
  const int threads_;
  const std::function<bool()>& cancelled_;
  std::shared_ptr<Geometry> result_;
  std::vector<uint32_t> mesh_of_instance_;
};

}  // namespace

std::vector<Box> bounds_of_meshes(const SceneDescription& desc, int threads) {
  std::vector<Box> boxes(desc.meshes.size());
  parallel_for(boxes.size(), threads, [&](size_t i) { boxes[i] = bounds_of(desc.meshes[i]); });
  return boxes;
}

Box bounds_of_instances(const SceneDescription& desc, std::span<const Box> meshes) {
  Box all;
  for (size_t i = 0; i < desc.instances.mesh.size(); ++i) {
    all.add_transformed(meshes[static_cast<size_t>(desc.instances.mesh[i])], matrix(desc, i));
  }
  return all;
}

std::shared_ptr<const Geometry> compile_geometry(const SceneDescription& desc,
                                                 const GeometryInput& input, int threads,
                                                 const std::function<bool()>& cancelled) {
  return GeometryCompiler(desc, input, threads, cancelled).run();
}

}  // namespace vernier
