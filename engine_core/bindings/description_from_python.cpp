#include "bindings/description_from_python.h"

#include <nanobind/ndarray.h>
#include <nanobind/stl/array.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>

#include <stdexcept>

#include "bindings/graph_from_python.h"

namespace nb = nanobind;

namespace vernier {
namespace {

using std::string;

class Reader {
 public:
  explicit Reader(bool with_identities) : with_identities_(with_identities) {}

  BorrowedDescription read(nb::handle source) {
    SceneDescription& d = result_.description;
    for (nb::handle mesh : source.attr("meshes")) {
      d.meshes.push_back(read_mesh(mesh));
      d.meshes.back().identity = with_identities_ ? mesh.ptr() : nullptr;
    }
    std::swap(result_.mesh_owners, result_.owners);
    d.material_sets = nb::cast<std::vector<std::vector<int32_t>>>(source.attr("material_sets"));
    d.instances = read_instances(source.attr("instances"));
    for (nb::handle object : source.attr("objects")) {
      d.objects.push_back(read_object(object));
    }
    for (nb::handle material : source.attr("materials")) {
      d.materials.push_back({text(material, "name"), graph_from_python(material.attr("graph")),
                             real(material, "pass_index")});
    }
    std::swap(result_.image_owners, result_.owners);
    for (nb::handle image : source.attr("images")) {
      d.images.push_back(read_image(image));
      d.images.back().identity = with_identities_ ? image.ptr() : nullptr;
    }
    std::swap(result_.image_owners, result_.owners);
    for (nb::handle light : source.attr("lights")) {
      d.lights.push_back(read_light(light));
    }
    d.world.graph = graph_from_python(source.attr("world").attr("graph"));
    d.world.visibility = bits(source.attr("world"), "visibility");
    d.camera = read_camera(source.attr("camera"));
    d.film = read_film(source.attr("film"));
    return std::move(result_);
  }

  CameraDesc read_camera(nb::handle o) {
    CameraDesc c;
    c.kind =
        text(o, "kind") == "ORTHOGRAPHIC" ? CameraKind::kOrthographic : CameraKind::kPerspective;
    c.transform = transform(o);
    c.window = reals<4>(o, "window");
    c.clip_start = real(o, "clip_start");
    c.clip_end = real(o, "clip_end");
    c.aperture_radius = real(o, "aperture_radius");
    c.focus_distance = real(o, "focus_distance");
    c.blades = whole(o, "blades");
    c.blade_rotation = real(o, "blade_rotation");
    c.aperture_ratio = real(o, "aperture_ratio");
    return c;
  }

  static FilmDesc read_film(nb::handle o) {
    FilmDesc f;
    f.width = whole(o, "width");
    f.height = whole(o, "height");
    size_t i = 0;
    for (nb::handle v : o.attr("crop")) {
      f.crop.at(i++) = nb::cast<int32_t>(v);
    }
    const string filter = text(o, "filter");
    f.filter = filter == "BOX"        ? FilterKind::kBox
               : filter == "GAUSSIAN" ? FilterKind::kGaussian
                                      : FilterKind::kBlackmanHarris;
    f.filter_width = real(o, "filter_width");
    f.exposure = real(o, "exposure");
    f.pass_alpha_threshold = real(o, "pass_alpha_threshold");
    f.transparent = truth(o, "transparent");
    return f;
  }

 private:
  static string text(nb::handle o, const char* name) { return nb::cast<string>(o.attr(name)); }
  static float real(nb::handle o, const char* name) { return nb::cast<float>(o.attr(name)); }
  static int whole(nb::handle o, const char* name) { return nb::cast<int>(nb::int_(o.attr(name))); }
  static bool truth(nb::handle o, const char* name) {
    return nb::cast<bool>(nb::bool_(o.attr(name)));
  }
  static uint32_t bits(nb::handle o, const char* name) {
    return nb::cast<uint32_t>(nb::int_(o.attr(name)));
  }
  template <size_t N>
  static std::array<float, N> reals(nb::handle o, const char* name) {
    std::array<float, N> r{};
    size_t i = 0;
    for (nb::handle v : o.attr(name)) {
      if (i == N) {
        break;
      }
      r[i++] = nb::cast<float>(nb::float_(v));
    }
    return r;
  }
  static Vec3f vector(nb::handle o, const char* name) {
    const auto v = reals<3>(o, name);
    return {v[0], v[1], v[2]};
  }

  // The array's memory, which stays alive as long as the result. None: empty.
  template <typename T>
  std::span<const T> view(nb::handle o, const char* name) {
    nb::object value = o.attr(name);
    if (value.is_none()) {
      return {};
    }
    const auto array = nb::cast<nb::ndarray<const T, nb::c_contig, nb::device::cpu>>(value, false);
    result_.owners.push_back(std::move(value));
    return {array.data(), array.size()};
  }
  Transform transform(nb::handle o) {
    Transform t;
    const auto m = view<float>(o, "transform");
    if (m.size() != t.m.size()) {
      throw std::invalid_argument("a transform has 3 rows of 4 numbers");
    }
    std::copy(m.begin(), m.end(), t.m.begin());
    return t;
  }

  MeshDesc read_mesh(nb::handle o) {
    MeshDesc m;
    m.name = text(o, "name");
    m.positions = view<float>(o, "positions");
    m.corner_vertices = view<int32_t>(o, "corner_vertices");
    m.face_offsets = view<int32_t>(o, "face_offsets");
    m.face_materials = view<int32_t>(o, "face_materials");
    m.normal_domain = static_cast<Domain>(whole(o, "normal_domain"));
    m.normals = view<float>(o, "normals");
    for (nb::handle a : o.attr("attributes")) {
      AttributeDesc attribute;
      attribute.name = text(a, "name");
      attribute.domain = static_cast<Domain>(whole(a, "domain"));
      attribute.data = view<float>(a, "data");
      attribute.channels = nb::cast<int>(a.attr("data").attr("shape")[nb::int_(1)]);
      m.attributes.push_back(attribute);
    }
    m.texture_space_min = vector(o, "texture_space_min");
    m.texture_space_max = vector(o, "texture_space_max");
    m.active_uv = text(o, "active_uv");
    m.active_color = text(o, "active_color");
    return m;
  }

  InstancesDesc read_instances(nb::handle o) {
    return {view<int32_t>(o, "mesh"),        view<float>(o, "transform"),
            view<uint32_t>(o, "visibility"), view<int32_t>(o, "material_set"),
            view<float>(o, "random"),        view<int32_t>(o, "object")};
  }

  static ObjectDesc read_object(nb::handle o) {
    ObjectDesc d;
    d.name = text(o, "name");
    d.color = reals<4>(o, "color");
    d.location = reals<3>(o, "location");
    d.pass_index = real(o, "pass_index");
    d.shadow_catcher = truth(o, "shadow_catcher");
    d.holdout = truth(o, "holdout");
    return d;
  }

  ImageDesc read_image(nb::handle o) {
    ImageDesc image;
    image.name = text(o, "name");
    image.encoding = text(o, "encoding") == "srgb" ? ImageEncoding::kSrgb : ImageEncoding::kLinear;
    const string alpha = text(o, "alpha");
    image.alpha = alpha == "PREMUL"           ? AlphaMode::kPremultiplied
                  : alpha == "CHANNEL_PACKED" ? AlphaMode::kChannelPacked
                  : alpha == "NONE"           ? AlphaMode::kNone
                                              : AlphaMode::kStraight;
    nb::object pixels = o.attr("pixels");
    if (pixels.is_none()) {
      return image;
    }
    const auto array = nb::cast<nb::ndarray<nb::ro, nb::c_contig, nb::device::cpu>>(pixels, false);
    image.height = static_cast<int32_t>(array.shape(0));
    image.width = static_cast<int32_t>(array.shape(1));
    image.channels = static_cast<int32_t>(array.shape(2));
    image.type = array.dtype() == nb::dtype<uint8_t>() ? PixelType::kUint8 : PixelType::kFloat32;
    image.pixels = {static_cast<const std::byte*>(array.data()), array.nbytes()};
    result_.owners.push_back(std::move(pixels));
    return image;
  }

  LightDesc read_light(nb::handle o) {
    LightDesc l;
    l.name = text(o, "name");
    const string kind = text(o, "kind");
    l.kind = kind == "SPOT"   ? LightKind::kSpot
             : kind == "SUN"  ? LightKind::kSun
             : kind == "AREA" ? LightKind::kArea
                              : LightKind::kPoint;
    l.transform = transform(o);
    l.emission = vector(o, "emission");
    l.normalize = truth(o, "normalize");
    l.radius = real(o, "radius");
    l.soft_falloff = truth(o, "soft_falloff");
    l.spot_angle = real(o, "spot_angle");
    l.spot_blend = real(o, "spot_blend");
    l.shape = text(o, "shape") == "ELLIPSE" ? AreaShape::kEllipse : AreaShape::kRectangle;
    l.size_x = real(o, "size_x");
    l.size_y = real(o, "size_y");
    l.spread = real(o, "spread");
    l.sun_angle = real(o, "sun_angle");
    l.visibility = bits(o, "visibility");
    l.cast_shadow = truth(o, "cast_shadow");
    l.use_mis = truth(o, "use_mis");
    l.graph = graph_from_python(o.attr("graph"));
    return l;
  }

  bool with_identities_;
  BorrowedDescription result_;
};

}  // namespace

BorrowedDescription description_from_python(nb::handle description, bool with_identities) {
  return Reader(with_identities).read(description);
}

CameraDesc camera_from_python(nb::handle camera) { return Reader(false).read_camera(camera); }

FilmDesc film_from_python(nb::handle film) { return Reader::read_film(film); }

}  // namespace vernier
