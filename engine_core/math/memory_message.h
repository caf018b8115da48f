// What a user is told of an allocation that failed.
#pragma once

#include <exception>
#include <new>
#include <stdexcept>

namespace vernier {

inline constexpr const char* kNotEnoughMemory = "there is not enough memory for this render";

// One sentence for the user; lives as long as `error`.
inline const char* message_of(const std::exception& error) {
  // Containers throw std::length_error where more was asked of them than any memory holds.
  const bool memory = dynamic_cast<const std::bad_alloc*>(&error) != nullptr ||
                      dynamic_cast<const std::length_error*>(&error) != nullptr;
  return memory ? kNotEnoughMemory : error.what();
}

}  // namespace vernier
