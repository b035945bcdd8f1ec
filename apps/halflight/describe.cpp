// The command line as JSON: manual pages and shell completions are made of it (scripts/make_cli_docs.py).

#include "console.h"
#include "json_values.h"

namespace halflight::cli {

namespace {

Json namesOf(const CLI::Option& option)
{
    Json names = Json::array();
    for (const std::string& name : option.get_snames()) names.push_back("-" + name);
    for (const std::string& name : option.get_lnames()) names.push_back("--" + name);
    return names;
}

Json describe(const CLI::Option& option)
{
    Json json;
    if (option.get_positional()) {
        json["positional"] = option.get_name(true);
    } else {
        json["names"] = namesOf(option);
    }
    json["group"] = option.get_group();
    json["description"] = option.get_description();
    json["required"] = option.get_required();
    json["repeats"] = option.get_expected_max() > 1;
    json["value"] = option.get_items_expected_max() > 0 ? option.get_type_name() : std::string();
    return json;
}

Json describe(const CLI::App& app)
{
    Json json = {{"name", app.get_name()}, {"description", app.get_description()}, {"footer", app.get_footer()}};
    json["options"] = Json::array();
    for (const CLI::Option* option : app.get_options())
        if (!option->get_group().empty()) json["options"].push_back(describe(*option)); // others are for tests
    json["commands"] = Json::array();
    for (const CLI::App* command : app.get_subcommands({})) json["commands"].push_back(describe(*command));
    return json;
}

} // namespace

std::string describeCommandLine(const CLI::App& program, std::string_view version)
{
    Json json = describe(program);
    json["version"] = version;
    return json.dump(2);
}

} // namespace halflight::cli
