#pragma once
// `halflight bake --export`: core glTF with pictures of lit surfaces.

#include "bake_options.h"

#include "halflight/scene/export.h"

#include <CLI/CLI.hpp>

#include <string>
#include <vector>

namespace halflight::cli {

struct ExportSummary {
    ExportStyle style = ExportStyle::Unlit;
    float exposureEv = 0.0f;
    bool automatic = false; ///< the exposure
    int scale = 1;          ///< texels of a picture per lightmap texel and side
    int pageSize = 0;
    float strength = 1.0f;
    double clipped = 0.0; ///< share of texels
    ExportReport written;
};

void addExportOptions(CLI::App& app, BakeOptions& options);

/// Options that were given and contradict each other, as a sentence; empty when they do not.
std::string exportContradiction(const CLI::App& app, const BakeOptions& options);

/// What --export changes before the bake: every light is fully baked.
void prepareExport(BakeSettings& settings, Scene& scene);

/// Writes the output. The result's scene moves into it.
Status writeExport(const BakeOptions& options, BakeResult& result, const Progress& progress, ExportSummary& summary);

/// Warnings go to the report.
std::vector<std::string> exportWarnings(const ExportSummary& summary);
void printExport(const ExportSummary& summary);
/// The report with a member "export".
std::string withExport(const std::string& report, const ExportSummary& summary);

} // namespace halflight::cli
