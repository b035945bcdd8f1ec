// What a wrong command line most likely meant.

#include "console.h"

#include <algorithm>
#include <numeric>

namespace halflight::cli {

namespace {

// Levenshtein 1966: insertions, deletions and substitutions that turn one word into the other.
std::size_t editDistance(const std::string& a, const std::string& b)
{
    std::vector<std::size_t> row(b.size() + 1);
    std::iota(row.begin(), row.end(), std::size_t(0));
    for (std::size_t i = 1; i <= a.size(); ++i) {
        std::size_t diagonal = row[0];
        row[0] = i;
        for (std::size_t j = 1; j <= b.size(); ++j) {
            const std::size_t substituted = diagonal + (a[i - 1] == b[j - 1] ? 0 : 1);
            diagonal = row[j];
            row[j] = std::min({row[j] + 1, row[j - 1] + 1, substituted});
        }
    }
    return row[b.size()];
}

std::vector<std::string> optionNames(const CLI::App& command)
{
    std::vector<std::string> names;
    for (const CLI::Option* option : command.get_options()) {
        for (const std::string& name : option->get_lnames()) names.push_back("--" + name);
    }
    return names;
}

} // namespace

std::string unknownOption(const CLI::App* command)
{
    if (command == nullptr) return {};
    // CLI11 keeps what is left over in no fixed order.
    for (const std::string& extra : command->remaining()) {
        if (extra.starts_with('-') && extra.size() > 1 && extra != "--") return extra.substr(0, extra.find('='));
    }
    return {};
}

std::string emptyValue(const CLI::App& command)
{
    for (const CLI::Option* option : command.get_options()) {
        if (option->count() == 0) continue;
        for (const std::string& value : option->results()) {
            if (value.empty()) return option->get_name() + " is empty";
        }
    }
    for (const CLI::App* named : command.get_subcommands()) {
        if (std::string sentence = emptyValue(*named); !sentence.empty()) return sentence;
    }
    return {};
}

std::string nearestWord(const std::string& word, const std::vector<std::string>& candidates)
{
    std::string nearest;
    std::size_t least = std::max<std::size_t>(word.size() / 3, 1) + 1;
    for (const std::string& candidate : candidates) {
        const bool begins = word.size() >= 3 && candidate.starts_with(word);
        const std::size_t distance = begins ? 1 : editDistance(word, candidate);
        if (distance >= least) continue;
        least = distance;
        nearest = candidate;
    }
    return nearest;
}

std::string usageHint(const CLI::App& program, const CLI::App* command, const std::vector<std::string>& arguments)
{
    if (command == nullptr) {
        if (arguments.empty() || arguments[0].starts_with('-')) return {};
        std::vector<std::string> names;
        for (const CLI::App* sub : program.get_subcommands({})) names.push_back(sub->get_name());
        const std::string nearest = nearestWord(arguments[0], names);
        return nearest.empty() ? std::string() : "did you mean " + nearest + "?";
    }
    const std::vector<std::string> extras = command->remaining();
    if (extras.empty()) return {};
    if (const std::string option = unknownOption(command); !option.empty()) {
        const std::string nearest = nearestWord(option, optionNames(*command));
        return nearest.empty() ? std::string() : "did you mean " + nearest + "?";
    }
    const CLI::Option* output = command->get_option_no_throw("--output");
    if (output != nullptr && output->count() == 0) return "the output goes after -o: -o " + extras[0];
    return {};
}

} // namespace halflight::cli
