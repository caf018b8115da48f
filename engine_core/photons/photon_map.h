// Photons in the order of a kd-tree.
#pragma once

#include <cstddef>
#include <memory>
#include <vector>

#include "photons/photon_walk.h"
#include "spatial/kd_tree.h"

namespace vernier {

class PhotonMap {
 public:
  const KdTree& tree() const { return tree_; }
  // By place in the tree's order.
  const Photon& photon(uint32_t place) const { return photons_[place]; }
  size_t size() const { return photons_.size(); }
  // The part of a photon's power that counts: one over the number of paths.
  float scale() const { return scale_; }
  // Where the light went that the map was made of.
  const PhotonTally& tally() const { return tally_; }
  // Bytes in use: 42 for each photon at the most, of 1,000 and more.
  size_t memory() const { return tree_.memory() + photons_.size() * sizeof(Photon); }

 private:
  friend class PhotonMapBuild;

  KdTree tree_;
  std::vector<Photon> photons_;
  float scale_ = 0.0f;
  PhotonTally tally_;
};

// Makes a map of what jobs have found, in stages (spatial/stages.h).
class PhotonMapBuild {
 public:
  // Both must outlive the build. The chunks are complete when the first stage begins, and are
  // emptied.
  PhotonMapBuild(PhotonMap& map, std::vector<PhotonChunk>& chunks) : map_(map), chunks_(chunks) {}

  int stages() const;
  size_t jobs(int stage) const;
  void run(int stage, size_t job);

 private:
  void lay_out();
  void gather(size_t chunk);
  void sort(size_t part);

  PhotonMap& map_;
  std::vector<PhotonChunk>& chunks_;
  std::vector<size_t> starts_;    // of each chunk's photons
  std::vector<Vec3f> positions_;  // in the order of chunks, as...
  std::vector<Photon> unsorted_;
  std::unique_ptr<KdTreeBuild> tree_;
};

}  // namespace vernier
