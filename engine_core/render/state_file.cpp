#include "render/state_file.h"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <iterator>
#include <stdexcept>

#include "math/rng.h"

namespace vernier {
namespace {

constexpr std::array<char, 16> kMagic{'v', 'e', 'r', 'n', 'i', 'e', 'r', ' ',
                                      's', 't', 'a', 't', 'e', ' ', '1', '\n'};

uint64_t checksum(const char* data, size_t size) {
  uint64_t sum = size;
  for (size_t at = 0; at < size; at += sizeof(uint64_t)) {
    uint64_t word = 0;
    std::memcpy(&word, data + at, std::min(sizeof(word), size - at));
    sum = hash64(sum ^ word);
  }
  return sum;
}

[[noreturn]] void fail(const std::string& path, const std::string& what) {
  throw std::runtime_error("the state " + path + " " + what);
}

void write_all(int file, const void* data, size_t size, const std::string& path) {
  const char* bytes = static_cast<const char*>(data);
  while (size > 0) {
    const ssize_t written = ::write(file, bytes, size);
    if (written < 0 && errno != EINTR) {
      fail(path, std::string("cannot be written: ") + std::strerror(errno));
    }
    if (written > 0) {
      bytes += written;
      size -= static_cast<size_t>(written);
    }
  }
}

}  // namespace

void StateWriter::add_bytes(const void* data, size_t size) {
  const char* bytes = static_cast<const char*>(data);
  bytes_.insert(bytes_.end(), bytes, bytes + size);
}

void StateWriter::write(const std::string& path) const {
  const std::string part = path + ".part" + std::to_string(::getpid());
  const int file = ::open(part.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0666);
  if (file < 0) {
    fail(path, std::string("cannot be written: ") + std::strerror(errno));
  }
  try {
    const uint64_t sum = checksum(bytes_.data(), bytes_.size());
    write_all(file, kMagic.data(), kMagic.size(), path);
    write_all(file, &sum, sizeof(sum), path);
    write_all(file, bytes_.data(), bytes_.size(), path);
    if (::fsync(file) != 0 || std::rename(part.c_str(), path.c_str()) != 0) {
      fail(path, std::string("cannot be written: ") + std::strerror(errno));
    }
  } catch (...) {
    ::close(file);
    ::unlink(part.c_str());
    throw;
  }
  ::close(file);
}

StateReader::StateReader(const std::string& path) : path_(path) {
  std::ifstream file(path, std::ios::binary);
  if (!file) {
    fail(path, std::string("cannot be read: ") + std::strerror(errno));
  }
  bytes_.assign(std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>());
  std::array<char, kMagic.size()> magic{};
  uint64_t sum = 0;
  if (bytes_.size() < magic.size() + sizeof(sum)) {
    refuse("is no saved state");
  }
  get(magic);
  get(sum);
  if (magic != kMagic) {
    refuse("is no saved state, or another version's");
  }
  if (sum != checksum(bytes_.data() + at_, bytes_.size() - at_)) {
    refuse("is damaged");
  }
}

void StateReader::refuse(const std::string& why) const { fail(path_, why); }

void StateReader::check(uint64_t size) const {
  if (size > bytes_.size() - at_) {
    refuse("is damaged");
  }
}

void StateReader::get_bytes(void* data, size_t size) {
  check(size);
  if (size > 0) {
    std::memcpy(data, bytes_.data() + at_, size);
  }
  at_ += size;
}

}  // namespace vernier
