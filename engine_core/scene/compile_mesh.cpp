#include "scene/compile_mesh.h"

#include "math/parallel.h"
#include "nodes/material.h"
#include "scene/triangulate.h"

namespace vernier {
namespace {

constexpr size_t kChunk = size_t{1} << 16;  // elements per task

template <typename Body>
void for_each_chunk(size_t count, int threads, const Body& body) {
  parallel_for((count + kChunk - 1) / kChunk, threads,
               [&](size_t chunk) { body(chunk * kChunk, std::min(count, (chunk + 1) * kChunk)); });
}

Vec3f read_vec3(std::span<const float> data, size_t i) {
  return {data[3 * i], data[3 * i + 1], data[3 * i + 2]};
}

// The mesh's own name of an attribute that materials ask for.
std::string resolve_attribute(const std::string& name, const MeshDesc& desc) {
  if (name == kActiveUvAttribute) {
    return desc.active_uv;
  }
  if (name == kTangentAttributePrefix) {
    return name + desc.active_uv;
  }
  if (name == kActiveColorAttribute) {
    return desc.active_color;
  }
  return name;
}

void copy_attributes(const MeshDesc& desc, std::span<const std::string> names, Mesh& mesh) {
  for (size_t id = 0; id < names.size(); ++id) {
    const std::string wanted = resolve_attribute(names[id], desc);
    for (const AttributeDesc& a : desc.attributes) {
      if (a.name == wanted) {
        mesh.attributes.resize(names.size());
        mesh.attributes[id] = {a.domain, a.channels, {a.data.begin(), a.data.end()}};
      }
    }
  }
}

}  // namespace

Mesh compile_mesh(const MeshDesc& desc, std::span<const std::string> attribute_names,
                  const double* to_render, int threads) {
  Mesh mesh;
  mesh.name = desc.name;
  mesh.texture_space_min = desc.texture_space_min;
  mesh.texture_space_max = desc.texture_space_max;

  const size_t vertices = desc.positions.size() / 3;
  // Embree reads 16 bytes per vertex: the last one needs room behind it.
  mesh.positions.reserve(vertices + 1);
  mesh.positions.resize(vertices);
  for_each_chunk(vertices, threads, [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i) {
      const Vec3f p = read_vec3(desc.positions, i);
      mesh.positions[i] = p;
      if (to_render != nullptr) {
        const double x = p.x, y = p.y, z = p.z;
        for (int r = 0; r < 3; ++r) {
          const double* m = to_render + 4 * r;
          mesh.positions[i][r] = static_cast<float>(m[0] * x + m[1] * y + m[2] * z + m[3]);
        }
      }
    }
  });

  copy_attributes(desc, attribute_names, mesh);
  mesh.normal_domain = desc.normal_domain;
  if (desc.normal_domain != Domain::kFace) {
    mesh.normals.resize(desc.normals.size() / 3);
    for (size_t i = 0; i < mesh.normals.size(); ++i) {
      mesh.normals[i] = read_vec3(desc.normals, i);
    }
  }
  bool needs_corners = desc.normal_domain == Domain::kCorner, needs_faces = false;
  for (const MeshAttribute& a : mesh.attributes) {
    needs_corners = needs_corners || (a.channels > 0 && a.domain == Domain::kCorner);
    needs_faces = needs_faces || (a.channels > 0 && a.domain == Domain::kFace);
  }

  // A face of n corners gives n - 2 triangles, so face f's first is number offset(f) - 2 f.
  const size_t faces = desc.face_offsets.empty() ? 0 : desc.face_offsets.size() - 1;
  const size_t triangles = faces == 0 ? 0 : desc.corner_vertices.size() - 2 * faces;
  mesh.triangles.resize(triangles);
  mesh.corners.resize(needs_corners ? triangles : 0);
  mesh.faces.resize(needs_faces ? triangles : 0);
  mesh.slots.resize(desc.face_materials.empty() ? 0 : triangles);
  for_each_chunk(faces, threads, [&](size_t begin, size_t end) {
    std::vector<Vec3f> polygon;
    std::vector<std::array<uint32_t, 3>> cut;
    for (size_t f = begin; f < end; ++f) {
      const auto first = static_cast<size_t>(desc.face_offsets[f]);
      const auto count = static_cast<size_t>(desc.face_offsets[f + 1]) - first;
      polygon.clear();
      cut.clear();
      for (size_t c = 0; count > 3 && c < count; ++c) {
        const auto vertex = static_cast<size_t>(desc.corner_vertices[first + c]);
        polygon.push_back(read_vec3(desc.positions, vertex));
      }
      if (count == 3) {
        cut.push_back({0, 1, 2});
      } else {
        triangulate(polygon, cut);
      }
      size_t t = first - 2 * f;
      for (const auto& corner : cut) {
        for (size_t k = 0; k < 3; ++k) {
          const size_t c = first + corner[k];
          mesh.triangles[t][k] = static_cast<uint32_t>(desc.corner_vertices[c]);
          if (needs_corners) {
            mesh.corners[t][k] = static_cast<uint32_t>(c);
          }
        }
        if (needs_faces) {
          mesh.faces[t] = static_cast<uint32_t>(f);
        }
        if (!mesh.slots.empty()) {
          mesh.slots[t] = static_cast<uint16_t>(std::clamp(desc.face_materials[f], 0, 0xffff));
        }
        ++t;
      }
    }
  });
  return mesh;
}

}  // namespace vernier
