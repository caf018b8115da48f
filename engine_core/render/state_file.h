// A render's saved state: what it takes to go on as if it had never stopped.
//
// The file is for the machine and the version that wrote it: numbers as they lie in memory, and a
// checksum. It is written under another name, flushed to the disk and renamed, so that whatever
// interrupts, there is a whole state or the one before.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <type_traits>
#include <vector>

namespace vernier {

class StateWriter {
 public:
  template <class T>
  void add(const T& value) {
    static_assert(std::is_trivially_copyable_v<T>);
    add_bytes(&value, sizeof(T));
  }
  // Without their number: the reader knows it.
  template <class T>
  void add_all(std::span<T> values) {
    static_assert(std::is_trivially_copyable_v<T>);
    add_bytes(values.data(), values.size_bytes());
  }
  void add(const std::string& text) {
    add(static_cast<uint64_t>(text.size()));
    add_bytes(text.data(), text.size());
  }

  // Throws std::runtime_error, in one sentence that names the file.
  void write(const std::string& path) const;

 private:
  void add_bytes(const void* data, size_t size);
  std::vector<char> bytes_;
};

// All of it throws std::runtime_error for a file that cannot be read, is no state, or is damaged.
class StateReader {
 public:
  explicit StateReader(const std::string& path);

  template <class T>
  void get(T& value) {
    static_assert(std::is_trivially_copyable_v<T>);
    get_bytes(&value, sizeof(T));
  }
  template <class T>
  void get_all(std::span<T> values) {
    static_assert(std::is_trivially_copyable_v<T>);
    get_bytes(values.data(), values.size_bytes());
  }
  void get(std::string& text) {
    uint64_t size = 0;
    get(size);
    check(size);
    text.resize(size);
    get_bytes(text.data(), size);
  }
  [[noreturn]] void refuse(const std::string& why) const;

 private:
  void check(uint64_t size) const;
  void get_bytes(void* data, size_t size);
  std::string path_;
  std::vector<char> bytes_;
  size_t at_ = 0;
};

}  // namespace vernier
