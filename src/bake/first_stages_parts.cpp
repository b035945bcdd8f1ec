#include "bake/first_stages_parts.h"

#include "bake/cache/cache.h"

#include "halflight/base/bytes.h"
#include "halflight/scene/fingerprint.h"

#include <algorithm>
#include <filesystem>

namespace halflight {
namespace {

constexpr uint32_t kFrontVersion = 6; ///< raised when the first stages make other results of the same input
constexpr const char* kUnwrapped = "unwrapped";
constexpr const char* kGeometry = "geometry";
constexpr const char* kTexels = "texels";
constexpr const char* kSheets = "sheets";

/// Calls archive(members…) for all members of a part of a mesh. Structured bindings name them all: a new member is a
/// compile error here.
template<typename Archive, typename Part> void archiveMeshPart(Archive& archive, Part& part)
{
    auto& [positions, normals, tangents, uv, colors, indices, material, lightmapUv, sourceVertex, cutVertices,
           sourcePrimitive, lightmapTexCoord, side, texelSides] = part;
    archive(positions, normals, tangents, colors, indices, material, lightmapUv, sourceVertex);
    for (auto& set : uv) archive(set);
    archive(cutVertices, sourcePrimitive, lightmapTexCoord, side, texelSides);
}

template<typename Archive, typename Unwrapped> void archiveNumbers(Archive& archive, Unwrapped& u)
{
    auto& [scene, pageSize, pageCount, texelsPerMeter, densityFrom, chartCount, cuts, coverage, coverageWithPadding,
           meshes, warnings] = u;
    archive(pageSize, pageCount, texelsPerMeter, densityFrom, chartCount, cuts, coverage, coverageWithPadding);
}

template<typename Archive, typename Report> void archiveMeshReport(Archive& archive, Report& report)
{
    auto& [mesh, kept, reason, charts, areaStretch] = report;
    archive(mesh, kept, reason, charts, areaStretch);
}

/// As archiveMeshPart(); `frames` and `partOfBlock` follow from the others.
template<typename Archive, typename Geometry> void archiveGeometry(Archive& archive, Geometry& g)
{
    auto& [parts, instances, triangles, solid, flipped, texelSides, positions, normals, uv, colors, lightmapTexel,
           frames, partOfBlock] = g;
    archive(parts, instances, triangles, solid, flipped, texelSides, positions, normals, colors, lightmapTexel);
    for (auto& set : uv) archive(set);
}

template<typename Archive, typename Map> void archiveTexels(Archive& archive, Map& map)
{
    auto& [pageSize, pageCount, chartCount, texels, fragments] = map;
    archive(pageSize, pageCount, chartCount, texels, fragments);
}

/// Resizes a list to the length that `reader` has next; false for more than `most`.
template<typename T> bool readLength(ByteReader& reader, std::vector<T>& list)
{
    constexpr uint64_t kMost = 1u << 28;
    uint64_t length = 0;
    reader.read(length);
    if (!reader.ok() || length > kMost) return false;
    list.resize(std::size_t(length));
    return true;
}

/// The name that a part of the first stages is kept under: a hash of the scene's `content` and of the settings that lay
/// out its lightmap.
std::string frontName(const Hash128& content, const BakeSettings& settings)
{
    Hasher hasher;
    hasher.add(kFrontVersion).add(content).add(int(settings.mode)).add(int(settings.uvMode));
    hasher.add(settings.texelsPerMeter).add(resolveQuality(settings).lightmapSize).add(int(settings.lightmapSize == 0));
    hasher.add(settings.paddingTexels).add(int(settings.twoSided));
    return hasher.hash().hex();
}

} // namespace

std::vector<std::string> moveFoldersAway(const PartFolder& parts)
{
    namespace fs = std::filesystem;
    std::vector<fs::path> folders;
    std::error_code ec;
    for (fs::directory_iterator entry(parts.path(), ec), end; !ec && entry != end; entry.increment(ec)) {
        std::error_code gone;
        const bool isPart = entry->path() == parts.fileOf(entry->path().stem().string());
        if (isPart && fs::is_directory(entry->symlink_status(gone))) folders.push_back(entry->path());
    }
    std::sort(folders.begin(), folders.end()); // a folder has no order of its own
    std::vector<std::string> sentences;
    for (const fs::path& folder : folders) {
        fs::path other = folder.string() + ".broken";
        for (int i = 2; fs::exists(fs::symlink_status(other, ec)); ++i)
            other = folder.string() + ".broken-" + std::to_string(i);
        fs::rename(folder, other, ec);
        if (ec) continue; // another process was faster, or writing the part says why
        sentences.push_back(folder.string() + " was a folder where a file of the cache belongs: it is " +
                            other.filename().string() + " now, with what is in it");
    }
    return sentences;
}

std::optional<PartFolder> frontFolder(const Scene& scene, const BakeSettings& settings,
                                      const std::filesystem::path& cache)
{
    if (cache.empty()) return std::nullopt;
    const std::string name = frontName(contentHash(scene), settings);
    std::error_code ec;
    // A bake of some objects may still be refused, and then leaves nothing behind.
    if (!settings.only.empty() && !std::filesystem::is_directory(cache / (name + ".front"), ec)) return std::nullopt;
    return openBakeFolder(cache, name, ".front");
}

SheetTest keptSheetTest(const Scene& scene, const BakeSettings& settings, const std::filesystem::path& cache,
                        SheetTest test, const SourceTree& tree, const Progress& progress)
{
    if (cache.empty()) return test;
    const std::string name = frontName(surfacesHash(scene), settings);
    const bool keeps = settings.only.empty(); // a bake of some objects may still be refused, and leaves nothing behind
    return [=, &tree, &progress, test = std::move(test)](const Scene& cut, double texelMeters) {
        std::vector<std::vector<SheetTexels>> texels(cut.meshes.size());
        if (const auto bytes = PartFolder(cache / (name + ".sheets")).read(kSheets)) {
            ByteReader reader(*bytes);
            bool fits = true;
            for (std::size_t m = 0; m < texels.size(); ++m) {
                reader.read(texels[m]);
                fits = fits && (texels[m].empty() || texels[m].size() == cut.meshes[m].triangleCount());
            }
            if (fits && reader.complete()) return texels;
        }
        texels = test(cut, texelMeters);
        if (!keeps || progress.cancelled() || !tree.status()) return texels;
        ByteWriter writer;
        for (const std::vector<SheetTexels>& ofMesh : texels) writer.add(ofMesh);
        openBakeFolder(cache, name, ".sheets").write(kSheets, writer.take());
        return texels;
    };
}

void keepUnwrapped(PartFolder& folder, const UnwrappedScene& unwrapped)
{
    ByteWriter writer;
    archiveNumbers(writer, unwrapped);
    writer.add(uint64_t(unwrapped.meshes.size()));
    for (const MeshUnwrapReport& report : unwrapped.meshes) archiveMeshReport(writer, report);
    writer.add(uint64_t(unwrapped.warnings.size()));
    for (const std::string& warning : unwrapped.warnings) writer.add(warning);
    writer.add(uint64_t(unwrapped.scene.meshes.size()));
    for (const Mesh& mesh : unwrapped.scene.meshes) {
        writer(mesh.name, mesh.sourceMesh, uint64_t(mesh.parts.size()));
        for (const MeshPart& part : mesh.parts) archiveMeshPart(writer, part);
    }
    writer.add(uint64_t(unwrapped.scene.objects.size()));
    for (const Object& object : unwrapped.scene.objects) writer(object.mesh, object.lightmap);
    folder.write(kUnwrapped, writer.take());
}

bool takeUnwrapped(const PartFolder& folder, Scene& scene, UnwrappedScene& unwrapped)
{
    const std::optional<std::vector<std::byte>> bytes = folder.read(kUnwrapped);
    if (!bytes) return false;
    ByteReader reader(*bytes);
    UnwrappedScene read;
    archiveNumbers(reader, read);
    if (!readLength(reader, read.meshes)) return false;
    for (MeshUnwrapReport& report : read.meshes) archiveMeshReport(reader, report);
    if (!readLength(reader, read.warnings)) return false;
    for (std::string& warning : read.warnings) reader.read(warning);
    std::vector<Mesh> meshes;
    if (!readLength(reader, meshes)) return false;
    for (Mesh& mesh : meshes) {
        reader(mesh.name, mesh.sourceMesh);
        if (!readLength(reader, mesh.parts)) return false;
        for (MeshPart& part : mesh.parts) archiveMeshPart(reader, part);
    }
    std::vector<Object> objects = scene.objects;
    uint64_t count = 0;
    reader.read(count);
    if (!reader.ok() || count != objects.size()) return false;
    for (Object& object : objects) reader(object.mesh, object.lightmap);
    if (!reader.complete()) return false;
    unwrapped = std::move(read);
    unwrapped.scene = std::move(scene);
    unwrapped.scene.meshes = std::move(meshes);
    unwrapped.scene.objects = std::move(objects);
    return true;
}

void keepGeometry(PartFolder& folder, const BakeGeometry& geometry)
{
    ByteWriter writer;
    archiveGeometry(writer, geometry);
    folder.write(kGeometry, writer.take());
}

bool takeGeometry(const PartFolder& folder, BakeGeometry& geometry)
{
    const std::optional<std::vector<std::byte>> bytes = folder.read(kGeometry);
    if (!bytes) return false;
    ByteReader reader(*bytes);
    BakeGeometry read;
    archiveGeometry(reader, read);
    if (!reader.complete()) return false;
    geometry = std::move(read);
    geometry.findFrames();
    return true;
}

void keepTexels(PartFolder& folder, const TexelMap& map)
{
    ByteWriter writer;
    archiveTexels(writer, map);
    folder.write(kTexels, writer.take());
}

bool takeTexels(const PartFolder& folder, TexelMap& map)
{
    const std::optional<std::vector<std::byte>> bytes = folder.read(kTexels);
    if (!bytes) return false;
    ByteReader reader(*bytes);
    TexelMap read;
    archiveTexels(reader, read);
    if (!reader.complete()) return false;
    map = std::move(read);
    return true;
}

} // namespace halflight
