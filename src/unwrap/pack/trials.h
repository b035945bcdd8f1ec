#pragma once
// Searches by trial and error, each trial a whole packing, on many threads.

#include "halflight/base/parallel.h"

#include <algorithm>
#include <bit>
#include <cstddef>
#include <optional>
#include <utility>
#include <vector>

namespace halflight::charts {

/// Trials that a search looks ahead: with depth d up to 2^d - 1 run at one time, so that d of them are of use.
inline int trialDepth(int threads)
{
    return std::max(1, int(std::bit_width(unsigned(threads) + 1u)) - 1);
}

/// Runs a search to its end and returns the last trial that succeeded. A search has `done`, `value` (of the next trial)
/// and after(bool succeeded) (the search that follows). The trials that can follow, whatever the outcomes, run at the
/// same time: the result is that of one trial after another. evaluate(value) returns a trial, nothing when it fails.
/// report(search) is called before trials.
template<typename Trial, typename Search, typename Evaluate, typename Report>
std::optional<Trial> searchByTrials(Search& search, int depth, const Evaluate& evaluate, const Report& report)
{
    std::optional<Trial> best;
    while (!search.done) {
        report(search);
        std::vector<Search> ahead;
        std::vector<Search> level = {search};
        for (int d = 0; d < depth; ++d) {
            std::vector<Search> next;
            for (const Search& s : level) {
                if (s.done) continue;
                ahead.push_back(s);
                for (const bool succeeded : {true, false}) next.push_back(s.after(succeeded));
            }
            level = std::move(next);
        }
        std::vector<std::optional<Trial>> trials(ahead.size());
        parallelFor(ahead.size(), 1, [&](std::size_t begin, std::size_t end) {
            for (std::size_t i = begin; i < end; ++i) trials[i] = evaluate(ahead[i].value);
        });
        for (int d = 0; d < depth && !search.done; ++d) {
            const auto same = [&](const Search& s) { return s.value == search.value; };
            const auto at = std::size_t(std::find_if(ahead.begin(), ahead.end(), same) - ahead.begin());
            const bool succeeded = trials[at].has_value();
            if (succeeded) best = std::move(trials[at]);
            search = search.after(succeeded);
        }
    }
    return best;
}

} // namespace halflight::charts
