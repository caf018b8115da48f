// Every setting of a render, and the table that declares each once.
//
// The table's rows feed the add-on's properties, the command line, the checks here and the tests.
// A few of them are no settings of the session but describe the film: users find them beside the
// others, the add-on writes them into the scene description, and nothing else tells the core.
#pragma once

#include <cstdint>
#include <map>
#include <span>
#include <string>
#include <string_view>
#include <variant>

namespace vernier {

enum class IntegratorKind : int {
  kPath,
  kWhitted,
  kLight,
  kBdpt,
  kVcm,
  kPssmlt,
  kMmlt,
  kPhoton,
  kSppm,
  kMlt,
  kAuto
};
enum class MisExponent : int { kBalance, kPower };
enum class PhotonDirect : int { kShadowRays, kPhotons };
enum class PhotonView : int { kOff, kGlobal, kCaustic };
enum class LightPathSharing : int { kAuto, kNever, kAlways };
enum class DirectLight : int { kMis, kLight, kBsdf, kUniform, kMixture };

struct Settings {
  // Of whoever names none. Users start with Auto: the table's default.
  int integrator = static_cast<int>(IntegratorKind::kPath);
  int samples = 128;
  double time_limit = 0.0;
  double target_error = 0.0;  // in percent
  int adaptive = 1;
  int seed = 0;
  int threads = 0;
  int direct_light = static_cast<int>(DirectLight::kMis);
  double light_fraction = 0.1;
  double roulette_threshold = 0.25;
  int roulette_start = 0;
  int max_bounces = -1;
  int diffuse_bounces = -1;
  int glossy_bounces = -1;
  int transmission_bounces = -1;
  int transparent_bounces = -1;
  double clamp_direct = 0.0;
  double clamp_indirect = 0.0;
  int whitted_depth = 16;
  int mis_heuristic = static_cast<int>(MisExponent::kPower);
  int share_light_paths = static_cast<int>(LightPathSharing::kAuto);
  int only_light_vertices = -1;
  int only_camera_vertices = -1;
  int unweighted = 0;
  int vcm_connections = 1;
  int vcm_merging = 1;
  double merge_radius = 2.0;
  double merge_alpha = 0.75;
  int separate_direct = 1;
  double large_steps = 0.0;
  int chain_length = 256;
  int global_photons = 100000;
  int caustic_photons = 100000;
  int photon_neighbours = 50;
  double photon_most_radius = 32.0;
  int final_gather_rays = 0;
  int photon_view = static_cast<int>(PhotonView::kOff);
  int photon_direct = static_cast<int>(PhotonDirect::kShadowRays);
  int photon_kernel = 0;
  double photon_radius = 2.0;
  double photon_alpha = 2.0 / 3.0;
  int photon_paths = 0;
};

struct EnumItem {
  std::string_view identifier, label, description;
};

using SettingValue = std::variant<int64_t, double, std::string>;

enum class ParameterType : uint8_t { kInteger, kReal, kEnum };

// One row of the table. It has one of the two members, or none where it describes the film.
struct Parameter {
  std::string_view name, group, label, description, unit;
  ParameterType type = ParameterType::kReal;
  double initial = 0;  // the default; of an enum: the number of its item
  int Settings::* integer = nullptr;
  double Settings::* real = nullptr;
  double minimum = 0, maximum = 0;            // of what is accepted
  double soft_minimum = 0, soft_maximum = 0;  // of a slider
  std::span<const EnumItem> items = {};

  bool of_film() const { return integer == nullptr && real == nullptr; }
};

std::span<const Parameter> parameters();

// Sets members by name: enums by identifier. Throws std::invalid_argument, in one sentence that
// names the setting, for an unknown name, one that describes the film, a value of the wrong type
// or one out of range.
Settings make_settings(const std::map<std::string, SettingValue>& values);

}  // namespace vernier
