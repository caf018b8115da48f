#include "render/settings.h"

#include <array>
#include <cmath>
#include <stdexcept>

#include "scene/description.h"

namespace vernier {
namespace {

constexpr std::array kIntegrators{
    EnumItem{"PATH", "Path Tracing",
             "Paths from the camera, lights sampled at every bounce: the robust choice"},
    EnumItem{"WHITTED", "Whitted Ray Tracing",
             "Classic recursive ray tracing: shadow rays, perfect reflection and refraction only"},
    EnumItem{"LIGHT", "Light Tracing",
             "Paths from the lights alone, seen where they meet the camera: no mirror shows them"},
    EnumItem{"BDPT", "Bidirectional Path Tracing",
             "Paths from the camera and from the lights, joined in every way: for lamps in "
             "fixtures, light through narrow openings, caustics on matte surfaces"},
    EnumItem{"VCM", "Vertex Connection and Merging",
             "Bidirectional Path Tracing that also gathers the ends of all light paths nearby: for "
             "caustics seen in mirrors or through glass and water"},
    EnumItem{"PSSMLT", "Primary Sample Metropolis",
             "Chains of bidirectional samples, each a small change of the last: for light that is "
             "hard to find"},
    EnumItem{"MMLT", "Multiplexed Metropolis",
             "Chains of single paths, made from either end by the way that suits them: for light "
             "that is hard to find"},
    EnumItem{"PHOTON", "Photon Mapping",
             "Jensen's two photon maps: quick, smooth and biased; more photons bring it nearer"},
    EnumItem{"SPPM", "Progressive Photon Mapping",
             "A new photon map for every sample, its radius ever smaller: for caustics, above all "
             "those seen in mirrors and through water"},
    EnumItem{"MLT", "Metropolis Light Transport",
             "Chains of paths that are changed themselves: parts are grown anew, or moved through "
             "mirrors and glass. For light that is hard to find, caustics above all"},
    EnumItem{"AUTO", "Auto",
             "Tries the methods without bias on this scene, for a twentieth of the render at most, "
             "and takes the one that will be done first"},
};
constexpr std::array kPhotonDirect{
    EnumItem{"SHADOW_RAYS", "Shadow Rays", "Sample lights: sharp shadows"},
    EnumItem{"PHOTONS", "Photons", "Read direct light from the photons too: fast and blurred"},
};
constexpr std::array kPhotonViews{
    EnumItem{"OFF", "Off", "The picture"},
    EnumItem{"GLOBAL", "Global Map", "The photons of the global map, as dots of their colours"},
    EnumItem{"CAUSTIC", "Caustic Map", "The photons of the caustic map, as dots of their colours"},
};
// In the order of PhotonKernel.
constexpr std::array kPhotonKernels{
    EnumItem{"EPANECHNIKOV", "Epanechnikov", "A parabola: falls to zero at the radius"},
    EnumItem{"CONE", "Cone", "Jensen's cone filter: the sharpest edges, the most noise"},
    EnumItem{"CONSTANT", "Constant", "All photons alike: the least noise, the most blur"},
};
constexpr std::array kMisHeuristics{
    EnumItem{"BALANCE", "Balance", "In proportion to each technique's density"},
    EnumItem{"POWER", "Power", "In proportion to its square: sharper where one is far better"},
};
constexpr std::array kSharing{
    EnumItem{"AUTO", "Automatic", "Share them where a pilot finds that few light paths matter"},
    EnumItem{"NEVER", "Never", "Each sample's own light path"},
    EnumItem{"ALWAYS", "Always", "Those of a whole batch, chosen by their use in a pilot"},
};
constexpr std::array kDirectLight{
    EnumItem{"MIS", "Multiple Importance",
             "Sample lights and materials, and weight both by the power heuristic"},
    EnumItem{"LIGHT", "Lights", "Sample lights only"},
    EnumItem{"BSDF", "Materials", "Sample materials only: lights are found by chance"},
    EnumItem{"UNIFORM", "Uniform",
             "Sample the hemisphere evenly: the naive path tracer, for comparison"},
    EnumItem{"MIXTURE", "Mixture",
             "One sample: toward a light with a fixed probability, else by the material"},
};
// In the order of FilterKind.
constexpr std::array kFilters{
    EnumItem{"BOX", "Box", "Average over the filter's width"},
    EnumItem{"GAUSSIAN", "Gaussian", "Gaussian bell"},
    EnumItem{"BLACKMAN_HARRIS", "Blackman-Harris", "Smooth, with little ringing"},
};

constexpr double kMany = 2147483647.0;
constexpr double kManyPhotons = 1 << 28;

Parameter integer(std::string_view group, std::string_view name, int Settings::* member,
                  double minimum, double maximum, double soft_minimum, double soft_maximum,
                  std::string_view label, std::string_view description) {
  const auto initial = static_cast<double>(Settings{}.*member);
  return {name,        group,  label,   description, "",      ParameterType::kInteger,
          initial,     member, nullptr, minimum,     maximum, soft_minimum,
          soft_maximum};
}
Parameter real(std::string_view group, std::string_view name, double Settings::* member,
               double minimum, double maximum, double soft_minimum, double soft_maximum,
               std::string_view label, std::string_view description, std::string_view unit = "") {
  return {
      name,    group,  label,   description, unit,         ParameterType::kReal, Settings{}.*member,
      nullptr, member, minimum, maximum,     soft_minimum, soft_maximum};
}
Parameter choice(std::string_view group, std::string_view name, int Settings::* member,
                 std::span<const EnumItem> items, std::string_view label,
                 std::string_view description) {
  const auto last = static_cast<double>(items.size() - 1);
  const auto initial = static_cast<double>(Settings{}.*member);
  return {name, group, label, description, "",   ParameterType::kEnum, initial, member, nullptr,
          0,    last,  0,     last,        items};
}
Parameter film_choice(std::string_view name, int initial, std::span<const EnumItem> items,
                      std::string_view label, std::string_view description) {
  const auto last = static_cast<double>(items.size() - 1);
  return {name,
          "film",
          label,
          description,
          "",
          ParameterType::kEnum,
          static_cast<double>(initial),
          nullptr,
          nullptr,
          0,
          last,
          0,
          last,
          items};
}
Parameter film_real(std::string_view name, float initial, double minimum, double maximum,
                    double soft_minimum, double soft_maximum, std::string_view label,
                    std::string_view description, std::string_view unit = "") {
  return {name,
          "film",
          label,
          description,
          unit,
          ParameterType::kReal,
          static_cast<double>(initial),
          nullptr,
          nullptr,
          minimum,
          maximum,
          soft_minimum,
          soft_maximum};
}

Parameter integrator_row() {
  Parameter row = choice("sampling", "integrator", &Settings::integrator, kIntegrators,
                         "Integrator", "The method that finds the light's paths");
  row.initial = static_cast<double>(IntegratorKind::kAuto);
  return row;
}

const std::array kParameters{
    integrator_row(),
    integer("sampling", "samples", &Settings::samples, 1, 1 << 24, 1, 4096, "Samples",
            "Samples per pixel"),
    real("sampling", "time_limit", &Settings::time_limit, 0, 1e9, 0, 3600, "Time Limit",
         "Stop after this time; 0: no limit. Whichever of samples and time ends first counts", "s"),
    real("sampling", "target_error", &Settings::target_error, 0, 1000, 0, 20, "Target Error",
         "Stop when the picture's error is below this, with a confidence of 95 %; 0: no target. "
         "Whichever of samples, time and target ends first counts",
         "%"),
    integer("sampling", "adaptive", &Settings::adaptive, 0, 1, 0, 1, "Adaptive",
            "1: with a target error, spend samples where it is not reached yet. Methods that start "
            "paths at lights spend them evenly"),
    integer("sampling", "seed", &Settings::seed, 0, kMany, 0, kMany, "Seed",
            "Equal seeds give equal pictures"),
    integer("performance", "threads", &Settings::threads, 0, 1024, 0, 64, "Threads",
            "Threads to render with; 0: as many as the machine has"),
    choice("sampling", "direct_light", &Settings::direct_light, kDirectLight, "Direct Light",
           "How the light that reaches a surface directly is estimated; all agree in the limit"),
    real("sampling", "light_fraction", &Settings::light_fraction, 0.001, 0.999, 0.01, 0.99,
         "Light Fraction", "Probability of sampling toward a light with the mixture estimator"),
    real("light_paths", "roulette_threshold", &Settings::roulette_threshold, 0, 1e6, 0, 1,
         "Roulette Threshold",
         "Paths that carry less than this may be ended by chance, without bias; from the third "
         "bounce on it grows by half with each, up to 1; 0: none, but after 1024 bounces where no "
         "limit ends them"),
    integer("light_paths", "roulette_start", &Settings::roulette_start, 0, 1 << 16, 0, 16,
            "Roulette Start", "Bounces before Russian roulette begins"),
    integer("light_paths", "max_bounces", &Settings::max_bounces, -1, 1 << 16, -1, 64,
            "Total Bounces",
            "Most bounces; 0: direct light only; -1: no limit, roulette alone ends a path"),
    integer("light_paths", "diffuse_bounces", &Settings::diffuse_bounces, -1, 1 << 16, -1, 64,
            "Diffuse Bounces", "Most diffuse reflections on a path; -1: no limit"),
    integer("light_paths", "glossy_bounces", &Settings::glossy_bounces, -1, 1 << 16, -1, 64,
            "Glossy Bounces", "Most glossy reflections on a path; -1: no limit"),
    integer("light_paths", "transmission_bounces", &Settings::transmission_bounces, -1, 1 << 16, -1,
            64, "Transmission Bounces", "Most transmissions on a path; -1: no limit"),
    integer("light_paths", "transparent_bounces", &Settings::transparent_bounces, -1, 1 << 16, -1,
            64, "Transparent Bounces", "Most transparent surfaces passed; -1: no limit"),
    real("light_paths", "clamp_direct", &Settings::clamp_direct, 0, 1e9, 0, 100, "Clamp Direct",
         "Biased: limits what one sample adds to direct light; 0: off"),
    real("light_paths", "clamp_indirect", &Settings::clamp_indirect, 0, 1e9, 0, 100,
         "Clamp Indirect", "Biased: limits what one sample adds to indirect light; 0: off"),
    integer("light_paths", "whitted_depth", &Settings::whitted_depth, 1, 64, 1, 32,
            "Recursion Depth", "Deepest recursion of Whitted ray tracing"),
    choice("bidirectional", "mis_heuristic", &Settings::mis_heuristic, kMisHeuristics,
           "MIS Heuristic", "How the techniques that find one path share it"),
    choice("bidirectional", "share_light_paths", &Settings::share_light_paths, kSharing,
           "Share Light Paths", "Which light paths a camera path is joined to"),
    integer("bidirectional", "only_light_vertices", &Settings::only_light_vertices, -1, 1 << 16, -1,
            16, "Light Vertices",
            "Show only the techniques with this many vertices from the light; -1: all"),
    integer("bidirectional", "only_camera_vertices", &Settings::only_camera_vertices, -1, 1 << 16,
            -1, 16, "Camera Vertices",
            "Show only the techniques with this many vertices from the camera; -1: all"),
    integer("bidirectional", "unweighted", &Settings::unweighted, 0, 1, 0, 1, "Unweighted",
            "1: leave out the weights, so that each technique alone shows all light that it can "
            "find. With more than one technique the picture is then too bright"),
    integer("merging", "vcm_connections", &Settings::vcm_connections, 0, 1, 0, 1, "Connections",
            "With Vertex Connection and Merging, 1: join paths; 0: gather only, which is "
            "bidirectional photon mapping"),
    integer("merging", "vcm_merging", &Settings::vcm_merging, 0, 1, 0, 1, "Merging",
            "With Vertex Connection and Merging, 1: gather the ends of light paths nearby; 0: join "
            "only, which is Bidirectional Path Tracing"),
    real("merging", "merge_radius", &Settings::merge_radius, 0, 1000, 0.25, 8, "Merging Radius",
         "Radius within which ends of light paths are gathered in the first sample, in radii of a "
         "pixel as it covers the surfaces that the camera sees, the median of them. Biased: light "
         "is blurred so far, and less with every sample; 0: gathers none",
         "px"),
    real("merging", "merge_alpha", &Settings::merge_alpha, 0, 1, 0.5, 1, "Radius Alpha",
         "How the radius shrinks: its square goes with the number of the sample to the power of "
         "this less 1. Smaller: less bias, more noise; 1: never shrinks"),
    integer("metropolis", "separate_direct", &Settings::separate_direct, 0, 1, 0, 1,
            "Separate Direct Light",
            "1: direct light is sampled as in path tracing, and the chains have the rest; 0: the "
            "chains find direct light too"),
    real("metropolis", "large_steps", &Settings::large_steps, 0, 1, 0, 0.9, "Large Steps",
         "The part of mutations that leave the path for a new one; 0: as suits the method"),
    integer("metropolis", "chain_length", &Settings::chain_length, 1, 1 << 24, 64, 65536,
            "Chain Length", "Mutations after which a chain starts anew"),
    choice("photons", "photon_direct", &Settings::photon_direct, kPhotonDirect, "Direct Light",
           "Where light that comes straight from lights is taken from"),
    choice("photons", "photon_kernel", &Settings::photon_kernel, kPhotonKernels, "Kernel",
           "How photons count by their distance"),
    integer("photons", "global_photons", &Settings::global_photons, 0, kManyPhotons, 0, 2000000,
            "Global Photons", "Photons in the global map, at least; 0: no such map"),
    integer("photons", "caustic_photons", &Settings::caustic_photons, 0, kManyPhotons, 0, 2000000,
            "Caustic Photons", "Photons in the caustic map, at least; 0: no such map"),
    integer("photons", "photon_neighbours", &Settings::photon_neighbours, 2, 100000, 10, 500,
            "Nearest Photons", "How many of the nearest photons tell the light at a point"),
    real("photons", "photon_most_radius", &Settings::photon_most_radius, 0.01, 1e6, 1, 200,
         "Largest Radius",
         "Photons farther away do not count. In pixels, as wide as they are there", "px"),
    integer("photons", "final_gather_rays", &Settings::final_gather_rays, 0, 65536, 0, 256,
            "Final Gather Rays",
            "Rays from each point, at whose ends the maps are asked; 0: at the point itself"),
    choice("photons", "photon_view", &Settings::photon_view, kPhotonViews, "Show Photons",
           "Show a photon map itself instead of the picture"),
    real("photons", "photon_radius", &Settings::photon_radius, 0.01, 1e6, 0.5, 10, "First Radius",
         "Progressive photon mapping begins with this radius, in pixels as wide as they are there",
         "px"),
    real("photons", "photon_alpha", &Settings::photon_alpha, 0.01, 1, 0.5, 1, "Shrinking",
         "How the radius shrinks: less is faster, and leaves more noise and less blur; 1: not at "
         "all"),
    integer("photons", "photon_paths", &Settings::photon_paths, 0, kManyPhotons, 0, 4000000,
            "Paths per Pass",
            "Paths from lights in a pass of progressive photon mapping; 0: one for each pixel"),
    film_choice("pixel_filter", static_cast<int>(FilmDesc{}.filter), kFilters, "Pixel Filter",
                "Shape of the reconstruction filter"),
    film_real("filter_width", FilmDesc{}.filter_width, 0.01, 10, 0.5, 4, "Filter Width",
              "Width of the pixel filter", "px"),
    film_real("film_exposure", FilmDesc{}.exposure, 0, 1e6, 0, 10, "Exposure",
              "Multiplies the picture's brightness"),
};

std::string format(double v) {
  std::string text = std::to_string(v);
  text.erase(text.find_last_not_of('0') + 1);
  if (text.back() == '.') {
    text.pop_back();
  }
  return text;
}

double enum_value(const Parameter& p, const std::string& identifier) {
  std::string known;
  for (size_t i = 0; i < p.items.size(); ++i) {
    if (p.items[i].identifier == identifier) {
      return static_cast<double>(i);
    }
    known += (i == 0 ? "" : ", ") + std::string(p.items[i].identifier);
  }
  throw std::invalid_argument("setting " + std::string(p.name) + ": '" + identifier +
                              "' is not one of " + known);
}

double number_value(const Parameter& p, const SettingValue& value) {
  if (const auto* text = std::get_if<std::string>(&value)) {
    if (p.type == ParameterType::kEnum) {
      return enum_value(p, *text);
    }
    throw std::invalid_argument("setting " + std::string(p.name) + ": '" + *text +
                                "' is not a number");
  }
  if (p.type == ParameterType::kEnum) {
    throw std::invalid_argument("setting " + std::string(p.name) +
                                " takes one of its identifiers, not a number");
  }
  if (const auto* whole = std::get_if<int64_t>(&value)) {
    return static_cast<double>(*whole);
  }
  const double v = std::get<double>(value);
  if (p.type == ParameterType::kInteger && v != std::floor(v)) {
    throw std::invalid_argument("setting " + std::string(p.name) + ": " + format(v) +
                                " is not a whole number");
  }
  return v;
}

}  // namespace

std::span<const Parameter> parameters() { return kParameters; }

Settings make_settings(const std::map<std::string, SettingValue>& values) {
  Settings settings;
  for (const auto& [name, value] : values) {
    const Parameter* row = nullptr;
    for (const Parameter& p : kParameters) {
      row = p.name == name ? &p : row;
    }
    if (row == nullptr) {
      throw std::invalid_argument("there is no setting named " + name);
    }
    if (row->of_film()) {
      throw std::invalid_argument("setting " + name +
                                  " describes the film: the scene description has it");
    }
    const double v = number_value(*row, value);
    if (!(v >= row->minimum && v <= row->maximum)) {
      throw std::invalid_argument("setting " + name + ": " + format(v) + " is outside " +
                                  format(row->minimum) + " to " + format(row->maximum));
    }
    if (row->integer != nullptr) {
      settings.*(row->integer) = static_cast<int>(v);
    } else {
      settings.*(row->real) = v;
    }
  }
  return settings;
}

}  // namespace vernier
