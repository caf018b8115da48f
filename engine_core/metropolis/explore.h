// The tile job of every Metropolis method: direct light by ordinary samples, and as many mutations
// as the tile has samples, by chains that start anew.
#pragma once

#include <cmath>
#include <stdexcept>

#include "bidirectional/tracer.h"
#include "integrators/camera_loop.h"
#include "metropolis/metropolis_step.h"
#include "metropolis/seed_pool.h"

namespace vernier {

// What the camera sees directly and, where it is left to ordinary samples, the light that reaches
// that directly; coverage and passes.
template <BidirectionalFeatures F>
void sample_directly(const RenderContext& context, const Batch& batch, const Tile& tile,
                     TileBuffer& buffer, RenderStats& stats) {
  Settings settings = context.settings;
  settings.max_bounces = 0;
  TechniqueSet techniques(settings, context.scene.requirements);
  techniques.light_paths = false;
  techniques.camera_paths = settings.separate_direct != 0;
  techniques.only_s = techniques.only_t = -1;
  techniques.weighted = true;
  const RenderContext direct{context.scene, settings, context.filter, context.cancelled,
                             context.plan};
  BidirectionalMemory memory;
  NoObserver observer;
  render_camera_tile<F.passes>(
      direct, batch, tile, buffer, stats,
      [&](const CameraRay& ray, const SobolSampler& sampler, auto& pass_sample) {
        return BidirectionalTracer<F>(direct, sampler, stats, nullptr, pass_sample, memory,
                                      observer, techniques)
            .run(ray);
      });
}

template <class Explorer>
class TileChains {
 public:
  TileChains(const RenderContext& context, const Batch& batch, const Tile& tile, TileBuffer& buffer,
             RenderStats& stats)
      : context_(context),
        batch_(batch),
        pool_(static_cast<const SeedPool<Explorer>&>(*context.light_pass)),
        share_(static_cast<const MetropolisPlan&>(*context.plan).scale,
               pool_.size().independents / pool_.size().mutations),
        splats_(context.scene.film, context.filter, buffer.splats()),
        explorer_(context, stats) {
    const std::array<int32_t, 4>& crop = context.scene.film.crop;
    const double width = crop[2] - crop[0];
    // The place of the tile's mutations among all of the batch, in rows of tiles.
    first_ = batch.samples * (tile.y * width + static_cast<double>(tile.x) * tile.height);
    count_ = static_cast<double>(batch.samples) * tile.width * tile.height;
  }

  void run() {
    const double chains = std::max(std::round(count_ / context_.settings.chain_length), 1.0);
    for (double i = 0; i < chains && !context_.cancelled; ++i) {
      const double begin = std::floor(count_ * i / chains);
      const double end = std::floor(count_ * (i + 1.0) / chains);
      run_chain(first_ + begin, static_cast<uint64_t>(end - begin));
    }
  }

 private:
  // `first`: the place of the chain's mutations among all of the batch. Starts are stratified by
  // it.
  void run_chain(double first, uint64_t count) {
    const uint64_t seed =
        hash64(batch_.seed ^ hash64(hash64(batch_.first) + static_cast<uint64_t>(first)));
    Pcg32 rng(seed);
    explorer_.begin_chain(static_cast<uint64_t>(first / context_.settings.chain_length),
                          hash64(batch_.seed ^ hash64(~uint64_t{batch_.first})));
    const bool lit = pool_.brightness() > 0.0;
    const double place = rng.next_float();
    if (lit) {
      const uint32_t start =
          pool_.choose((first + place * static_cast<double>(count)) / pool_.size().mutations);
      const double target = explorer_.start(seed_sampler(batch_, pool_.size(), start), rng, chain_);
      chain_.pending = 0.0;
      if (context_.cancelled) {
        return;
      }
      if (target != pool_.target(start) || !(chain_.current.target > 0.0)) {
        throw std::logic_error("a chain's start is not what it was");
      }
    } else {
      explorer_.start(rng);
    }
    const auto record = [this](const Contribution& c, double visits) {
      splat(c, visits * pool_.brightness() / c.target * share_.chain(c.independent_target));
    };
    const auto large_part = static_cast<float>(vernier::large_steps<Explorer>(context_.settings));
    for (uint64_t i = 0; i < count && !context_.cancelled; ++i) {
      const bool large = explorer_.random() < large_part;
      if (!lit && !(large && Explorer::kIndependentSteps)) {
        continue;
      }
      const double ratio = explorer_.propose(chain_, large);
      if (large && Explorer::kIndependentSteps) {
        splat(chain_.proposed,
              pool_.independent_weight() * share_.independent(chain_.proposed.target));
      }
      if (lit && metropolis_step(chain_, ratio, explorer_.random(), record)) {
        explorer_.accept();
      }
    }
    if (lit) {
      end_chain(chain_, record);
    }
  }

  void splat(const Contribution& c, double weight) {
    for (const Splat& s : c.splats) {
      splats_.add(s.raster, s.color * static_cast<float>(weight));
    }
  }

  const RenderContext& context_;
  const Batch& batch_;
  const SeedPool<Explorer>& pool_;
  const ChainShare share_;
  const FilteredSplats splats_;
  Explorer explorer_;
  MarkovChain<typename Explorer::State> chain_;
  double first_, count_;
};

template <class Explorer, BidirectionalFeatures F>
void explore_tile(const RenderContext& context, const Batch& batch, const Tile& tile,
                  TileBuffer& buffer, PassSet /*passes*/, RenderStats& stats) {
  sample_directly<F>(context, batch, tile, buffer, stats);
  const auto& pool = static_cast<const SeedPool<Explorer>&>(*context.light_pass);
  const int width = context.scene.film.crop[2] - context.scene.film.crop[0];
  for (int y = 0; y < tile.height; ++y) {
    for (int x = 0; x < tile.width; ++x) {
      const size_t pixel = static_cast<size_t>(tile.y + y) * static_cast<size_t>(width) +
                           static_cast<size_t>(tile.x + x);
      const double* c = pool.splats().sum(0, pixel);
      PixelBatch& sums = buffer.pixel(x, y);
      sums.r += c[0], sums.g += c[1], sums.b += c[2];
    }
  }
  const auto& plan = static_cast<const MetropolisPlan&>(*context.plan);
  // Where neither the pilot nor the pool found light, large steps have no share of it.
  if (plan.chains && (plan.scale > 0.0 || pool.brightness() > 0.0)) {
    TileChains<Explorer>(context, batch, tile, buffer, stats).run();
  }
}

template <class Explorer>
std::unique_ptr<LightPass> make_seed_pool(const RenderContext& context, const Batch& batch) {
  return std::make_unique<SeedPool<Explorer>>(context, batch);
}

}  // namespace vernier
