#include "integrators/bidirectional_plan.h"

#include <algorithm>
#include <vector>

#include "integrators/bidirectional_tracer.h"

namespace vernier {
namespace {

// Samples of the pilot: enough to tell the lights apart, a small part of any picture.
constexpr uint32_t kPilotSamples = 4096;
constexpr int kLog2PilotSamples = 12;
// A contribution is small where it is below this part of the picture's mean.
constexpr double kSmallPart = 0.1;
// The part of the choice of lights that goes by their power all the same: a pilot has not seen all.
constexpr double kByPower = 0.25;
// The part of distant lights' rays that is aimed.
constexpr float kAimed = 0.75f;
// Of the points that the camera's paths visit, those that the aim covers.
constexpr double kCovered = 0.98;

// Adds up what each light does for the picture.
struct LightTally {
  std::vector<double> by_light;
  double total = 0.0;

  void found(const FoundPath& path) {
    const auto amount = static_cast<double>(max_component(path.contribution));
    total += amount;
    if (path.light < by_light.size()) {
      by_light[path.light] += amount;
    }
  }
};

// Aims at a sphere about the points, but for the outermost.
void aim_at(std::vector<Vec3f>& points, const Scene& scene, EmissionGuide& guide) {
  if (points.empty()) {
    return;
  }
  for (int axis = 0; axis < 3; ++axis) {
    const auto middle = points.begin() + static_cast<ptrdiff_t>(points.size() / 2);
    std::nth_element(points.begin(), middle, points.end(),
                     [&](const Vec3f& a, const Vec3f& b) { return a[axis] < b[axis]; });
    guide.center[axis] = (*middle)[axis];
  }
  const auto last =
      points.begin() + static_cast<ptrdiff_t>(kCovered * static_cast<double>(points.size() - 1));
  std::nth_element(points.begin(), last, points.end(), [&](const Vec3f& a, const Vec3f& b) {
    return length_squared(a - guide.center) < length_squared(b - guide.center);
  });
  guide.radius = length(*last - guide.center);
  guide.share = guide.radius > 0.0f && guide.radius < scene.radius ? kAimed : 0.0f;
}

// Chooses lights by what the pilot saw them do. Never 0 where it was not, and 0 where it was.
void choose_by(const LightTally& tally, EmissionGuide& guide) {
  double attributed = 0.0;
  for (const double amount : tally.by_light) {
    attributed += amount;
  }
  if (!(attributed > 0.0)) {
    return;
  }
  std::vector<double> weights(tally.by_light.size());
  for (uint32_t light = 0; light < weights.size(); ++light) {
    const auto by_power = static_cast<double>(guide.lights.probability(light));
    const double seen = tally.by_light[light] / attributed;
    weights[light] = by_power > 0.0 ? seen + kByPower * (by_power - seen) : 0.0;
  }
  guide.lights = AliasTable(weights);
}

}  // namespace

std::unique_ptr<const Plan> make_bidirectional_plan(const RenderContext& context, uint64_t seed,
                                                    RenderStats& stats) {
  const Scene& scene = context.scene;
  auto plan = std::make_unique<BidirectionalPlan>();
  plan->guide = scene.lights->guide_by_power();
  RenderContext pilot = context;
  pilot.plan = plan.get();
  BidirectionalMemory memory;
  LightTally tally{std::vector<double>(scene.lights->count())};
  NoPassSample no_passes;
  std::vector<Vec3f> points;
  const std::array<int32_t, 4>& crop = scene.film.crop;
  for (uint32_t i = 0; i < kPilotSamples && !context.cancelled; ++i) {
    // A sequence of its own: no sample of the picture sees these numbers.
    const SobolSampler sampler(0, 0, i, kLog2PilotSamples, hash64(~seed));
    const Vec2f u = sampler.get_2d(dimension(CameraDim::kFilter));
    const Vec2f raster{lerp(static_cast<float>(crop[0]), static_cast<float>(crop[2]), u.x),
                       lerp(static_cast<float>(crop[1]), static_cast<float>(crop[3]), u.y)};
    const CameraRay ray =
        scene.camera->generate_ray(raster, sampler.get_2d(dimension(CameraDim::kLens)));
    BidirectionalTracer<BidirectionalFeatures{false, true}, LightTally>(
        pilot, sampler, stats, nullptr, no_passes, memory, tally)
        .run(ray);
    for (uint32_t v = 0; v < memory.camera.size() && memory.camera[v].point.depth.total <= 1; ++v) {
      points.push_back(memory.camera[v].point.p);
    }
  }
  if (tally.total > 0.0) {
    plan->inverse_threshold = static_cast<float>(kPilotSamples / (kSmallPart * tally.total));
    choose_by(tally, plan->guide);
    aim_at(points, scene, plan->guide);
  }
  return plan;
}

}  // namespace vernier
