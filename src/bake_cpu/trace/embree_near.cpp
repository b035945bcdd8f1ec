// Triangles near a point, from Embree's trees.
#include "bake_cpu/trace/embree_kernels.h"

namespace halflight {

bool EmbreeKernels::trianglesNear(vec3 center, float radius, std::size_t most, std::vector<uint32_t>& triangles) const
{
    struct Search {
        const RayScene& scene;
        std::size_t most;
        std::vector<uint32_t>& triangles;
        bool tooMany = false;

        static bool visit(RTCPointQueryFunctionArguments* arguments)
        {
            Search& search = *static_cast<Search*>(arguments->userPtr);
            if (search.tooMany || arguments->geomID == NoShadow) return false;
            const RTCPointQueryContext& context = *arguments->context;
            uint32_t geomID = arguments->geomID;
            uint32_t primID = arguments->primID;
            if (context.instStackSize > 0) {
                geomID = context.instID[0];
                const MeshTrees& trees = search.scene.meshTrees();
                primID += trees.treeOf(trees.instances[geomID - KindCount]).firstOfKind[arguments->geomID];
            }
            search.triangles.push_back(search.scene.triangleOf(geomID, primID));
            if (search.triangles.size() <= search.most) return false;
            search.tooMany = true;
            arguments->query->radius = 0.0f; // ends the search
            return true;
        }
    };
    triangles.clear();
    Search search{scene_, most, triangles};
    RTCPointQuery query{center.x, center.y, center.z, 0.0f, radius};
    RTCPointQueryContext context;
    rtcInitPointQueryContext(&context);
    rtcPointQuery(tree_, &query, &context, Search::visit, &search);
    return !search.tooMany;
}

} // namespace halflight
