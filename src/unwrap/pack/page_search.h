#pragma once
// Searches for a density and for a page size (searchByTrials()).

#include "unwrap/pack/pages.h"

#include <algorithm>
#include <cmath>

namespace halflight::charts {

/// The size of the smallest page that holds everything. From an estimate that is good to some percent: up in small
/// steps, then halves of what is left.
struct PageSearch {
    int fails = kLeastCutPage - 4;
    int fits = 0;
    int value = 0; ///< size of the next trial
    bool fittedOnce = false;
    int trial = 0;
    bool done = false;

    PageSearch(int most, int estimate) : fits(most), value(estimate) { settle(); }
    [[nodiscard]] PageSearch after(bool fitted) const
    {
        PageSearch next = *this;
        (fitted ? next.fits : next.fails) = value;
        next.fittedOnce = fittedOnce || fitted;
        ++next.trial;
        next.value =
            next.fittedOnce ? roundedUpToBlocks(0.5 * (next.fails + next.fits)) : roundedUpToBlocks(1.04 * value + 1.0);
        next.settle();
        return next;
    }

private:
    void settle()
    {
        constexpr int kTrials = 10;
        value = std::clamp(value, fails + 4, std::max(roundedUpToBlocks(fits) - 4, fails + 4));
        done = trial == kTrials || fits - fails <= std::max(4, fits / 64) || value >= fits;
    }
};

/// The greatest density at which everything fits one page: brackets it, then halves the bracket.
struct DensitySearch {
    static constexpr int kTrials = 9;
    double most = 0.0;
    double value = 0.0; ///< density of the next trial
    double fits = 0.0;
    double fails = 0.0;
    int trial = 0;
    bool done = false;

    [[nodiscard]] DensitySearch after(bool fitted) const
    {
        DensitySearch next = *this;
        (fitted ? next.fits : next.fails) = value;
        ++next.trial;
        const bool bracketed = next.fits > 0.0 && next.fails > 0.0;
        next.done = next.trial == kTrials || next.fits >= most || (bracketed && next.fails / next.fits < 1.008);
        if (bracketed) {
            next.value = std::sqrt(next.fits * next.fails);
        } else {
            const double step = trial < 2 ? 1.06 : trial < 4 ? 1.25 : 3.0;
            next.value = next.fits > 0.0 ? std::min(next.fits * step, most) : next.fails / step;
        }
        return next;
    }
};

} // namespace halflight::charts
