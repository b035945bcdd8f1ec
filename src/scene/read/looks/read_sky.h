#pragma once
// The sky of a scene: colours or a picture, from settings or from an earlier bake.

#include "scene/settings/settings.h"

namespace halflight {

/// What an earlier bake recorded of the sky; nothing of a document without a bake.
SceneSettings recordedSky(const SourceDocument& document);

/// The sky that merged settings give. The picture of an earlier bake is decoded from the document.
Result<Sky> readSky(const SourceDocument& document, const SceneSettings& settings, std::vector<std::string>& warnings);

} // namespace halflight
