#include "photons/photon_map.h"

#include <algorithm>

namespace vernier {
namespace {

constexpr size_t kPartSize = 65536;
constexpr int kLayOut = 0, kGather = 1, kTree = 2;

}  // namespace

int PhotonMapBuild::stages() const { return kTree + 2 + KdTreeBuild::kMostTopLevels + 2; }

size_t PhotonMapBuild::jobs(int stage) const {
  const int last = stages() - 1;
  if (stage == kLayOut || stage == last) {
    return 1;
  }
  if (stage == kGather) {
    return chunks_.size();
  }
  return stage == last - 1 ? (unsorted_.size() + kPartSize - 1) / kPartSize
                           : tree_->jobs(stage - kTree);
}

void PhotonMapBuild::run(int stage, size_t job) {
  const int last = stages() - 1;
  if (stage == kLayOut) {
    lay_out();
  } else if (stage == kGather) {
    gather(job);
  } else if (stage < last - 1) {
    tree_->run(stage - kTree, job);
  } else if (stage == last - 1) {
    sort(job);
  } else {
    positions_ = {};
    unsorted_ = {};
    tree_.reset();
  }
}

void PhotonMapBuild::lay_out() {
  size_t count = 0;
  for (const PhotonChunk& chunk : chunks_) {
    starts_.push_back(count);
    count += chunk.photons.size();
    map_.tally_.add(chunk.tally);
  }
  if (map_.tally_.paths > 0) {
    map_.scale_ = static_cast<float>(1.0 / static_cast<double>(map_.tally_.paths));
  }
  positions_.resize(count);
  unsorted_.resize(count);
  map_.photons_.resize(count);
  tree_ = std::make_unique<KdTreeBuild>(map_.tree_, positions_);
}

void PhotonMapBuild::gather(size_t chunk) {
  PhotonChunk& from = chunks_[chunk];
  const auto start = static_cast<ptrdiff_t>(starts_[chunk]);
  std::copy(from.positions.begin(), from.positions.end(), positions_.begin() + start);
  std::copy(from.photons.begin(), from.photons.end(), unsorted_.begin() + start);
  from = {};
}

void PhotonMapBuild::sort(size_t part) {
  const size_t end = std::min((part + 1) * kPartSize, unsorted_.size());
  for (size_t place = part * kPartSize; place < end; ++place) {
    map_.photons_[place] = unsorted_[map_.tree_.index(static_cast<uint32_t>(place))];
  }
}

}  // namespace vernier
