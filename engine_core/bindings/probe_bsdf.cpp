// Test-only functions over arrays: BSDFs built from named parameters, evaluated and sampled.
#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>
#include <nanobind/stl/string.h>

#include <stdexcept>
#include <string>

#include "bindings/table.h"
#include "bsdf/bsdf.h"

namespace nb = nanobind;

namespace vernier {
namespace {

using Array = nb::ndarray<const float, nb::c_contig, nb::device::cpu>;

Vec3f vec3(nb::handle h) {
  nb::sequence s = nb::cast<nb::sequence>(h);
  return {nb::cast<float>(s[0]), nb::cast<float>(s[1]), nb::cast<float>(s[2])};
}

// Reads options from a dict; every key must be used.
class Options {
 public:
  explicit Options(nb::dict d) : d_(d) {}
  template <typename T>
  void operator()(const char* key, T& value) {
    if (d_.contains(key)) {
      ++used_;
      if constexpr (std::is_same_v<T, Vec3f>) {
        value = vec3(d_[key]);
      } else {
        value = nb::cast<T>(d_[key]);
      }
    }
  }
  void operator()(const char* key, ThinFilm& film) {
    if (d_.contains(key)) {
      ++used_;
      film.thickness = nb::cast<float>(nb::object(d_[key][nb::int_(0)]));
      film.ior = nb::cast<float>(nb::object(d_[key][nb::int_(1)]));
    }
  }
  void operator()(const char* key, Distribution& value) {
    std::string name;
    (*this)(key, name);
    if (name == "GGX") {
      value = Distribution::kGgx;
    } else if (name == "MULTI_GGX") {
      value = Distribution::kMultiGgx;
    } else if (name == "BECKMANN") {
      value = Distribution::kBeckmann;
    } else if (name == "ASHIKHMIN_SHIRLEY") {
      value = Distribution::kAshikhminShirley;
    } else if (!name.empty()) {
      throw std::invalid_argument("unknown distribution " + name);
    }
  }
  void done(const std::string& kind) const {
    if (used_ != d_.size()) {
      throw std::invalid_argument("unknown parameter of " + kind);
    }
  }

 private:
  nb::dict d_;
  size_t used_ = 0;
};

PrincipledParams principled(Options& o) {
  PrincipledParams p;
  o("multi_scatter", p.multi_scatter), o("thin_wall", p.thin_wall);
  o("base_color", p.base_color), o("metallic", p.metallic), o("roughness", p.roughness);
  o("ior", p.ior), o("alpha", p.alpha), o("diffuse_roughness", p.diffuse_roughness);
  o("subsurface_weight", p.subsurface_weight);
  o("subsurface_anisotropy", p.subsurface_anisotropy);
  o("specular_ior_level", p.specular_ior_level), o("specular_tint", p.specular_tint);
  o("anisotropic", p.anisotropic), o("anisotropic_rotation", p.anisotropic_rotation);
  o("tangent", p.tangent), o("transmission_weight", p.transmission_weight);
  o("coat_weight", p.coat_weight), o("coat_roughness", p.coat_roughness);
  o("coat_ior", p.coat_ior), o("coat_tint", p.coat_tint), o("coat_normal", p.coat_normal);
  o("sheen_weight", p.sheen_weight), o("sheen_roughness", p.sheen_roughness);
  o("sheen_tint", p.sheen_tint), o("emission_color", p.emission_color);
  o("emission_strength", p.emission_strength), o("film", p.film);
  return p;
}

// Adds the closure of one description: {"kind", "weight", "normal", parameters...}.
void add_closure(Bsdf& bsdf, nb::dict description, Vec3f ns) {
  Options o(description);
  std::string kind;
  Color weight{1, 1, 1};
  Vec3f normal = ns;
  o("kind", kind), o("weight", weight), o("normal", normal);
  normal = normalize(normal);
  if (kind == "diffuse") {
    DiffuseParams p;
    o("roughness", p.roughness), o("color", p.color);
    bsdf.add_diffuse(weight, normal, p);
  } else if (kind == "translucent") {
    bsdf.add_translucent(weight, normal);
  } else if (kind == "transparent") {
    bsdf.add_transparent(weight);
  } else if (kind == "glossy") {
    GlossyParams p;
    o("distribution", p.distribution), o("roughness", p.roughness), o("anisotropy", p.anisotropy);
    o("rotation", p.rotation), o("tangent", p.tangent), o("color", p.color);
    bsdf.add_glossy(weight, normal, p);
  } else if (kind == "metallic") {
    MetallicParams p;
    o("distribution", p.distribution), o("physical", p.physical), o("base_color", p.base_color);
    o("edge_tint", p.edge_tint), o("ior", p.ior), o("extinction", p.extinction);
    o("roughness", p.roughness), o("anisotropy", p.anisotropy), o("rotation", p.rotation);
    o("tangent", p.tangent), o("film", p.film);
    bsdf.add_metallic(weight, normal, p);
  } else if (kind == "glass") {
    GlassParams p;
    o("distribution", p.distribution), o("color", p.color), o("roughness", p.roughness);
    o("ior", p.ior), o("film", p.film);
    bsdf.add_glass(weight, normal, p);
  } else if (kind == "refraction") {
    RefractionParams p;
    o("distribution", p.distribution), o("roughness", p.roughness), o("ior", p.ior);
    bsdf.add_refraction(weight, normal, p);
  } else if (kind == "sheen" || kind == "velvet") {
    float roughness = 0.5f;
    o("roughness", roughness);
    kind == "sheen" ? bsdf.add_sheen(weight, normal, roughness)
                    : bsdf.add_velvet(weight, normal, roughness);
  } else if (kind == "toon") {
    ToonParams p;
    o("glossy", p.glossy), o("size", p.size), o("smooth", p.smooth);
    bsdf.add_toon(weight, normal, p);
  } else if (kind == "principled") {
    bsdf.add_principled(weight, normal, principled(o));
  } else {
    throw std::invalid_argument("unknown closure " + kind);
  }
  o.done(kind);
}

// {"closures": [...], "ng", "ns", "backfacing"}; ng and ns are turned to wo's side, the normals
// and backfacing with them.
struct Setup {
  nb::list closures;
  Vec3f ng{0, 0, 1}, ns{0, 0, 1};
  bool backfacing = false;

  explicit Setup(nb::dict d) {
    Options o(d);
    o("ng", ng), o("ns", ns), o("backfacing", backfacing);
    closures = nb::cast<nb::list>(d["closures"]);
    ng = normalize(ng), ns = normalize(ns);
  }

  void build(Bsdf& bsdf, Vec3f wo) const {
    SurfacePoint point;
    const bool behind = dot(ng, wo) < 0.0f;
    const float sign = behind ? -1.0f : 1.0f;
    point.ng = ng * sign;
    point.ns = ns * sign;
    point.wo = wo;
    point.backfacing = backfacing != behind;
    bsdf.begin(point);
    for (nb::handle h : closures) {
      nb::dict closure = nb::cast<nb::dict>(h);
      nb::dict copy;
      for (auto [key, value] : closure) {
        copy[key] = value;
      }
      for (const char* key : {"normal", "coat_normal"}) {
        if (copy.contains(key)) {
          const Vec3f n = vec3(copy[key]) * sign;
          copy[key] = nb::make_tuple(n.x, n.y, n.z);
        }
      }
      add_closure(bsdf, copy, point.ns);
    }
    bsdf.finish();
  }
};

Vec3f row3(const Array& a, size_t i) {
  const float* p = a.data() + 3 * i;
  return {p[0], p[1], p[2]};
}

size_t rows(const Array& a, size_t columns, const char* name) {
  if (a.ndim() != 2 || a.shape(1) != columns) {
    throw std::invalid_argument(std::string(name) + " must have shape (n, " +
                                std::to_string(columns) + ")");
  }
  return a.shape(0);
}

Transport transport_of(bool importance) {
  return importance ? Transport::kImportance : Transport::kRadiance;
}

// Columns f.x f.y f.z pdf pdf_reverse for pairs of directions. wo of one row is used for all wi.
Result bsdf_eval(nb::dict setup, Array wo, Array wi, bool importance, int mask, bool forward) {
  const Setup s(setup);
  const size_t n = rows(wi, 3, "wi");
  const size_t m = rows(wo, 3, "wo");
  if (m != 1 && m != n) {
    throw std::invalid_argument("wo must have one row, or as many as wi");
  }
  Table table(n, 5);
  Bsdf bsdf;
  for (size_t i = 0; i < n; ++i) {
    if (i < m) {
      s.build(bsdf, row3(wo, i));
    }
    const auto bits = static_cast<uint8_t>(mask);
    const BsdfEval e = forward ? bsdf.eval_forward(row3(wi, i), transport_of(importance), bits)
                               : bsdf.eval(row3(wi, i), transport_of(importance), bits);
    const float values[] = {e.f.x, e.f.y, e.f.z, e.pdf, e.pdf_reverse};
    std::copy(std::begin(values), std::end(values), table.row(i));
  }
  return table.release();
}

// Columns wi.xyz weight.xyz pdf pdf_reverse eta lobe; lobe 0 where there is no sample. u: (n, 3).
Result bsdf_sample(nb::dict setup, Array wo, Array u, bool importance, int mask, bool forward) {
  const Setup s(setup);
  const size_t n = rows(u, 3, "u");
  const size_t m = rows(wo, 3, "wo");
  if (m != 1 && m != n) {
    throw std::invalid_argument("wo must have one row, or as many as u");
  }
  Table table(n, 10);
  Bsdf bsdf;
  for (size_t i = 0; i < n; ++i) {
    if (i < m) {
      s.build(bsdf, row3(wo, i));
    }
    const Vec3f r = row3(u, i);
    const auto bits = static_cast<uint8_t>(mask);
    const auto sample = forward
                            ? bsdf.sample_forward(r.x, {r.y, r.z}, transport_of(importance), bits)
                            : bsdf.sample(r.x, {r.y, r.z}, transport_of(importance), bits);
    if (sample) {
      const float values[] = {sample->wi.x,     sample->wi.y,
                              sample->wi.z,     sample->weight.x,
                              sample->weight.y, sample->weight.z,
                              sample->pdf,      sample->pdf_reverse,
                              sample->eta,      static_cast<float>(sample->lobe)};
      std::copy(std::begin(values), std::end(values), table.row(i));
    }
  }
  return table.release();
}

// What is known once wo is: emission, transparency, albedo, lobes and so on.
nb::dict bsdf_info(nb::dict setup, Array wo, int mask) {
  const Setup s(setup);
  Bsdf bsdf;
  rows(wo, 3, "wo");
  s.build(bsdf, row3(wo, 0));
  const auto tuple = [](Color c) { return nb::make_tuple(c.x, c.y, c.z); };
  nb::dict info;
  info["emission"] = tuple(bsdf.emission);
  info["transparency"] = tuple(bsdf.transparency);
  info["albedo"] = tuple(bsdf.albedo(static_cast<uint8_t>(mask)));
  info["lobes"] = static_cast<int>(bsdf.lobes());
  info["connectible"] = bsdf.connectible();
  info["mean_squared_roughness"] = bsdf.mean_squared_roughness();
  info["overflow"] = bsdf.overflow();
  return info;
}

}  // namespace

void bind_bsdf_probes(nb::module_& m) {
  m.def("bsdf_eval", &bsdf_eval, nb::arg("setup"), nb::arg("wo"), nb::arg("wi"),
        nb::arg("importance") = false, nb::arg("mask") = 255, nb::arg("forward") = false);
  m.def("bsdf_sample", &bsdf_sample, nb::arg("setup"), nb::arg("wo"), nb::arg("u"),
        nb::arg("importance") = false, nb::arg("mask") = 255, nb::arg("forward") = false);
  m.def("bsdf_info", &bsdf_info, nb::arg("setup"), nb::arg("wo"), nb::arg("mask") = 255);
}

}  // namespace vernier
