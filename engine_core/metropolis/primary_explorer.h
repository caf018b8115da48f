// Evaluates points of primary-sample space: a whole bidirectional sample (PSSMLT; Kelemen et al.
// 2002), or one of its techniques (MMLT; Hachisuka, Kaplanyan and Dachsbacher 2014, "Multiplexed
// Metropolis Light Transport").
#pragma once

#include <algorithm>

#include "bidirectional/tracer.h"
#include "metropolis/contribution.h"
#include "metropolis/guided_paths.h"
#include "metropolis/metropolis_plan.h"
#include "metropolis/metropolis_step.h"
#include "metropolis/primary_sample.h"

namespace vernier {

// The raster of a sample that is uniform over the frame and as far beyond as filters reach.
class FilmSpace {
 public:
  FilmSpace(const FilmDesc& film, const PixelFilter2d& filter)
      : first_{static_cast<float>(film.crop[0]) - filter.radius(),
               static_cast<float>(film.crop[1]) - filter.radius()},
        size_{static_cast<float>(film.crop[2] - film.crop[0]) + 2.0f * filter.radius(),
              static_cast<float>(film.crop[3] - film.crop[1]) + 2.0f * filter.radius()},
        share_(static_cast<double>(size_.x) * static_cast<double>(size_.y) /
               (static_cast<double>(film.crop[2] - film.crop[0]) *
                static_cast<double>(film.crop[3] - film.crop[1]))) {}

  Vec2f raster(Vec2f u) const { return {first_.x + size_.x * u.x, first_.y + size_.y * u.y}; }
  bool contains(Vec2f raster) const {
    return raster.x >= first_.x && raster.y >= first_.y && raster.x <= first_.x + size_.x &&
           raster.y <= first_.y + size_.y;
  }
  // Its area over that of the pixels.
  double share() const { return share_; }

 private:
  Vec2f first_, size_;
  double share_;
};

// The technique that goes by the guide, as a splat names it: s, and the number of vertices less s
// for t.
inline constexpr int kGuidedTechnique = -1;

// Collects what a tracer finds.
template <class Hook>
struct SplatObserver {
  Contribution& out;
  const MetropolisPlan& plan;
  const FilmSpace& film;
  const LightSampler* held;  // null: chains explore all paths; else those that PathSpace holds
  const GuidedPaths& guided;
  const Subpath& camera_path;
  Hook& hook;          // told of every splat
  Vec2f raster;        // of the camera's path
  float camera_scale;  // of what it finds
  float scale;         // of all

  void emitted(const EmissionSample&) {}
  void found(const FoundPath& path) {
    const float left = guided.any() ? guided.left(camera_path, path) : 1.0f;
    add(path, left, path.s, path.t);
  }
  // By the guide: a technique of its own.
  void went_on(const FoundPath& path) { add(path, 1.0f, kGuidedTechnique, path.t + 1); }
  void add(const FoundPath& path, float part, int s, int t);
};

struct NoHook {
  void operator()(const FoundPath&) const {}
};

// Whether paths that end on the light can be held as values: others are left to independent
// samples.
inline bool holds_paths(const LightSampler& lights, uint32_t light) {
  return light != kNoIndex && lights.is_plain(light) &&
         (lights.is_delta(light) || lights.is_hittable(light));
}

template <class Hook>
void SplatObserver<Hook>::add(const FoundPath& path, float part, int s, int t) {
  const Vec2f where = path.t == 1 ? path.raster : raster;
  if (!film.contains(where)) {
    return;  // it reaches no pixel
  }
  const bool explored = held == nullptr || holds_paths(*held, path.light);
  const size_t before = out.splats.size();
  out.add(where, path.contribution * (part * (path.t == 1 ? scale : camera_scale)),
          explored ? plan.worth(where) : 0.0f, s, t);
  if (out.splats.size() > before) {
    hook(path);
  }
}

// Chains of whole paths count each by what it carries: nothing is clamped.
inline Settings unclamped(Settings settings) {
  settings.clamp_direct = settings.clamp_indirect = 0.0;
  return settings;
}

// Evaluates whole bidirectional samples: the independent ones of all Metropolis methods.
class PrimaryEvaluator {
 public:
  // `whole_paths`: chains hold paths themselves, and not the numbers that they are made from.
  PrimaryEvaluator(const RenderContext& context, RenderStats& stats, bool whole_paths = false)
      : settings_(whole_paths ? unclamped(context.settings) : context.settings),
        context_{context.scene,     settings_,    context.filter,
                 context.cancelled, context.plan, context.light_pass},
        stats_(stats),
        plan_(static_cast<const MetropolisPlan&>(*context.plan)),
        held_(whole_paths ? context.scene.lights.get() : nullptr),
        film_(context.scene.film, context.filter),
        guided_(context_, plan_.caustics),
        techniques_(context.settings, context.scene.requirements) {
    techniques_.least = least_chain_vertices(context.settings);
    techniques_.only_s = techniques_.only_t = -1;
    techniques_.weighted = true;
  }

  // Evaluates the independent point that `source` makes.
  // `hook` is told of each splat's path, while memory() has it.
  template <class Hook = NoHook>
  void sample(const SobolSampler& source, Contribution& out, Hook&& hook = {}) {
    samples_.begin(source);
    evaluate(techniques_, 1.0, out, true, hook);
    out.independent_target = out.target;
  }

  // Tells of the chain that begins: its number within its batch, and a seed that the batch's chains
  // share.
  void begin_chain(uint64_t /*number*/, uint64_t /*seed*/) {}

  PrimaryEvaluator(const PrimaryEvaluator&) = delete;
  PrimaryEvaluator& operator=(const PrimaryEvaluator&) = delete;

  // The path that the camera and the light have made last.
  const BidirectionalMemory& memory() const { return memory_; }

 protected:
  // Evaluates the proposal; what is found counts `scale` times. `go_on`: the guide's technique is
  // one of them, for paths of `length` vertices (-1: any).
  template <class Hook = NoHook>
  void evaluate(const TechniqueSet& techniques, double scale, Contribution& out, bool go_on,
                Hook&& hook = {}, int length = -1) {
    out.clear();
    const PrimarySampler sampler(samples_);
    const Camera& camera = *context_.scene.camera;
    using Observer = SplatObserver<std::remove_reference_t<Hook>>;
    Observer observer{out,
                      plan_,
                      film_,
                      held_,
                      guided_,
                      memory_.camera,
                      hook,
                      {},
                      static_cast<float>(scale * film_.share()),
                      static_cast<float>(scale)};
    CameraRay ray;
    if (techniques.most_camera_bounces >= 0) {
      observer.raster = film_.raster(sampler.get_2d(dimension(CameraDim::kFilter)));
      ray = camera.generate_ray(observer.raster, camera.is_pinhole()
                                                     ? Vec2f{}
                                                     : sampler.get_2d(dimension(CameraDim::kLens)));
    }
    NoPassSample no_passes;
    BidirectionalTracer<BidirectionalFeatures{false, true}, Observer, PrimarySampler>(
        context_, sampler, stats_, nullptr, no_passes, memory_, observer, techniques)
        .run(ray);
    if (go_on && guided_.any()) {
      guided_.make(memory_.camera, sampler, stats_, length,
                   [&](const FoundPath& path) { observer.went_on(path); });
    }
    ++stats_.camera_paths;
  }

  const Settings settings_;
  const RenderContext context_;
  RenderStats& stats_;
  const MetropolisPlan& plan_;
  const LightSampler* held_;
  const FilmSpace film_;
  const GuidedPaths guided_;
  TechniqueSet techniques_;  // of whole samples
  BidirectionalMemory memory_;
  PrimarySamples samples_;
};

// What chains in primary-sample space have in common.
class PrimaryExplorer : public PrimaryEvaluator {
 public:
  using State = Contribution;
  static constexpr bool kWholePaths = false;
  // Measured by error at equal time, where light comes through a door left ajar and from fixtures.
  static constexpr double kPoolShare = 0.25, kLargeSteps = 0.25;

  using PrimaryEvaluator::PrimaryEvaluator;

  // Starts to draw independent points alone.
  void start(Pcg32& rng) { samples_.seed(rng.next()); }
  float random() { return samples_.random(); }
};

// Chains of whole samples.
class SampleExplorer : public PrimaryExplorer {
 public:
  // Whether large steps are samples as independent as those of the pool.
  static constexpr bool kIndependentSteps = true;

  using PrimaryExplorer::PrimaryExplorer;
  using PrimaryExplorer::start;

  // Starts a chain at the independent sample of `source`, by replaying it, and returns that
  // sample's target. The numbers of the chain's mutations come from `rng`, as does a choice among
  // several starts.
  double start(const SobolSampler& source, Pcg32& rng, MarkovChain<State>& chain) {
    sample(source, chain.current);
    samples_.accept();
    samples_.seed(rng.next());
    return chain.current.target;
  }

  // Proposes a mutation; the ratio of the densities of the way back and there is returned. `large`:
  // the proposal does not depend on where the chain is.
  double propose(MarkovChain<State>& chain, bool large) {
    samples_.propose(large);
    evaluate(techniques_, 1.0, chain.proposed, true);
    chain.proposed.independent_target = chain.proposed.target;
    return 1.0;
  }
  void accept() { samples_.accept(); }

  // How much of each splat is left to independent samples, of which there are `half` per unit of
  // the chain's target; see ChainShare.
  template <class Share>
  static void share_independent(const Share& share, Contribution& c) {
    const auto part = static_cast<float>(share.independent(c.target));
    for (Splat& splat : c.splats) {
      splat.color *= part;
    }
  }
};

// Chains of single techniques: the numbers of vertices from the light and the camera are part of
// the state. The number of all changes in large steps alone, as from one to another nothing is
// kept.
class TechniqueExplorer : public PrimaryExplorer {
 public:
  static constexpr bool kIndependentSteps = false;

  using PrimaryExplorer::PrimaryExplorer;
  using PrimaryExplorer::start;

  double start(const SobolSampler& source, Pcg32& rng, MarkovChain<State>& chain) {
    Contribution& at = chain.current;
    sample(source, at);
    const double target = at.target;
    const float u = rng.next_float();
    if (target > 0.0) {
      // One of the techniques, in proportion to its part of the sample.
      const Splat chosen = at.splats[at.choose(u)];
      length_ = chosen.s + chosen.t;
      const int count = techniques_of(length_);
      samples_.begin(source);
      const int number = chosen.s == kGuidedTechnique ? count - 1 : chosen.s;
      samples_.choose({point_of_part(number, count, rng.next_float()), 0.0f});
      evaluate_technique(length_, at);
      samples_.accept();
    }
    samples_.seed(rng.next());
    return target;
  }

  double propose(MarkovChain<State>& chain, bool large) {
    samples_.propose(large);
    proposed_length_ = large ? plan_.lengths.sample(samples_.random()) : length_;
    evaluate_technique(proposed_length_, chain.proposed);
    return 1.0;
  }
  void accept() {
    samples_.accept();
    length_ = proposed_length_;
  }

  template <class Share>
  static void share_independent(const Share& share, Contribution& c) {
    for (size_t i = 0; i < c.splats.size(); ++i) {
      double target = 0.0;  // of its technique
      for (const Splat& other : c.splats) {
        target += other.s == c.splats[i].s && other.t == c.splats[i].t ? other.target : 0.0;
      }
      c.splats[i].color *= static_cast<float>(share.independent(target));
    }
  }

 private:
  // The guide's comes last.
  int techniques_of(int length) const {
    return (techniques_.light_paths ? length : 2) + (guided_.any() ? 1 : 0);
  }

  void evaluate_technique(int length, Contribution& out) {
    const int count = techniques_of(length);
    const int s = part_of(samples_.get(kChoiceDimension).x, count);
    TechniqueSet one = techniques_;
    const bool go_on = guided_.any() && s + 1 == count;
    one.only_s = go_on ? 0 : s;
    one.only_t = go_on ? std::numeric_limits<int>::max() : length - s;
    one.most_light_bounces = go_on ? -1 : s - 2;
    // The guide's comes at least two surfaces before the light.
    one.most_camera_bounces = go_on ? length - 4 : length - s - 2;
    const double scale = count / plan_.lengths.probability(length);
    evaluate(one, scale, out, go_on, {}, length);
    out.independent_target = out.target / scale;
  }

  int length_ = 0, proposed_length_ = 0;
};

}  // namespace vernier
