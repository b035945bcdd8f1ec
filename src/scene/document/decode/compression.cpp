#include "scene/document/decode/compression.h"

#include "halflight/base/encoded_image.h"
#include "scene/document/decode/draco_mesh.h"
#include "scene/document/decode/meshopt_view.h"
#include "scene/document/fallback_buffers.h"

#include <algorithm>
#include <map>

namespace halflight {

bool isCompressedGeometry(std::string_view extension)
{
    return extension == kDracoExtension ||
           std::find(kMeshoptExtensions.begin(), kMeshoptExtensions.end(), extension) != kMeshoptExtensions.end();
}

bool readsCompression(std::string_view extension)
{
    if (extension == kDracoExtension) return DracoMesh::isSupported();
    if (isCompressedGeometry(extension)) return MeshoptView::isSupported();
    return extension == "EXT_texture_webp" && decodesWebp();
}

std::vector<std::string> readableCompression()
{
    std::vector<std::string> names;
    for (const char* name : {kDracoExtension, kMeshoptExtensions[0], kMeshoptExtensions[1], "EXT_texture_webp"}) {
        if (readsCompression(name)) names.emplace_back(name);
    }
    return names;
}

int imageOf(const Json& texture)
{
    const Json& webp = extensionOf(texture, "EXT_texture_webp");
    return integerOf(webp.contains("source") && readsCompression("EXT_texture_webp") ? webp : texture, "source");
}

std::string conversionHint(std::string_view extension)
{
    // Tried with gltf-transform 4.5 and gltfpack 1.3; "copy" decompresses, "ktxdecompress" calls KTX-Software's `ktx`.
    static const std::map<std::string_view, std::string> kCommands = {
        {kDracoExtension, "npx @gltf-transform/cli copy IN.glb OUT.glb"},
        {kMeshoptExtensions[0], "npx @gltf-transform/cli copy IN.glb OUT.glb"},
        {kMeshoptExtensions[1], "npx gltfpack -i IN.glb -o OUT.glb -noq -kn -km -ke"},
        {"EXT_texture_webp", "npx @gltf-transform/cli png IN.glb OUT.glb"},
        {"EXT_texture_avif", "npx @gltf-transform/cli png IN.glb OUT.glb"},
        {"KHR_texture_basisu", "npx @gltf-transform/cli ktxdecompress IN.glb OUT.glb"}};
    const auto it = kCommands.find(extension);
    return it == kCommands.end() ? "" : "; `" + it->second + "` makes a file without it";
}

} // namespace halflight
