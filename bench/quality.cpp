// Bakes the scenes of assets/quality/ and prints what is measured of each as a table; exit code 1 when a limit is
// missed.
//   bench_quality [--assets DIR] [--markdown] [--truth-samples N] [ITEM...]     ITEM: leaks edges seams tiles
//   masks noise probes

#include "quality/measures.h"

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <set>

using namespace halflight;
using namespace halflight::quality;

int main(int argc, char** argv)
{
    std::filesystem::path assets = "assets";
    bool markdown = false;
    int truthSamples = 2048;
    std::set<std::string> wanted;
    for (int i = 1; i < argc; ++i) {
        if (std::strcmp(argv[i], "--assets") == 0 && i + 1 < argc) {
            assets = argv[++i];
        } else if (std::strcmp(argv[i], "--truth-samples") == 0 && i + 1 < argc) {
            truthSamples = std::atoi(argv[++i]);
        } else if (std::strcmp(argv[i], "--markdown") == 0) {
            markdown = true;
        } else {
            wanted.insert(argv[i]);
        }
    }
    bool allMet = true;
    const auto print = [&](const char* item, auto measure) {
        if (!wanted.empty() && wanted.count(item) == 0) return;
        for (const Figure& f : measure()) {
            const char* format = markdown ? "| %s | `%s` | %s | %.3g %s | %.3g %s | %s |\n"
                                          : "%-7s %-28s %-78s %9.3g %-2s  limit %6.3g %-2s %s\n";
            std::printf(format, f.item.c_str(), f.scene.c_str(), f.what.c_str(), f.value, f.unit.c_str(), f.limit,
                        f.unit.c_str(), f.met() ? (markdown ? "" : "ok") : (markdown ? "missed" : "MISSED"));
            allMet = allMet && f.met();
        }
        std::fflush(stdout);
    };
    if (markdown) std::printf("| | scene | what | measured | limit | |\n|---|---|---|---|---|---|\n");
    print("leaks", [&] { return measureLeaks(assets); });
    print("edges", [&] { return measureEdges(assets); });
    print("seams", [&] { return measureSeams(assets); });
    print("tiles", [&] { return measureTiles(assets); });
    print("masks", [&] { return measurePenumbra(assets); });
    print("masks", [&] { return measureMaskEdges(assets); });
    print("masks", [&] { return measureTerminator(assets); });
    print("noise", [&] { return measureContact(assets, truthSamples); });
    print("probes", [&] { return measureProbes(assets); });
    return allMet ? 0 : 1;
}
