#include "scene/settings/settings.h"

#include "halflight/base/file.h"
#include "halflight/scene/gltf.h"

#include <sstream>
#include <toml++/toml.h>

namespace halflight {

namespace {

Json jsonFrom(const toml::node& node)
{
    if (const auto* table = node.as_table()) {
        Json object = Json::object();
        for (const auto& [key, value] : *table) object[std::string(key.str())] = jsonFrom(value);
        return object;
    }
    if (const auto* array = node.as_array()) {
        Json list = Json::array();
        for (const auto& value : *array) list.push_back(jsonFrom(value));
        return list;
    }
    if (const auto* text = node.as_string()) return text->get();
    if (const auto* integer = node.as_integer()) return integer->get();
    if (const auto* number = node.as_floating_point()) return number->get();
    if (const auto* flag = node.as_boolean()) return flag->get();
    return "a date"; // no key takes one: the error names the key
}

} // namespace

Result<FileSettings> readSettingsFile(const std::filesystem::path& path)
{
    const std::string name = "settings file " + path.string();
    const auto bytes = readFile(path);
    if (!bytes) return Error{bytes.error().code, name + ": " + bytes.error().message, ""};
    auto settings = parseSettings({reinterpret_cast<const char*>(bytes->data()), bytes->size()});
    if (settings) {
        if (auto& image = settings->scene.skyImage) *image = path.parent_path() / *image;
        return settings;
    }
    const std::string& message = settings.error().message;
    return Error{settings.error().code, name + (message.starts_with("line ") ? ", " : ": ") + message, ""};
}

Result<std::vector<std::filesystem::path>> filesOfSettings(const std::filesystem::path& settingsFile)
{
    const auto settings = readSettingsFile(settingsFile);
    if (!settings) return settings.error();
    std::vector<std::filesystem::path> files;
    if (settings->scene.skyImage) files.emplace_back(*settings->scene.skyImage);
    return files;
}

Result<FileSettings> parseSettings(std::string_view text)
{
    try {
        auto settings = settingsFromTables(jsonFrom(toml::parse(text)));
        if (!settings) return Error{settings.error().code, settings.error().text()};
        return settings;
    } catch (const toml::parse_error& e) {
        return Error{ErrorCode::FileInvalid,
                     "line " + std::to_string(e.source().begin.line) + ": " + std::string(e.description())};
    }
}

} // namespace halflight
