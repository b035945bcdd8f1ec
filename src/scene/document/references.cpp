#include "scene/document/references.h"

namespace halflight {

Json* find(Json& object, const char* key)
{
    if (!object.is_object()) return nullptr;
    const auto it = object.find(key);
    return it == object.end() ? nullptr : &*it;
}

void each(Json* list, FunctionRef<void(Json&)> visit)
{
    if (list == nullptr || !list->is_structured()) return;
    for (Json& item : *list) visit(item);
}

void eachPrimitive(Json& document, FunctionRef<void(Json&)> visit)
{
    each(find(document, "meshes"), [&](Json& mesh) { each(find(mesh, "primitives"), visit); });
}

void visitAccessors(Json& document, FunctionRef<void(Json&)> visit)
{
    const auto visitMember = [&](Json& object, const char* key) {
        if (Json* index = find(object, key)) visit(*index);
    };
    eachPrimitive(document, [&](Json& primitive) {
        visitMember(primitive, "indices");
        each(find(primitive, "attributes"), visit);
        each(find(primitive, "targets"), [&](Json& target) { each(&target, visit); });
    });
    each(find(document, "skins"), [&](Json& skin) { visitMember(skin, "inverseBindMatrices"); });
    each(find(document, "animations"), [&](Json& animation) {
        each(find(animation, "samplers"), [&](Json& sampler) {
            visitMember(sampler, "input");
            visitMember(sampler, "output");
        });
    });
    each(find(document, "nodes"), [&](Json& node) {
        if (Json* extensions = find(node, "extensions")) {
            if (Json* instancing = find(*extensions, "EXT_mesh_gpu_instancing"))
                each(find(*instancing, "attributes"), visit);
        }
    });
    if (Json* extensions = find(document, "extensions")) {
        if (Json* root = find(*extensions, "HALFLIGHT_mixed_lighting")) {
            if (Json* probes = find(*root, "probes")) {
                for (const char* key : kProbeAccessors) visitMember(*probes, key);
            }
            each(find(*root, "groups"), [&](Json& group) { visitMember(group, "radiance"); });
        }
    }
}

void visitViews(Json& document, FunctionRef<void(Json&)> visit)
{
    const auto visitMember = [&](Json& object) {
        if (Json* index = find(object, "bufferView")) visit(*index);
    };
    each(find(document, "accessors"), [&](Json& accessor) {
        visitMember(accessor);
        if (Json* sparse = find(accessor, "sparse")) {
            for (const char* key : {"indices", "values"}) {
                if (Json* part = find(*sparse, key)) visitMember(*part);
            }
        }
    });
    each(find(document, "images"), visitMember);
    if (Json* extensions = find(document, "extensions")) {
        if (Json* root = find(*extensions, "HALFLIGHT_mixed_lighting")) {
            each(find(*root, "lightmaps"), visitMember);
            each(find(*root, "lightmapDirections"), visitMember);
            each(find(*root, "shadowmasks"), visitMember);
        }
    }
}

} // namespace halflight
