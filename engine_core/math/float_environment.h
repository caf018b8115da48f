// The floating-point mode of render threads.
#pragma once

#if defined(__SSE__)
#include <xmmintrin.h>
#endif

namespace vernier {

// While it lives, this thread rounds denormal results and operands to zero: they carry nothing
// that a picture shows, and cost a hundred cycles each.
class FlushDenormals {
 public:
#if defined(__SSE__)
  FlushDenormals() : saved_(_mm_getcsr()) { _mm_setcsr(saved_ | 0x8040u); }
  ~FlushDenormals() { _mm_setcsr(saved_); }
#else
  FlushDenormals() = default;
  ~FlushDenormals() = default;
#endif
  FlushDenormals(const FlushDenormals&) = delete;
  FlushDenormals& operator=(const FlushDenormals&) = delete;

 private:
#if defined(__SSE__)
  unsigned saved_;
#endif
};

}  // namespace vernier
