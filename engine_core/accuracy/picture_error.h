// The picture's error, from what its pixels know.
//
// It is the 95th percentile, over the picture, of the pixels' relative 95 % half-widths. Those of
// the error pass (error_map.h) are not what to take the percentile of: each is as wide as a single
// pixel's ignorance asks for, its value may be dark only because it has not met its light yet, and
// a percentile picks the widest. Many pixels together know more, so here each half-width is that of
// a neighbourhood, with no caution added:
//
// 1. It is relative to the light that is to be expected there: the level around, and the mean of
//    what rare paths brought to the pixels of a wider neighbourhood.
// 2. Half the difference of a pixel's two nets has the distribution of its error: of all that
//    varies, whatever its tail. So among 7 x 7 pixels the 95th percentile of these differences is
//    the half-width. Pixels that met no rare path also lack what the others did, those that met one
//    have that much less too much.
// 3. Where no pixel met a rare path, errors are normal, and the variances of all batches tell the
//    half-width better than the differences do.
//
// What is left of chance in a half-width is smoothed away: the median of its neighbours counts.
#pragma once

#include <vector>

#include "accuracy/neighbourhood.h"

namespace vernier {

// Half-widths of neighbourhoods, relative; of the pixels whose row and column are multiples of
// `stride`, by row. Infinite where nothing is known.
struct PictureErrors {
  int stride = 1;
  int columns = 0, rows = 0;
  std::vector<float> errors;
  // Relative variances of the pixels' values, means of neighbourhoods: what rare paths add counts
  // in full here, so that these fall with the number of samples whatever the tail.
  std::vector<float> variances;
};

// `pixels` has width * height elements; `mean` is their mean luminance. Large pictures are read in
// part: a percentile needs no more.
PictureErrors picture_errors(PixelEstimates pixels, int width, int height, double mean);

}  // namespace vernier
