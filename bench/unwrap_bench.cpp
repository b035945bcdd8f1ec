// Unwraps glTF files and prints charts, fill and seconds for each; with --images DIR also a picture of every page.
//   bench_unwrap [--size N] [--padding N] [--density X] [--mode auto|keep|unwrap] [--images DIR] [--ball N] [--field N]
//                [--boxes N] [--soup N] [--tests] [--ratios] FILE...
// These add one mesh of about N triangles each, for what no file at hand is large enough for: a ball with bumps, a
// noisy height field, boxes apart from one another, and quads in any direction. --tests: surfaces are cut where they
// hide sides from one another, and sheets get two sides, as in a bake. --ratios: what the search for the density costs,
// against one packing at the density found, and how much of the page it fills, against halving a bracket of densities.

#include "bake/lights/channels.h"
#include "bake/sides/hidden_sides.h"
#include "bake/sides/sheet_sides.h"
#include "halflight/bake_cpu/embree_integrator.h"
#include "halflight/base/parallel.h"
#include "halflight/scene/gltf.h"
#include "halflight/shading/random.h"
#include "halflight/unwrap/unwrap.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <ctime>
#include <filesystem>
#include <iterator>
#include <string>
#include <vector>

using namespace halflight;

namespace {

/// Every triangle in a colour of its chart (its first point in uv decides nothing: triangles that share points do).
void writePages(const UnwrappedScene& unwrapped, const std::filesystem::path& directory, const std::string& name)
{
    std::vector<ImageRgba8> pages(std::size_t(unwrapped.pageCount),
                                  ImageRgba8(unwrapped.pageSize, unwrapped.pageSize, u8vec4(16, 16, 16, 255)));
    uint32_t seed = 0;
    for (const Object& object : unwrapped.scene.objects) {
        if (object.lightmap.page < 0) continue;
        ImageRgba8& page = pages[std::size_t(object.lightmap.page)];
        for (const MeshPart& part : unwrapped.scene.meshes[std::size_t(object.mesh)].parts) {
            std::vector<uint32_t> parent(part.positions.size());
            for (uint32_t v = 0; v < parent.size(); ++v) parent[v] = v;
            const auto find = [&](uint32_t v) {
                while (parent[v] != v) v = parent[v] = parent[parent[v]];
                return v;
            };
            for (std::size_t i = 0; i + 2 < part.indices.size(); i += 3) {
                for (std::size_t k = 1; k < 3; ++k) parent[find(part.indices[i + k])] = find(part.indices[i]);
            }
            ++seed;
            for (std::size_t i = 0; i + 2 < part.indices.size(); i += 3) {
                const uint32_t hash = hashCombine(seed, find(part.indices[i]));
                const u8vec4 color(64 + hash % 192, 64 + (hash >> 8) % 192, 64 + (hash >> 16) % 192, 255);
                vec2 c[3];
                for (std::size_t k = 0; k < 3; ++k) {
                    c[k] = (object.lightmap.scale * part.lightmapUv[part.indices[i + k]] + object.lightmap.offset) *
                           float(unwrapped.pageSize);
                }
                const vec2 low = glm::min(c[0], glm::min(c[1], c[2])), high = glm::max(c[0], glm::max(c[1], c[2]));
                const float area = (c[1].x - c[0].x) * (c[2].y - c[0].y) - (c[1].y - c[0].y) * (c[2].x - c[0].x);
                for (int y = std::max(int(low.y), 0); y <= std::min(int(high.y), unwrapped.pageSize - 1); ++y) {
                    for (int x = std::max(int(low.x), 0); x <= std::min(int(high.x), unwrapped.pageSize - 1); ++x) {
                        bool inside = true;
                        for (int k = 0; k < 3; ++k) {
                            const vec2 edge = c[(k + 1) % 3] - c[k], to = vec2(float(x) + 0.5f, float(y) + 0.5f) - c[k];
                            const float reach = 0.5f * (std::abs(edge.x) + std::abs(edge.y));
                            inside &= (edge.x * to.y - edge.y * to.x) * (area < 0.0f ? -1.0f : 1.0f) >= -reach;
                        }
                        if (inside) page(x, y) = color;
                    }
                }
            }
        }
    }
    std::filesystem::create_directories(directory);
    for (std::size_t p = 0; p < pages.size(); ++p) {
        if (const Status status = writePng(directory / (name + "_" + std::to_string(p) + ".png"), pages[p]); !status) {
            std::fprintf(stderr, "%s\n", status.error().text().c_str());
        }
    }
}

/// A ball whose surface goes up and down: one closed mesh of about that many triangles.
MeshPart bumpyBall(int triangles)
{
    const int rings = std::max(2, int(std::sqrt(0.25 * triangles)));
    const int segments = 2 * rings;
    MeshPart part;
    for (int i = 0; i <= rings; ++i) {
        for (int j = 0; j < segments; ++j) {
            const float theta = kPi * float(i) / float(rings);
            const float phi = 2.0f * kPi * float(j) / float(segments);
            const vec3 n(std::sin(theta) * std::cos(phi), std::cos(theta), std::sin(theta) * std::sin(phi));
            const float bumps = std::sin(11.0f * n.x) * std::sin(13.0f * n.y) * std::sin(9.0f * n.z) +
                                0.3f * std::sin(47.0f * n.x + 31.0f * n.z) * std::sin(41.0f * n.y);
            part.positions.push_back(n * (2.0f + 0.2f * bumps));
            part.normals.push_back(n);
        }
    }
    const auto at = [&](int i, int j) { return uint32_t(i * segments + j % segments); };
    for (int i = 0; i < rings; ++i) {
        for (int j = 0; j < segments; ++j) {
            if (i > 0) part.indices.insert(part.indices.end(), {at(i, j), at(i, j + 1), at(i + 1, j)});
            if (i + 1 < rings) part.indices.insert(part.indices.end(), {at(i, j + 1), at(i + 1, j + 1), at(i + 1, j)});
        }
    }
    return part;
}

/// Uniform in [0, 1) for each n.
float noise(uint32_t n)
{
    return float(hashCombine(7u, n) >> 8) * 0x1p-24f;
}

/// A ground of hills whose every vertex lies a little too high or too low.
MeshPart noisyField(int triangles)
{
    const auto side = uint32_t(std::max(1.0, std::sqrt(0.5 * triangles)));
    const float step = 10.0f / float(side);
    MeshPart part;
    for (uint32_t z = 0; z <= side; ++z) {
        for (uint32_t x = 0; x <= side; ++x) {
            const vec2 p = step * vec2(float(x), float(z));
            const float hills = 0.3f * std::sin(1.7f * p.x) * std::cos(1.3f * p.y) + 0.1f * std::sin(5.1f * p.x + p.y);
            part.positions.emplace_back(p.x, hills + 0.4f * step * noise(z * (side + 1) + x), p.y);
            part.normals.emplace_back(0.0f, 1.0f, 0.0f);
        }
    }
    for (uint32_t z = 0; z < side; ++z) {
        for (uint32_t x = 0; x < side; ++x) {
            const uint32_t a = z * (side + 1) + x, b = a + 1, c = a + side + 1, d = c + 1;
            part.indices.insert(part.indices.end(), {a, c, b, b, c, d});
        }
    }
    return part;
}

/// Boxes of all sizes on a grid, none touching another.
MeshPart looseBoxes(int triangles)
{
    const auto count = uint32_t(std::max(1, triangles / 12));
    const auto side = uint32_t(std::ceil(std::cbrt(double(count))));
    MeshPart part;
    for (uint32_t i = 0; i < count; ++i) {
        const vec3 center(float(i % side), float(i / side % side), float(i / side / side));
        const vec3 size = 0.2f + 0.6f * vec3(noise(3 * i), noise(3 * i + 1), noise(3 * i + 2));
        for (int axis = 0; axis < 3; ++axis) {
            for (const float face : {-0.5f, 0.5f}) {
                const auto first = uint32_t(part.positions.size());
                vec3 n(0.0f), u(0.0f), v(0.0f);
                n[axis] = face;
                u[(axis + 1) % 3] = 0.5f;
                v[(axis + 2) % 3] = face;
                for (const vec3 corner : {n - u - v, n + u - v, n + u + v, n - u + v}) {
                    part.positions.push_back(center + corner * size);
                    part.normals.push_back(2.0f * n);
                }
                for (const uint32_t k : {0u, 1u, 2u, 0u, 2u, 3u}) part.indices.push_back(first + k);
            }
        }
    }
    return part;
}

/// Quads of all sizes and directions that go through one another.
MeshPart quadSoup(int triangles)
{
    const auto count = uint32_t(std::max(1, triangles / 2));
    MeshPart part;
    for (uint32_t i = 0; i < count; ++i) {
        const auto random = [&](uint32_t k) {
            return vec3(noise(9 * i + k), noise(9 * i + k + 1), noise(9 * i + k + 2));
        };
        const vec3 center = 20.0f * random(0);
        const vec3 u = 0.5f * (random(3) - 0.5f), v = 0.5f * (random(6) - 0.5f);
        const auto first = uint32_t(part.positions.size());
        for (const vec3 corner : {-u - v, u - v, u + v, v - u}) {
            part.positions.push_back(center + corner);
            part.normals.push_back(glm::normalize(glm::cross(u, v)));
        }
        for (const uint32_t k : {0u, 1u, 2u, 0u, 2u, 3u}) part.indices.push_back(first + k);
    }
    return part;
}

struct MadeMesh {
    const char* name;
    MeshPart (*make)(int triangles);
};
constexpr MadeMesh kMadeMeshes[] = {
    {"ball", bumpyBall}, {"field", noisyField}, {"boxes", looseBoxes}, {"soup", quadSoup}};

Scene sceneOf(MeshPart part)
{
    Scene scene;
    scene.meshes.emplace_back().parts.push_back(std::move(part));
    scene.objects.emplace_back().mesh = 0;
    return scene;
}

double cpuNow()
{
    return double(std::clock()) / CLOCKS_PER_SEC;
}

struct Run {
    Result<UnwrappedScene> result;
    double seconds = 0.0;
    double cpu = 0.0;
    double cpuOfCrossings = 0.0; ///< tests of hidden sides
    double cpuOfSheets = 0.0;
};

Run timedUnwrap(Scene scene, const UnwrapSettings& settings, bool withTests)
{
    const IntegratorFactory factory = embreeIntegrators();
    const IntegrationSettings integration;
    const Progress progress;
    if (withTests) assignShadowmaskChannels(scene, MixedLightingMode::Shadowmask);
    SourceTree tree(factory, integration);
    double ofCrossings = 0.0, ofSheets = 0.0;
    CrossingTest crossings;
    SheetTest sheets;
    if (withTests) {
        crossings = [&, test = hiddenSidesTest(tree)](const Scene& s, std::span<const CrossingPoint> points) {
            const double before = cpuNow();
            std::vector<uint8_t> hidden = test(s, points);
            ofCrossings = cpuNow() - before;
            return hidden;
        };
        sheets = [&, test = sheetSidesTest(tree, TwoSided::Automatic, progress)](const Scene& s, double texelMeters) {
            const double before = cpuNow();
            std::vector<std::vector<SheetTexels>> texels = test(s, texelMeters);
            ofSheets = cpuNow() - before;
            return texels;
        };
    }
    const auto start = std::chrono::steady_clock::now();
    const double cpuStart = cpuNow();
    Run run{unwrap(std::move(scene), settings, progress, crossings, sheets)};
    run.cpu = cpuNow() - cpuStart;
    run.cpuOfCrossings = ofCrossings;
    run.cpuOfSheets = ofSheets;
    run.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    return run;
}

/// Against packings at given densities: one at the density found, and six that halve the bracket up to 8 % more.
void printRatios(const Scene& scene, const UnwrapSettings& settings, bool withTests, const UnwrappedScene& found,
                 double cpu)
{
    UnwrapSettings given = settings;
    given.texelsPerMeter = found.texelsPerMeter;
    const double once = timedUnwrap(scene, given, withTests).cpu;
    double bracket = 0.0;
    double filled = double(found.coverage);
    float fits = found.texelsPerMeter, fails = 1.08f * fits;
    for (int trial = 0; trial < 6; ++trial) {
        given.texelsPerMeter = std::sqrt(fits * fails);
        const Run run = timedUnwrap(scene, given, withTests);
        const bool onOne = run.result && run.result->pageCount == 1;
        bracket += run.cpu;
        if (onOne) filled = std::max(filled, double(run.result->coverage));
        (onOne ? fits : fails) = given.texelsPerMeter;
    }
    std::printf("    CPU seconds: %.2f x one packing at this density, %.2f x a bracket of densities; filled: %.3f x "
                "the bracket's\n",
                cpu / once, cpu / bracket, double(found.coverage) / filled);
}

} // namespace

int main(int argc, char** argv)
{
    UnwrapSettings settings;
    std::filesystem::path images;
    bool withTests = false;
    bool withRatios = false;
    struct Input {
        std::string file;
        const MadeMesh* made = nullptr;
        int triangles = 0;
    };
    std::vector<Input> inputs;
    for (int i = 1; i < argc; ++i) {
        const auto option = [&](const char* name) { return std::strcmp(argv[i], name) == 0 && i + 1 < argc; };
        if (std::strcmp(argv[i], "--tests") == 0)
            withTests = true;
        else if (std::strcmp(argv[i], "--ratios") == 0)
            withRatios = true;
        else if (option("--size"))
            settings.pageSize = std::atoi(argv[++i]);
        else if (option("--padding"))
            settings.paddingTexels = std::atoi(argv[++i]);
        else if (option("--density"))
            settings.texelsPerMeter = float(std::atof(argv[++i]));
        else if (option("--images"))
            images = argv[++i];
        else if (option("--mode")) {
            const std::string mode = argv[++i];
            settings.uvMode = mode == "keep" ? UvMode::Keep : mode == "unwrap" ? UvMode::Unwrap : UvMode::Auto;
        } else {
            const auto made = std::find_if(std::begin(kMadeMeshes), std::end(kMadeMeshes), [&](const MadeMesh& mesh) {
                return option((std::string("--") + mesh.name).c_str());
            });
            if (made == std::end(kMadeMeshes))
                inputs.push_back({argv[i]});
            else
                inputs.push_back({made->name, made, std::atoi(argv[++i])});
        }
    }
    std::printf("%-36s %9s %7s %5s %8s %8s %8s %8s %8s %8s\n", "file", "triangles", "charts", "pages", "texel/m",
                "filled", "padded", "stretch", "seconds", "cpu-s");
    int failures = 0;
    for (const auto& [file, made, wanted] : inputs) {
        Result<Scene> scene = made ? Result<Scene>(sceneOf(made->make(wanted))) : readScene(file);
        if (!scene) {
            std::fprintf(stderr, "%s: %s\n", file.c_str(), scene.error().text().c_str());
            ++failures;
            continue;
        }
        std::size_t triangles = 0;
        for (const Mesh& mesh : scene->meshes) triangles += mesh.triangleCount();
        const Scene source = withRatios ? *scene : Scene();
        const Run run = timedUnwrap(std::move(*scene), settings, withTests);
        const Result<UnwrappedScene>& result = run.result;
        const std::string name = made ? file : std::filesystem::path(file).stem().string();
        if (!result) {
            std::fprintf(stderr, "%s: %s\n", file.c_str(), result.error().text().c_str());
            ++failures;
            continue;
        }
        double stretch = 0.0;
        for (const MeshUnwrapReport& mesh : result->meshes) stretch = std::max(stretch, double(mesh.areaStretch));
        std::printf("%-36s %9zu %7d %5d %8.3f %7.1f%% %7.1f%% %8.3f %8.2f %8.2f\n", name.c_str(), triangles,
                    result->chartCount, result->pageCount, double(result->texelsPerMeter),
                    100.0 * double(result->coverage), 100.0 * double(result->coverageWithPadding), stretch, run.seconds,
                    run.cpu);
        if (withTests)
            std::printf("    CPU seconds of rays for crossings %.2f, for sheets %.2f\n", run.cpuOfCrossings,
                        run.cpuOfSheets);
        if (withRatios) printRatios(source, settings, withTests, *result, run.cpu);
        for (const MeshUnwrapReport& mesh : result->meshes) {
            if (!mesh.reason.empty()) std::printf("    mesh %d: %s\n", mesh.mesh, mesh.reason.c_str());
        }
        for (const std::string& warning : result->warnings) std::printf("    %s\n", warning.c_str());
        if (!images.empty()) writePages(*result, images, name);
    }
    return failures == 0 ? 0 : 1;
}
