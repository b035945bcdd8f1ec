#include "bake/seams/seam_parts.h"

#include "halflight/base/disjoint_sets.h"

namespace halflight {

SeamParts partsOf(std::span<const SeamTerm> terms, std::size_t unknowns)
{
    constexpr std::size_t kFewest = 4096; // unknowns of a part, some milliseconds: networks of seams share parts
    constexpr uint32_t kNone = ~0u;
    DisjointSets networks(unknowns);
    for (const SeamTerm& term : terms) {
        for (const uint32_t u : term.unknown) networks.join(term.unknown[0], u);
    }
    SeamParts split;
    split.placeOf.resize(unknowns);
    std::vector<uint32_t> partOf(unknowns, kNone);
    for (uint32_t u = 0; u < unknowns; ++u) {
        uint32_t& part = partOf[networks.find(u)];
        if (part == kNone) {
            if (split.parts.empty() || split.parts.back().unknowns.size() >= kFewest) split.parts.emplace_back();
            part = uint32_t(split.parts.size() - 1);
        }
        split.placeOf[u] = uint32_t(split.parts[part].unknowns.size());
        split.parts[part].unknowns.push_back(u);
    }
    for (uint32_t t = 0; t < terms.size(); ++t)
        split.parts[partOf[networks.find(terms[t].unknown[0])]].terms.push_back(t);
    return split;
}

} // namespace halflight
