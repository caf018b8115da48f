// Confidence intervals of all pixels, from what each knows and what its neighbours know.
//
// A pixel alone cannot tell its error: with few batches its variance is a guess, and one that has
// not met its rare bright path yet finds no variance at all. So three things are pooled.
//
// 1. Variance, relative to the light there is, over the 7 x 7 pixels around: where a bright path is
//    met by one pixel or more in two, the others must expect it. Half of the variance is the
//    pixel's own, so that one that has met it says so.
// 2. Excess: light that single batches brought beyond all others of their pixel. It is what the
//    pixels lack that met no such batch; one that did lacks that much less. Its mean over a
//    neighbourhood, plus its own standard error, widens the interval; of three neighbourhoods the
//    one that asks for most counts, so that the rarest paths that are seen are heard of from afar.
//    Where paths are so rare that hardly a pixel meets two, pooled variance would say much more
//    than the error of nineteen pixels in twenty.
// 3. The nets' gain. Batches that are parts of one net fill each other's gaps, so that the mean is
//    better than their spread tells. The two nets of a render are independent: the difference of
//    their means, pooled over a wide neighbourhood, tells how much better.
#pragma once

#include <vector>

#include "accuracy/neighbourhood.h"

namespace vernier {

// Half-widths of the 95 % confidence intervals of a picture's luminances, by row. Infinite where
// nothing is known. `pixels` has width * height elements; `mean` is their mean luminance.
std::vector<float> half_widths(PixelEstimates pixels, int width, int height, double mean);

}  // namespace vernier
