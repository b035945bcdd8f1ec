// Unwraps glTF files and prints charts, fill and seconds for each; with --images DIR also a picture of every page.
//   bench_unwrap [--size N] [--padding N] [--density X] [--mode auto|keep|unwrap] [--images DIR] [--ball N] FILE...
// --ball N adds a ball with bumps of about N triangles, for what no file at hand is large enough for.

#include "halflight/base/parallel.h"
#include "halflight/base/random.h"
#include "halflight/scene/gltf.h"
#include "halflight/unwrap/unwrap.h"

#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <ctime>
#include <filesystem>
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
Scene bumpyBall(int triangles)
{
    const int rings = std::max(2, int(std::sqrt(0.25 * triangles)));
    const int segments = 2 * rings;
    Scene scene;
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
    Mesh mesh;
    mesh.parts.push_back(std::move(part));
    scene.meshes.push_back(std::move(mesh));
    Object object;
    object.name = "ball";
    object.mesh = 0;
    scene.objects.push_back(object);
    return scene;
}

} // namespace

int main(int argc, char** argv)
{
    UnwrapSettings settings;
    std::filesystem::path images;
    std::vector<std::string> files;
    for (int i = 1; i < argc; ++i) {
        const auto option = [&](const char* name) { return std::strcmp(argv[i], name) == 0 && i + 1 < argc; };
        if (option("--size"))
            settings.pageSize = std::atoi(argv[++i]);
        else if (option("--padding"))
            settings.paddingTexels = std::atoi(argv[++i]);
        else if (option("--density"))
            settings.texelsPerMeter = float(std::atof(argv[++i]));
        else if (option("--ball"))
            files.push_back(std::string(":") + argv[++i]);
        else if (option("--images"))
            images = argv[++i];
        else if (option("--mode")) {
            const std::string mode = argv[++i];
            settings.uvMode = mode == "keep" ? UvMode::Keep : mode == "unwrap" ? UvMode::Unwrap : UvMode::Auto;
        } else
            files.emplace_back(argv[i]);
    }
    std::printf("%-36s %9s %7s %5s %8s %8s %8s %8s %8s %8s\n", "file", "triangles", "charts", "pages", "texel/m",
                "filled", "padded", "stretch", "seconds", "cpu-s");
    int failures = 0;
    for (const std::string& file : files) {
        const bool made = file.starts_with(":");
        Result<Scene> scene = made ? Result<Scene>(bumpyBall(std::atoi(file.c_str() + 1))) : readScene(file);
        if (!scene) {
            std::fprintf(stderr, "%s: %s\n", file.c_str(), scene.error().text().c_str());
            ++failures;
            continue;
        }
        std::size_t triangles = 0;
        for (const Mesh& mesh : scene->meshes) {
            for (const MeshPart& part : mesh.parts) triangles += part.indices.size() / 3;
        }
        const auto start = std::chrono::steady_clock::now();
        const std::clock_t cpuStart = std::clock();
        const Result<UnwrappedScene> result = unwrap(std::move(*scene), settings);
        const double cpu = double(std::clock() - cpuStart) / CLOCKS_PER_SEC;
        const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
        const std::string name = made ? "ball" : std::filesystem::path(file).stem().string();
        if (!result) {
            std::fprintf(stderr, "%s: %s\n", file.c_str(), result.error().text().c_str());
            ++failures;
            continue;
        }
        double stretch = 0.0;
        for (const MeshUnwrapReport& mesh : result->meshes) stretch = std::max(stretch, double(mesh.areaStretch));
        std::printf("%-36s %9zu %7d %5d %8.3f %7.1f%% %7.1f%% %8.3f %8.2f %8.2f\n", name.c_str(), triangles,
                    result->chartCount, result->pageCount, double(result->texelsPerMeter),
                    100.0 * double(result->coverage), 100.0 * double(result->coverageWithPadding), stretch, seconds,
                    cpu);
        for (const MeshUnwrapReport& mesh : result->meshes) {
            if (!mesh.reason.empty()) std::printf("    mesh %d: %s\n", mesh.mesh, mesh.reason.c_str());
        }
        for (const std::string& warning : result->warnings) std::printf("    %s\n", warning.c_str());
        if (!images.empty()) writePages(*result, images, name);
    }
    return failures == 0 ? 0 : 1;
}
