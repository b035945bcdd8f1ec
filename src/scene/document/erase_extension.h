#pragma once
#include "scene/document/document.h"

namespace halflight {

/// Takes an extension from an object, and the object's `extensions` where that was the last.
inline void eraseExtension(Json& object, const std::string& name)
{
    if (!object.is_object() || !object.contains("extensions")) return;
    object["extensions"].erase(name);
    if (object["extensions"].empty()) object.erase("extensions");
}

} // namespace halflight
