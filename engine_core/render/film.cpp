#include "render/film.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "accuracy/error_map.h"
#include "accuracy/statement.h"

namespace vernier {
namespace {

bool is_sampled(Pass pass) {
  return pass != Pass::kCombined && info(pass).kind != PassKind::kDerived;
}

// Depth where there is no surface, as Blender's compositor expects it.
constexpr float kNoDepth = 1e10f;

// Mean of the pixels that have samples, before exposure.
double mean_luminance(std::span<const PixelEstimate> pixels) {
  double sum = 0.0;
  size_t count = 0;
  for (const PixelEstimate& p : pixels) {
    if (!std::isnan(p.mean)) {
      sum += p.mean, ++count;
    }
  }
  return count > 0 ? sum / static_cast<double>(count) : 0.0;
}

// Light passes are divided by their colour when they are read: that colour must then be stored.
PassSet with_colors(PassSet passes) {
  for (int i = 0; i < kPassCount; ++i) {
    const auto pass = static_cast<Pass>(i);
    if (passes.has(pass) && info(pass).color != Pass::kCount) {
      passes.add(info(pass).color);
    }
  }
  return passes;
}

std::vector<Tile> make_tiles(int width, int height, int size) {
  std::vector<Tile> tiles;
  for (int y = 0; y < height; y += size) {
    for (int x = 0; x < width; x += size) {
      tiles.push_back({x, y, std::min(size, width - x), std::min(size, height - y)});
    }
  }
  // The middle of the picture comes first: it is where people look.
  const auto distance = [&](const Tile& t) {
    return std::hypot(2.0 * t.x + t.width - width, 2.0 * t.y + t.height - height);
  };
  std::stable_sort(tiles.begin(), tiles.end(),
                   [&](const Tile& a, const Tile& b) { return distance(a) < distance(b); });
  return tiles;
}

// What a sample says of a sampled pass; scalars are in x.
Vec3f value_of(Pass pass, const PassSample& s) {
  switch (pass) {
    case Pass::kDepth:
    case Pass::kDenoisingDepth:
      return splat(s.depth);
    case Pass::kPosition:
      return s.position;
    case Pass::kNormal:
      return s.normal;
    case Pass::kUv:
      return s.uv;
    case Pass::kDiffuseDirect:
      return s.direct[0];
    case Pass::kDiffuseIndirect:
      return s.indirect[0];
    case Pass::kDiffuseColor:
      return s.diffuse_color;
    case Pass::kGlossyDirect:
      return s.direct[1];
    case Pass::kGlossyIndirect:
      return s.indirect[1];
    case Pass::kGlossyColor:
      return s.glossy_color;
    case Pass::kTransmissionDirect:
      return s.direct[2];
    case Pass::kTransmissionIndirect:
      return s.indirect[2];
    case Pass::kTransmissionColor:
      return s.transmission_color;
    case Pass::kEmission:
      return s.emission;
    case Pass::kEnvironment:
      return s.environment;
    case Pass::kDenoisingNormal:
      return s.denoising_normal;
    case Pass::kDenoisingAlbedo:
      return s.denoising_albedo;
    case Pass::kCombined:
    case Pass::kSampleCount:
    case Pass::kError:
    case Pass::kCount:
      break;  // not sampled
  }
  return {};
}

}  // namespace

int channel_offset(PassSet passes, Pass pass) {
  int offset = 0;
  for (int i = 0; i < static_cast<int>(pass); ++i) {
    const auto p = static_cast<Pass>(i);
    offset += passes.has(p) && is_sampled(p) ? static_cast<int>(info(p).channels.size()) : 0;
  }
  return offset;
}

int sampled_channels(PassSet passes) { return channel_offset(passes, Pass::kCount); }

TileBuffer::TileBuffer(PassSet passes, const Tile& tile, const Batch& batch,
                       std::shared_ptr<SplatFrame> splats)
    : tile_(tile),
      passes_(passes),
      samples_(batch.samples),
      second_net_(batch.second_net),
      splats_(std::move(splats)) {
  const auto count = static_cast<size_t>(tile.width) * static_cast<size_t>(tile.height);
  pixels_.resize(count);
  values_.resize(count * static_cast<size_t>(sampled_channels(passes)));
}

void TileBuffer::add_passes(int x, int y, const PassSample& sample, bool first) {
  double* out = values_.data() + index(x, y) * static_cast<size_t>(sampled_channels(passes_));
  for (int i = 0; i < kPassCount; ++i) {
    const auto pass = static_cast<Pass>(i);
    if (!passes_.has(pass) || !is_sampled(pass)) {
      continue;
    }
    const Vec3f value = value_of(pass, sample);
    const auto channels = static_cast<int>(info(pass).channels.size());
    if (info(pass).kind != PassKind::kFirstSample || first) {
      for (int c = 0; c < channels; ++c) {
        out[c] += static_cast<double>(value[c]);
      }
    }
    out += channels;
  }
}

Film::Film(int width, int height, PassSet passes, float exposure)
    : width_(width),
      height_(height),
      passes_(with_colors(passes)),
      exposure_(static_cast<double>(exposure)),
      tiles_(make_tiles(width, height, kTileSize)) {
  const auto count = static_cast<size_t>(width) * static_cast<size_t>(height);
  pixels_.resize(count);
  values_.resize(count * static_cast<size_t>(sampled_channels(passes_)));
  counts_.resize(tiles_.size());
  arrivals_.resize(tiles_.size());
  locks_ = std::make_unique<std::mutex[]>(tiles_.size());
}

double Film::luminance_sum(const Pixel& p) { return 0.2126 * p.r + 0.7152 * p.g + 0.0722 * p.b; }

TileBuffer Film::buffer(size_t tile, uint64_t number, const Batch& batch) {
  if (!splatting_) {
    return TileBuffer(passes_, tiles_[tile], batch);
  }
  std::shared_ptr<SplatFrame> splats;
  {
    const std::lock_guard lock(frames_lock_);
    std::shared_ptr<SplatFrame>& frame = frames_[number].splats;
    if (!frame) {
      frame = std::make_shared<SplatFrame>(width_, height_, passes_.any_sampled());
    }
    splats = frame;
  }
  return TileBuffer(passes_, tiles_[tile], batch, std::move(splats));
}

Film::Merged Film::merge_frame(uint64_t batch, TileBuffer&& buffer) {
  std::unique_lock lock(frames_lock_);
  frames_.at(batch).tiles.push_back(std::move(buffer));
  auto merged = Merged::kNothing;
  // One thread at a time adds, in the batches' order; the others go on rendering meanwhile.
  while (!adding_frame_) {
    const auto next = frames_.find(next_frame_);
    if (next == frames_.end() || next->second.tiles.size() < tiles_.size()) {
      break;
    }
    adding_frame_ = true;
    const auto frame = frames_.extract(next);
    lock.unlock();
    for (const TileBuffer& tile : frame.mapped().tiles) {
      const std::lock_guard tile_lock(locks_[tile.number_]);
      add(tile.number_, tile);
    }
    lock.lock();
    adding_frame_ = false;
    frame_added_.notify_all();
    ++next_frame_;
    merged = Merged::kFrame;
  }
  return merged;
}

Film::Merged Film::merge(size_t tile, uint64_t batch, TileBuffer&& buffer) {
  if (splatting_) {
    buffer.number_ = tile;
    return merge_frame(batch, std::move(buffer));
  }
  const std::lock_guard lock(locks_[tile]);
  Arrivals& arrivals = arrivals_[tile];
  if (batch != arrivals.next) {
    arrivals.early.emplace(batch, std::move(buffer));
    return Merged::kNothing;
  }
  add(tile, buffer);
  ++arrivals.next;
  for (auto next = arrivals.early.begin();
       next != arrivals.early.end() && next->first == arrivals.next;
       next = arrivals.early.erase(next)) {
    add(tile, next->second);
    ++arrivals.next;
  }
  return Merged::kTile;
}

Film::SplatChannels Film::splat_channels() const {
  constexpr std::array kPlanes{Pass::kDiffuseDirect,      Pass::kGlossyDirect,
                               Pass::kTransmissionDirect, Pass::kDiffuseIndirect,
                               Pass::kGlossyIndirect,     Pass::kTransmissionIndirect};
  SplatChannels channels;
  for (size_t i = 0; i < kPlanes.size(); ++i) {
    channels[i] = passes_.has(kPlanes[i]) ? channel_offset(passes_, kPlanes[i]) : -1;
  }
  return channels;
}

void Film::add_splats(const SplatFrame& splats, const SplatChannels& channels, size_t pixel,
                      PixelBatch& batch, double* values) {
  const double* c = splats.sum(0, pixel);
  batch.r += c[0], batch.g += c[1], batch.b += c[2];
  for (size_t plane = 0; splats.has_passes() && plane < channels.size(); ++plane) {
    if (channels[plane] >= 0) {
      const double* light = splats.sum(SplatFrame::kDirectPlane + plane, pixel);
      for (int channel = 0; channel < 3; ++channel) {
        values[channels[plane] + channel] += light[channel];
      }
    }
  }
}

void Film::add(size_t number, const TileBuffer& buffer) {
  const Tile& tile = tiles_[number];
  BatchCounts& counts = counts_[number];
  const auto channels = static_cast<size_t>(sampled_channels(passes_));
  const SplatChannels splatted = splat_channels();
  for (int y = 0; y < tile.height; ++y) {
    for (int x = 0; x < tile.width; ++x) {
      const size_t from = buffer.index(x, y);
      PixelBatch batch = buffer.pixels_[from];
      const size_t to = static_cast<size_t>(tile.y + y) * static_cast<size_t>(width_) +
                        static_cast<size_t>(tile.x + x);
      if (buffer.splats() != nullptr) {
        add_splats(*buffer.splats(), splatted, to, batch, values_.data() + to * channels);
      }
      Pixel& p = pixels_[to];
      const double luminance = 0.2126 * batch.r + 0.7152 * batch.g + 0.0722 * batch.b;
      p.batches.add(luminance, buffer.samples_, buffer.second_net_, luminance_sum(p),
                    counts.samples);
      p.r += batch.r, p.g += batch.g, p.b += batch.b, p.alpha += batch.alpha;
      for (size_t c = 0; c < channels; ++c) {
        values_[to * channels + c] += buffer.values_[from * channels + c];
      }
    }
  }
  counts.add(buffer.samples_, buffer.second_net_);
  const uint64_t pixels = static_cast<uint64_t>(tile.width) * static_cast<uint64_t>(tile.height);
  pixel_samples_.fetch_add(pixels * buffer.samples_, std::memory_order_relaxed);
}

void Film::read_pixel(Pass pass, size_t pixel, uint32_t samples, float* out) const {
  const Pixel& p = pixels_[pixel];
  const PassInfo& what = info(pass);
  const double inv = samples > 0 ? 1.0 / samples : 0.0;
  if (pass == Pass::kCombined) {
    out[0] = static_cast<float>(p.r * inv * exposure_);
    out[1] = static_cast<float>(p.g * inv * exposure_);
    out[2] = static_cast<float>(p.b * inv * exposure_);
    out[3] = static_cast<float>(p.alpha * inv);
    return;
  }
  if (pass == Pass::kSampleCount) {
    out[0] = static_cast<float>(samples);
    return;
  }
  const double* values = values_.data() + pixel * static_cast<size_t>(sampled_channels(passes_));
  const double* value = values + channel_offset(passes_, pass);
  const double* color =
      what.kind == PassKind::kLight ? values + channel_offset(passes_, what.color) : nullptr;
  const bool is_light =
      what.kind == PassKind::kLight || pass == Pass::kEmission || pass == Pass::kEnvironment;
  if (pass == Pass::kDepth && samples > 0 && !(value[0] > 0.0)) {
    out[0] = kNoDepth;
    return;
  }
  for (size_t c = 0; c < what.channels.size(); ++c) {
    double v = value[c];
    if (color != nullptr) {
      v = color[c] > 0.0 ? v / color[c] : 0.0;
    } else if (what.kind != PassKind::kFirstSample) {
      v *= inv;
    }
    out[c] = static_cast<float>(is_light ? v * exposure_ : v);
  }
}

template <class F>
void Film::for_each_pixel(const Tile& area, const F& f) const {
  for (size_t i = 0; i < tiles_.size(); ++i) {
    const Tile& t = tiles_[i];
    const int x0 = std::max(t.x, area.x), x1 = std::min(t.x + t.width, area.x + area.width);
    const int y0 = std::max(t.y, area.y), y1 = std::min(t.y + t.height, area.y + area.height);
    if (x0 >= x1 || y0 >= y1) {
      continue;
    }
    const std::lock_guard lock(locks_[i]);
    for (int y = y0; y < y1; ++y) {
      for (int x = x0; x < x1; ++x) {
        f(static_cast<size_t>(y) * static_cast<size_t>(width_) + static_cast<size_t>(x), counts_[i],
          static_cast<size_t>(y - area.y) * static_cast<size_t>(area.width) +
              static_cast<size_t>(x - area.x));
      }
    }
  }
}

void Film::read(Pass pass, const Tile& area, std::span<float> out) const {
  if (pass == Pass::kError) {
    const std::vector<float> all = errors();
    for_each_pixel(area, [&](size_t from, const BatchCounts&, size_t to) { out[to] = all[from]; });
    return;
  }
  const size_t channels = info(pass).channels.size();
  for_each_pixel(area, [&](size_t from, const BatchCounts& counts, size_t to) {
    read_pixel(pass, from, counts.samples, out.data() + to * channels);
  });
}

std::vector<PixelEstimate> Film::estimates() const {
  std::vector<PixelEstimate> pixels(pixels_.size());
  for_each_pixel({0, 0, width_, height_}, [&](size_t i, const BatchCounts& counts, size_t) {
    pixels[i] = pixels_[i].batches.estimate(luminance_sum(pixels_[i]), counts);
  });
  return pixels;
}

std::vector<float> Film::errors() const {
  const std::vector<PixelEstimate> pixels = estimates();
  const double mean = mean_luminance(pixels);
  std::vector<float> errors = half_widths(pixels, width_, height_, mean);
  for (size_t i = 0; i < errors.size(); ++i) {
    if (std::isfinite(errors[i])) {
      errors[i] =
          static_cast<float>(relative_error(pixels[i].mean, static_cast<double>(errors[i]), mean));
    }
  }
  return errors;
}

PictureErrors Film::picture_errors() const {
  const std::vector<PixelEstimate> pixels = estimates();
  return vernier::picture_errors(pixels, width_, height_, mean_luminance(pixels));
}

double Film::error() const {
  PictureErrors all = picture_errors();
  return picture_error(all.errors);
}

Film::Look Film::look(unsigned number) const {
  const std::vector<PixelEstimate> pixels = estimates();
  const double mean = mean_luminance(pixels);
  Look look;
  look.errors = vernier::picture_errors(pixels, width_, height_, mean);
  look.certificate =
      certify(pixels, look.errors.errors, mean, static_cast<unsigned>(least_batches()), number);
  return look;
}

std::vector<uint64_t> Film::batches() const {
  std::vector<uint64_t> batches(tiles_.size());
  for (size_t i = 0; i < tiles_.size(); ++i) {
    const std::lock_guard lock(locks_[i]);
    batches[i] = counts_[i].batches;
  }
  return batches;
}

uint64_t Film::least_batches() const {
  const std::vector<uint64_t> all = batches();
  return *std::min_element(all.begin(), all.end());
}

std::vector<bool> Film::unfinished(const PictureErrors& found, double target) const {
  // Tiles are looked at often, too, and one that stops where chance was kind stays there.
  constexpr double kWellBelow = 0.9, kMostAbove = 1.0 / 20.0, kLeastShare = 1.0 / 8.0;
  uint32_t most = 0;
  for (size_t i = 0; i < tiles_.size(); ++i) {
    const std::lock_guard lock(locks_[i]);
    most = std::max(most, counts_[i].samples);
  }
  std::vector<bool> result(tiles_.size());
  for (size_t i = 0; i < tiles_.size(); ++i) {
    const Tile& t = tiles_[i];
    double count = 0.0, above = 0.0;
    const auto first = [&](int from) { return (from + found.stride - 1) / found.stride; };
    for (int row = first(t.y); row < first(t.y + t.height); ++row) {
      for (int column = first(t.x); column < first(t.x + t.width); ++column) {
        const auto at = static_cast<size_t>(row) * static_cast<size_t>(found.columns) +
                        static_cast<size_t>(column);
        ++count;
        above += static_cast<double>(found.errors[at]) <= kWellBelow * target ? 0.0 : 1.0;
      }
    }
    const std::lock_guard lock(locks_[i]);
    result[i] = above > kMostAbove * count || counts_[i].samples < kLeastShare * most;
  }
  return result;
}

}  // namespace vernier
