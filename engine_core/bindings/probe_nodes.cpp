// Probes of compiled materials, and the table of node kinds for Python.
#include <nanobind/ndarray.h>
#include <nanobind/stl/shared_ptr.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>

#include <stdexcept>

#include "bindings/bind.h"
#include "bindings/graph_from_python.h"
#include "bindings/table.h"
#include "nodes/material.h"
#include "nodes/node_kinds.h"
#include "scene/scene.h"
#include "textures/image.h"

namespace nb = nanobind;

namespace vernier {
namespace {

Vec3f vec3(const Rows3& a, size_t i) { return {a(i, 0), a(i, 1), a(i, 2)}; }

// A material by itself, with the images and names it refers to.
struct ProbeMaterial {
  std::vector<std::shared_ptr<const ImageTexture>> images;
  std::vector<std::string> attribute_names, warnings;
  std::unique_ptr<Material> material;
};

using Pixels = nb::ndarray<nb::ro, nb::ndim<3>, nb::c_contig, nb::device::cpu>;

std::unique_ptr<ImageTexture> make_image(nb::handle source) {
  ImageDesc desc;
  desc.name = nb::cast<std::string>(source.attr("name"));
  desc.encoding = nb::cast<std::string>(source.attr("encoding")) == "srgb" ? ImageEncoding::kSrgb
                                                                           : ImageEncoding::kLinear;
  const auto alpha = nb::cast<std::string>(source.attr("alpha"));
  desc.alpha = alpha == "PREMUL"           ? AlphaMode::kPremultiplied
               : alpha == "CHANNEL_PACKED" ? AlphaMode::kChannelPacked
               : alpha == "NONE"           ? AlphaMode::kNone
                                           : AlphaMode::kStraight;
  nb::object pixels = source.attr("pixels");
  if (pixels.is_none()) {
    return std::make_unique<ImageTexture>(desc);
  }
  const auto array = nb::cast<Pixels>(pixels);
  desc.height = static_cast<int32_t>(array.shape(0));
  desc.width = static_cast<int32_t>(array.shape(1));
  desc.channels = static_cast<int32_t>(array.shape(2));
  desc.type = array.dtype() == nb::dtype<uint8_t>() ? PixelType::kUint8 : PixelType::kFloat32;
  desc.pixels = {static_cast<const std::byte*>(array.data()), array.nbytes()};
  return std::make_unique<ImageTexture>(desc);
}

std::shared_ptr<ProbeMaterial> compile_probe(nb::handle graph, const std::string& name,
                                             nb::handle images) {
  auto probe = std::make_shared<ProbeMaterial>();
  for (nb::handle image : images) {
    probe->images.push_back(make_image(image));
  }
  NodeContext context(probe->images, probe->attribute_names, probe->warnings);
  probe->material = compile_material(graph_from_python(graph), name, context);
  return probe;
}

// A point that is on no mesh, seen from `wo`: coordinates that need a mesh are its position.
SurfacePoint free_point(Vec3f p, Vec3f n, Vec3f wo) {
  SurfacePoint point;
  point.p = p;
  point.ns = point.ng = n;
  point.wo = wo;
  point.ray_length = 1.0f;
  return point;
}

template <typename Get>
Result evaluate(const Rows3& p, const Rows3& n, const Rows3& wo, Get get) {
  const Table table(p.shape(0), 3);
  for (size_t i = 0; i < table.rows(); ++i) {
    write(get(free_point(vec3(p, i), vec3(n, i), vec3(wo, i))), table.row(i));
  }
  return table.release();
}

Result probe_emission(const ProbeMaterial& m, const Rows3& p, const Rows3& n, const Rows3& wo) {
  return evaluate(p, n, wo, [&](const SurfacePoint& s) { return m.material->emission(s); });
}
Result probe_transparency(const ProbeMaterial& m, const Rows3& p, const Rows3& n, const Rows3& wo) {
  return evaluate(p, n, wo, [&](const SurfacePoint& s) { return m.material->transparency(s); });
}

// Emission toward minus the directions, as the world's shader gives it.
Result probe_world(const ProbeMaterial& m, const Rows3& directions) {
  const Table table(directions.shape(0), 3);
  for (size_t i = 0; i < table.rows(); ++i) {
    SurfacePoint point;
    point.wo = -vec3(directions, i);
    write(m.material->emission(point), table.row(i));
  }
  return table.release();
}

nb::dict traits_of(const ProbeMaterial& m) {
  const MaterialTraits& t = m.material->traits();
  nb::dict d;
  d["is_constant"] = t.is_constant;
  d["is_emissive"] = t.is_emissive;
  d["emission_constant"] = t.emission_constant;
  d["maybe_transparent"] = t.maybe_transparent;
  d["view_dependent"] = t.side_dependent || t.direction_dependent || t.path_dependent;
  d["side_dependent"] = t.side_dependent;
  d["direction_dependent"] = t.direction_dependent;
  d["path_dependent"] = t.path_dependent;
  d["emission_view_dependent"] = t.emission_view_dependent;
  d["uses_bump"] = t.uses_bump;
  d["lobes"] = static_cast<int>(t.lobes);
  d["average_emission"] =
      nb::make_tuple(t.average_emission.x, t.average_emission.y, t.average_emission.z);
  nb::list names;
  for (const uint32_t id : t.attributes) {
    names.append(m.attribute_names[id]);
  }
  d["attributes"] = names;
  d["program_length"] = m.material->program_length();
  d["registers"] = m.material->register_count();
  return d;
}

// What rays meet in a scene, by the emission of the material there; NaN where they meet nothing.
Result scene_emission(nb::handle handle, const Rows3& origins, const Rows3& directions) {
  const auto scene = scene_of(handle);
  const Table table(origins.shape(0), 3);
  for (size_t i = 0; i < table.rows(); ++i) {
    const Ray ray{vec3(origins, i), vec3(directions, i)};
    Hit hit;
    Vec3f value = splat(std::numeric_limits<float>::quiet_NaN());
    if (scene->intersect(ray, kVisibleAll, hit)) {
      const SurfacePoint point = scene->surface_point(ray, hit);
      value = scene->materials[point.material]->emission(point);
    }
    write(value, table.row(i));
  }
  return table.release();
}

Result sample_image(nb::handle source, const Rows2& uv, const std::string& interpolation,
                    const std::string& extension, bool straight) {
  const auto image = make_image(source);
  const auto find = [](const std::string& name, std::initializer_list<const char*> names) {
    size_t i = 0;
    for (const char* candidate : names) {
      if (name == candidate) {
        return i;
      }
      ++i;
    }
    throw std::invalid_argument("there is no " + name);
  };
  const auto i = static_cast<Interpolation>(find(interpolation, {"Linear", "Closest", "Cubic"}));
  const auto e = static_cast<Extension>(find(extension, {"REPEAT", "EXTEND", "CLIP", "MIRROR"}));
  const Table table(uv.shape(0), 4);
  for (size_t row = 0; row < table.rows(); ++row) {
    const Vec4f c = image->sample(uv(row, 0), uv(row, 1), i, e, straight);
    write(c.xyz(), table.row(row));
    table.row(row)[3] = c.w;
  }
  return table.release();
}

nb::str str(std::string_view text) { return nb::str(text.data(), text.size()); }

const char* type_name(SocketType type) {
  switch (type) {
    case SocketType::kFloat:
      return "VALUE";
    case SocketType::kVector:
      return "VECTOR";
    case SocketType::kColor:
      return "RGBA";
    case SocketType::kShader:
      return "SHADER";
  }
  return "";
}

const char* type_name(ParamType type) {
  switch (type) {
    case ParamType::kBool:
      return "bool";
    case ParamType::kInt:
      return "int";
    case ParamType::kFloat:
      return "float";
    case ParamType::kString:
      return "string";
    case ParamType::kEnum:
      return "enum";
    case ParamType::kFloats:
      return "floats";
    case ParamType::kImage:
      return "image";
  }
  return "";
}

// A dict per kind: name, inputs (name, type, default or None where unlinked reads the surface),
// outputs (name, type), params (name, type, default, enum items) and fallback.
nb::list node_kind_rows() {
  nb::list rows;
  for (const NodeKind& kind : node_kinds()) {
    nb::dict row;
    row["name"] = str(kind.name);
    nb::list inputs, outputs, params;
    for (const InputKind& in : kind.inputs) {
      const bool has_value = in.source == SocketSource::kValue && in.type != SocketType::kShader;
      const nb::object value =
          has_value ? nb::object(nb::make_tuple(in.value[0], in.value[1], in.value[2], in.value[3]))
                    : nb::object(nb::none());
      inputs.append(nb::make_tuple(str(in.name), type_name(in.type), value));
    }
    for (const OutputKind& out : kind.outputs) {
      outputs.append(nb::make_tuple(str(out.name), type_name(out.type)));
    }
    for (const ParamKind& param : kind.params) {
      nb::list items;
      for (const std::string_view item : param.items) {
        items.append(str(item));
      }
      params.append(
          nb::make_tuple(str(param.name), type_name(param.type), param.number, nb::tuple(items)));
    }
    row["inputs"] = inputs;
    row["outputs"] = outputs;
    row["params"] = params;
    row["fallback"] = str(kind.fallback);
    rows.append(row);
  }
  return rows;
}

}  // namespace

void bind_nodes_probes(nb::module_& m) {
  nb::class_<ProbeMaterial>(m, "ProbeMaterial")
      .def_prop_ro("warnings", [](const ProbeMaterial& p) { return p.warnings; })
      .def_prop_ro("traits", &traits_of)
      .def("emission", &probe_emission, nb::arg("p"), nb::arg("n"), nb::arg("wo"))
      .def("transparency", &probe_transparency, nb::arg("p"), nb::arg("n"), nb::arg("wo"))
      .def("world", &probe_world, nb::arg("directions"));
  m.def("compile_graph", &compile_probe, nb::arg("graph"), nb::arg("name") = "probe",
        nb::arg("images") = nb::list(),
        "Compiles one graph; a graph whose surface is a value emits that value.");
  m.def("scene_emission", &scene_emission, nb::arg("scene"), nb::arg("origins"),
        nb::arg("directions"));
  m.def("sample_image", &sample_image, nb::arg("image"), nb::arg("uv"),
        nb::arg("interpolation") = "Linear", nb::arg("extension") = "REPEAT",
        nb::arg("straight") = false);
  m.def("node_kind_rows", &node_kind_rows, "The table of node kinds, a dict per row.");
}

}  // namespace vernier
