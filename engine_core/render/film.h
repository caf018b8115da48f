// Where samples become a picture.
//
// Every pixel keeps float64 sums over its samples and, for the error estimate, over its batches
// (see accuracy/pixel_sums.h). Samples are placed by importance sampling the pixel filter, so each
// belongs to one pixel alone and tiles need no borders.
#pragma once

#include <array>
#include <atomic>
#include <condition_variable>
#include <cstdint>
#include <map>
#include <memory>
#include <mutex>
#include <span>
#include <vector>

#include "accuracy/certificate.h"
#include "accuracy/picture_error.h"
#include "accuracy/pixel_sums.h"
#include "math/vec.h"
#include "render/batch_plan.h"
#include "render/passes.h"
#include "render/splats.h"

namespace vernier {

// A rectangle of pixels within the film, y upward.
struct Tile {
  int x = 0, y = 0, width = 0, height = 0;
};

// What one sample delivers besides its colour; filled only where passes ask for it.
struct PassSample {
  float depth = 0;
  Vec3f position, normal, uv;
  Color diffuse_color, glossy_color, transmission_color;
  std::array<Color, 3> direct, indirect;  // diffuse, glossy, transmission
  Color emission, environment;
  Vec3f denoising_normal;
  Color denoising_albedo;
};

// Sums over the samples of one pixel in one batch.
struct PixelBatch {
  double r = 0, g = 0, b = 0, alpha = 0;
  uint32_t samples = 0;

  void add(Color c, float a) {
    r += static_cast<double>(c.x), g += static_cast<double>(c.y), b += static_cast<double>(c.z);
    alpha += static_cast<double>(a);
    ++samples;
  }
};

// A tile's pixels of one batch, on their way to the film.
class TileBuffer {
 public:
  // `splats`: where the batch's light goes that is not of these pixels' own samples; null where the
  // method has none.
  TileBuffer(PassSet passes, const Tile& tile, const Batch& batch,
             std::shared_ptr<SplatFrame> splats = nullptr);

  SplatFrame* splats() const { return splats_.get(); }
  PixelBatch& pixel(int x, int y) { return pixels_[index(x, y)]; }
  // Adds a sample's passes; x and y are relative to the tile.
  void add_passes(int x, int y, const PassSample& sample, bool first);

 private:
  friend class Film;
  size_t index(int x, int y) const {
    return static_cast<size_t>(y) * static_cast<size_t>(tile_.width) + static_cast<size_t>(x);
  }
  Tile tile_;
  PassSet passes_;
  uint32_t samples_;
  bool second_net_;
  std::vector<PixelBatch> pixels_;
  std::vector<double> values_;  // by pixel: the channels of all sampled passes
  std::shared_ptr<SplatFrame> splats_;
  size_t number_ = 0;  // of the tile, where it waits for its frame
};

class StateReader;
class StateWriter;

class Film {
 public:
  // Throws std::bad_alloc when there is no memory for it.
  Film(int width, int height, PassSet passes, float exposure);

  // Before the first batch. True: samples add to other pixels than their own, so that nothing of a
  // batch is known before all of it is there.
  void set_splatting(bool splatting) { splatting_ = splatting; }

  int width() const { return width_; }
  int height() const { return height_; }
  PassSet passes() const { return passes_; }
  // All tiles, from the middle outward.
  const std::vector<Tile>& tiles() const { return tiles_; }

  // An empty buffer for batch number `number` of tile number `tile`.
  TileBuffer buffer(size_t tile, uint64_t number, const Batch& batch);

  // What a look at the picture finds.
  struct Look {
    Certificate certificate;
    PictureErrors errors;
  };

  // What merge() has made visible.
  enum class Merged { kNothing, kTile, kFrame };

  // Adds batch number `batch` of tile number `tile`. Threads may merge at the same time and in any
  // order, but a tile's batches are summed in their own: sums of rounded numbers depend on it, and
  // a picture must not depend on the threads. A batch that comes early waits for those before.
  // With splats a batch waits for all of its tiles: the frame changes as a whole.
  Merged merge(size_t tile, uint64_t batch, TileBuffer&& buffer);

  // Samples in the sums, over all pixels.
  uint64_t pixel_samples() const { return pixel_samples_.load(std::memory_order_relaxed); }

  // The current estimate of a pass over a rectangle, rows upward, channels interleaved, into `out`
  // of width * height * channels floats. Pixels without samples are zero; their error, and that
  // of pixels with one batch, is not known and so infinite.
  void read(Pass pass, const Tile& area, std::span<float> out) const;
  // The picture's error by accuracy/statement.h; infinite while few pixels have two batches.
  double error() const;
  // Look number `number` at the picture's error, which counts from 1.
  Look look(unsigned number) const;

  // What is known of each pixel by itself, by row.
  std::vector<PixelEstimate> estimates() const;
  // What they say together.
  PictureErrors picture_errors() const;
  // The error pass of the whole film.
  std::vector<float> errors() const;

  // The tiles where more than a twentieth of the neighbourhoods, by what a look has found, is not
  // well below `target`, or that have had far fewer samples than another: rare light may not have
  // been met there yet.
  std::vector<bool> unfinished(const PictureErrors& found, double target) const;
  // All whole batches that are in the sums; those that came early are left out.
  void save(StateWriter& state) const;
  // Goes on from there; before the first batch. Refuses the state of another film.
  void load(StateReader& state);
  // Number of the batches in each tile's sums.
  std::vector<uint64_t> batches() const;
  // Number of the batches in the sums of the tile that has fewest.
  uint64_t least_batches() const;

 private:
  struct Pixel {
    double r = 0, g = 0, b = 0, alpha = 0;
    PixelSums batches;
  };
  static constexpr int kTileSize = 32;

  struct Arrivals {
    uint64_t next = 0;  // number of the batch to be added next
    std::map<uint64_t, TileBuffer> early;
  };

  // A batch of a splatting method, until it is whole.
  struct Frame {
    std::shared_ptr<SplatFrame> splats;
    std::vector<TileBuffer> tiles;
  };

  void add(size_t number, const TileBuffer& buffer);
  // Where each light pass that splats reach has its channels; -1: it was not asked for.
  using SplatChannels = std::array<int, SplatFrame::kPlanesWithPasses - SplatFrame::kDirectPlane>;
  SplatChannels splat_channels() const;
  static void add_splats(const SplatFrame& splats, const SplatChannels& channels, size_t pixel,
                         PixelBatch& batch, double* values);
  Merged merge_frame(uint64_t batch, TileBuffer&& buffer);
  static double luminance_sum(const Pixel& p);
  // Calls f(pixel within the film, its tile's counts, pixel within `area`), each tile under its
  // lock.
  template <class F>
  void for_each_pixel(const Tile& area, const F& f) const;
  void read_pixel(Pass pass, size_t pixel, uint32_t samples, float* out) const;

  int width_, height_;
  PassSet passes_;
  double exposure_;
  std::vector<Tile> tiles_;
  std::vector<Pixel> pixels_;
  std::vector<BatchCounts> counts_;  // by tile
  // In float32 a sum stops growing where a batch is less than its last place: a pass of as many
  // samples as a render may have would be dark.
  std::vector<double> values_;
  std::vector<Arrivals> arrivals_;               // by tile
  mutable std::unique_ptr<std::mutex[]> locks_;  // by tile
  std::atomic<uint64_t> pixel_samples_{0};
  bool splatting_ = false;
  mutable std::mutex frames_lock_;
  mutable std::condition_variable frame_added_;
  std::map<uint64_t, Frame> frames_;  // by batch: those begun and not yet in the sums
  uint64_t next_frame_ = 0;
  bool adding_frame_ = false;  // a thread is at it
};

// Number of floats that a sample's passes take per pixel, and the place of one pass among them.
int sampled_channels(PassSet passes);
int channel_offset(PassSet passes, Pass pass);

}  // namespace vernier
