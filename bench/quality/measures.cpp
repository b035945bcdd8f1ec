#include "quality/measures.h"
#include "bake/pages/dilate.h"
#include "bake/seams/seams.h"
#include "bake/texels/rasterize.h"
#include "bake/texels/texel_places.h"

#include "quality/baked.h"

#include "halflight/shading/sh.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <optional>

namespace halflight::quality {

Figures failed(const std::string& item, const std::string& scene, const Error& error)
{
    return {{item, scene, error.text(), std::numeric_limits<double>::infinity(), 0.0, ""}};
}

double percentile(std::vector<double>& values, double share)
{
    if (values.empty()) return 0.0;
    const auto at = values.begin() + std::ptrdiff_t(share * double(values.size() - 1));
    std::nth_element(values.begin(), at, values.end());
    return *at;
}

BakeSettings settingsFor(MixedLightingMode mode, float texelsPerMeter, int samples, int bounces)
{
    BakeSettings settings;
    settings.mode = mode;
    settings.texelsPerMeter = texelsPerMeter;
    settings.lightmapSize = 512;
    settings.samples = samples;
    settings.shadowSamples = 64;
    settings.bounces = bounces;
    settings.probeSpacingMeters = 1.0e3f; // a handful
    return settings;
}

double luminanceOf(vec3 light)
{
    return double(luminance(light));
}

// Tops of plates have the sun's light exactly, undersides none.
Figures measureEdges(const std::filesystem::path& assets)
{
    Figures figures;
    for (const int padding : {2, 4}) {
        BakeSettings settings = settingsFor(MixedLightingMode::Shadowmask, 37.0f, 1, 0);
        settings.paddingTexels = padding;
        auto baked = bakeFile(assets / "quality/rims.glb", settings);
        if (!baked) return failed("edges", "quality/rims.glb", baked.error());
        double worst[2] = {0.0, 0.0};
        forSurface(*baked, [&](const SurfaceSample& s) {
            const double truth = s.geometricNormal.y > 0.9f ? 10.0 : 0.0;
            if (s.geometricNormal.y < 0.9f && s.geometricNormal.y > -0.9f) return; // sides graze the light
            const vec3 values[2] = {baked->light(s.page, s.texel), baked->lightBicubic(s.page, s.texel)};
            for (int i = 0; i < 2; ++i) worst[i] = std::max(worst[i], std::abs(double(values[i].y) - truth) / 10.0);
        });
        const std::string at = ", padding " + std::to_string(padding);
        figures.push_back({"edges", "quality/rims.glb", "largest rim, bilinear" + at, 100.0 * worst[0], 0.5, "%"});
        figures.push_back({"edges", "quality/rims.glb", "largest rim, bicubic" + at, 100.0 * worst[1],
                           padding >= 4 ? 0.5 : 100.0, "%"});
    }
    return figures;
}

// The front of a curtain has the sun's light by its cosine, the back none, on either side of hems with smooth normals.
static Figures measureHems(const std::filesystem::path& assets)
{
    Figures figures;
    for (const float density : {10.0f, 25.0f}) {
        auto baked =
            bakeFile(assets / "quality/curtain.glb", settingsFor(MixedLightingMode::Shadowmask, density, 1, 0));
        if (!baked) return failed("seams", "quality/curtain.glb", baked.error());
        double back = 0.0;
        double front = 0.0;
        std::size_t count = 0;
        const double sun = 10.0;
        forSurface(*baked, [&](const SurfaceSample& s) {
            const double light = luminanceOf(baked->light(s.page, s.texel)) / sun;
            if (s.geometricNormal.z < -0.5f) back = std::max(back, light);
            if (s.geometricNormal.z < 0.5f) return;
            const double error = light - double(s.normal.z);
            front += error * error;
            ++count;
        });
        const std::string at = ", " + std::to_string(int(density)) + " texels/m";
        figures.push_back({"seams", "quality/curtain.glb", "hems: brightest point of the back, of the sun's light" + at,
                           100.0 * back, 0.1, "%"});
        figures.push_back({"seams", "quality/curtain.glb", "hems: RMS error of the front, of the sun's light" + at,
                           100.0 * std::sqrt(front / double(count)), 3.0, "%"});
    }
    return figures;
}

Figures measureSeams(const std::filesystem::path& assets)
{
    auto baked = bakeFile(assets / "quality/seams.glb", settingsFor(MixedLightingMode::Shadowmask, 20.0f, 256, 2));
    if (!baked) return failed("seams", "quality/seams.glb", baked.error());
    std::vector<double> steps[4];
    const char* names[4] = {"ball", "can", "chamfered box", "floor tiles"};
    const Scene& scene = baked->result.baked.scene;
    const std::vector<SeamSample> seams = findSeams(baked->geometry, baked->pageSize);
    for (const SeamSample& seam : seams) {
        const double a = luminanceOf(baked->light(seam.pageA, seam.texelA));
        const double b = luminanceOf(baked->light(seam.pageB, seam.texelB));
        const std::string& name = scene.objects[std::size_t(seam.objectA)].name;
        const int kind = name.starts_with("ball") ? 0 : name.starts_with("can") ? 1 : name.starts_with("chamf") ? 2 : 3;
        steps[kind].push_back(std::abs(a - b) / std::max(0.5 * (a + b), 1.0e-3));
    }
    Figures figures;
    for (int kind = 0; kind < 4; ++kind) {
        const std::string count = std::to_string(steps[kind].size()) + " places";
        const bool none = steps[kind].empty();
        const double most =
            none ? std::numeric_limits<double>::infinity() : *std::max_element(steps[kind].begin(), steps[kind].end());
        figures.push_back({"seams", "quality/seams.glb", std::string(names[kind]) + ", largest step of " + count,
                           100.0 * most, 1.0, "%"});
        figures.push_back({"seams", "quality/seams.glb", std::string(names[kind]) + ", 99th percentile",
                           100.0 * percentile(steps[kind], 0.99), 1.0, "%"});
    }
    const Figures hems = measureHems(assets);
    figures.insert(figures.end(), hems.begin(), hems.end());
    return figures;
}

Figures measurePenumbra(const std::filesystem::path& assets)
{
    auto baked = bakeFile(assets / "tests/penumbra.glb", settingsFor(MixedLightingMode::Shadowmask, 40.0f, 1, 0));
    if (!baked || baked->masks.empty()) return failed("masks", "tests/penumbra.glb", baked ? Error{} : baked.error());
    const double halfWidth = 2.0 * std::tan(glm::radians(2.0));
    double worst = 0.0;
    double squares = 0.0;
    std::size_t count = 0;
    // Where the attenuation crosses 10 % and 90 %, between neighbouring points along x.
    std::vector<double> low, high;
    forSurface(*baked, [&](const SurfaceSample& s) {
        if (s.geometricNormal.y < 0.9f || std::abs(s.position.x) > 0.3f || std::abs(s.position.z) > 1.9f) return;
        const double t = std::clamp(double(s.position.x) / halfWidth, -1.0, 1.0);
        const double truth = 0.5 + (t * std::sqrt(1.0 - t * t) + std::asin(t)) / kPi;
        const double error = double(baked->mask(s.page, s.texel, 0)) - truth;
        worst = std::max(worst, std::abs(error));
        squares += error * error;
        ++count;
        const double value = double(baked->mask(s.page, s.texel, 0));
        if (std::abs(value - 0.1) < 0.01) low.push_back(s.position.x);
        if (std::abs(value - 0.9) < 0.01) high.push_back(s.position.x);
    });
    const auto mean = [](const std::vector<double>& v) {
        return v.empty() ? 0.0 : std::accumulate(v.begin(), v.end(), 0.0) / double(v.size());
    };
    const double t90 = 0.6870; // where the segment's share is 90 %
    const double width = (mean(high) - mean(low)) / (2.0 * t90 * halfWidth);
    return {{"masks", "tests/penumbra.glb", "half-plane penumbra, RMS error",
             100.0 * std::sqrt(squares / double(count)), 2.0, "%"},
            {"masks", "tests/penumbra.glb", "half-plane penumbra, largest error", 100.0 * worst, 8.0, "%"},
            {"masks", "tests/penumbra.glb", "10–90 % width against the analytic one, difference",
             100.0 * std::abs(width - 1.0), 5.0, "%"}};
}

Figures measureTerminator(const std::filesystem::path& assets)
{
    auto baked = bakeFile(assets / "quality/terminator.glb", settingsFor(MixedLightingMode::Shadowmask, 24.0f, 1, 0));
    if (!baked || baked->masks.empty())
        return failed("masks", "quality/terminator.glb", baked ? Error{} : baked.error());
    const vec3 toSun = -baked->result.baked.scene.lights[0].direction();
    double worstRound = 1.0;
    double worstFloor = 1.0;
    std::size_t dark = 0;
    std::size_t count = 0;
    forSurface(*baked, [&](const SurfaceSample& s) {
        const double value = double(baked->mask(s.page, s.texel, 0));
        if (s.position.y < -2.0f) {
            if (s.geometricNormal.y > 0.9f) worstFloor = std::min(worstFloor, value);
            return;
        }
        if (glm::dot(s.normal, toSun) < 0.05f) return;
        worstRound = std::min(worstRound, value);
        dark += value < 0.98 ? 1 : 0;
        ++count;
    });
    return {
        {"masks", "quality/terminator.glb", "round objects: points that face the smooth light and are shadowed",
         100.0 * double(dark) / double(std::max<std::size_t>(count, 1)), 0.1, "%"},
        {"masks", "quality/terminator.glb", "round objects: darkest such point", 100.0 * (1.0 - worstRound), 10.0, "%"},
        {"masks", "quality/terminator.glb", "floor grazed at 1.5°: darkest point", 100.0 * (1.0 - worstFloor), 0.5,
         "%"}};
}

namespace {

/// The board of mask_edges.glb.
constexpr vec2 kBoard[] = {{-1.2f, -0.9f}, {0.9f, -1.1f}, {1.1f, 0.2f}, {0.3f, 0.35f}, {0.35f, 1.1f}, {-1.0f, 0.8f}};

bool underBoard(vec2 p)
{
    bool inside = false;
    for (std::size_t i = 0, j = std::size(kBoard) - 1; i < std::size(kBoard); j = i++) {
        const vec2 a = kBoard[i];
        const vec2 b = kBoard[j];
        if ((a.y > p.y) != (b.y > p.y) && p.x < (b.x - a.x) * (p.y - a.y) / (b.y - a.y) + a.x) inside = !inside;
    }
    return inside;
}

/// Mean error over the floor of exact shares of light in its texels (16 x 16 points each), filtered bilinearly.
double supersampledBlur(const Baked& baked)
{
    const TexelMap map = rasterizeTexels(baked.geometry, baked.pageSize, baked.result.report.pageCount);
    Baked exact = baked;
    std::vector<vec4> shares(map.texels.size(), vec4(1.0f));
    for (std::size_t i = 0; i < shares.size(); ++i) {
        const Texel& texel = map.texels[i];
        const TexelFragment& f = map.fragments[texel.firstFragment];
        const auto [a, b, c] = baked.geometry.texelsOf(f.triangle);
        const auto [p0, q1, q2] = baked.geometry.cornersOf(f.triangle);
        if (baked.geometry.geometricNormal(f.triangle).y < 0.9f) continue;
        // The floor is flat: its triangle's map from texels to the world holds all over.
        const mat2 texelFromWeights(b - a, c - a);
        const mat2 weightsFromTexel = glm::inverse(texelFromWeights);
        const vec3 p1 = q1 - p0;
        const vec3 p2 = q2 - p0;
        float lit = 0.0f;
        for (int s = 0; s < 256; ++s) {
            const vec2 w = weightsFromTexel * (vec2(texel.x, texel.y) + (vec2(s % 16, s / 16) + 0.5f) / 16.0f - a);
            const vec3 p = p0 + w.x * p1 + w.y * p2;
            lit += underBoard({p.x, p.z}) ? 0.0f : 1.0f / 256.0f;
        }
        shares[i].x = lit;
    }
    exact.masks = dilate(map, shares, 2);
    double error = 0.0;
    std::size_t count = 0;
    forSurface(exact, [&](const SurfaceSample& s) {
        if (s.geometricNormal.y < 0.9f || std::abs(s.position.y) > 0.01f) return;
        error +=
            std::abs(double(exact.mask(s.page, s.texel, 0)) - (underBoard({s.position.x, s.position.z}) ? 0.0 : 1.0));
        ++count;
    });
    return error / double(count);
}

} // namespace

Figures measureMaskEdges(const std::filesystem::path& assets)
{
    // Blur: the wrongly lit or shadowed area along the outline, as the width of a band in texels at 20 texels/m. A
    // texel's exact share of light, filtered bilinearly, is a ramp two texels wide whose error is 1/3 of a texel for an
    // edge along the texels and less askew: "plain supersampling" below is what that gives on this outline.
    constexpr double kOutlineMeters = 2.1095 + 1.3153 + 0.8139 + 0.7517 + 1.3829 + 1.7117;
    Figures figures;
    double supersampled = 0.0;
    struct Case {
        float density;
        MaskEncoding encoding;
    };
    for (const Case c : {Case{20.0f, MaskEncoding::Attenuation}, Case{10.0f, MaskEncoding::Attenuation},
                         Case{10.0f, MaskEncoding::Distance}}) {
        BakeSettings settings = settingsFor(MixedLightingMode::Shadowmask, c.density, 1, 0);
        settings.maskEncoding = c.encoding;
        auto baked = bakeFile(assets / "quality/mask_edges.glb", settings);
        if (!baked || baked->masks.empty())
            return failed("masks", "quality/mask_edges.glb", baked ? Error{} : baked.error());
        double error = 0.0;
        std::size_t count = 0;
        forSurface(*baked, [&](const SurfaceSample& s) {
            if (s.geometricNormal.y < 0.9f || std::abs(s.position.y) > 0.01f) return;
            const double truth = underBoard({s.position.x, s.position.z}) ? 0.0 : 1.0;
            error += std::abs(double(baked->mask(s.page, s.texel, 0)) - truth);
            ++count;
        });
        const double width = 20.0 * error / double(count) * 16.0 / kOutlineMeters;
        const bool distance = c.encoding == MaskEncoding::Distance;
        if (c.density == 20.0f) supersampled = supersampledBlur(*baked) * 16.0 * 20.0 / kOutlineMeters;
        if (c.density == 20.0f)
            figures.push_back({"masks", "quality/mask_edges.glb",
                               "blur of a hard edge, plain supersampling at 20 texels/m", 100.0 * supersampled, 100.0,
                               "% of a texel"});
        figures.push_back({"masks", "quality/mask_edges.glb",
                           std::string("blur of a hard edge, ") + (distance ? "distance field" : "attenuation") +
                               " at " + std::to_string(int(c.density)) + " texels/m",
                           100.0 * width,
                           c.density == 20.0f ? 105.0 * supersampled
                           : distance         ? 50.0 * supersampled
                                              : 100.0,
                           "% of a texel"});
    }
    return figures;
}

// A bake of few samples against one of many on the same texels: denoised it must be closer than not, everywhere and
// where boxes meet the floor.
Figures measureContact(const std::filesystem::path& assets, int truthSamples)
{
    const std::filesystem::path file = assets / "quality/contact.glb";
    BakeSettings settings = settingsFor(MixedLightingMode::Shadowmask, 14.0f, 32, 1);
    settings.denoiser = Denoiser::Off;
    settings.samples = truthSamples;
    settings.seed = 99;
    const auto truth = bakeFile(file, settings);
    if (!truth) return failed("noise", "quality/contact.glb", truth.error());
    const TexelMap map = rasterizeTexels(truth->geometry, truth->pageSize, truth->result.report.pageCount);
    // Within 25 cm of the box's and the plinth's foot, on the floor beside them.
    std::vector<uint8_t> contact(map.texels.size());
    for (std::size_t i = 0; i < map.texels.size(); ++i) {
        const TexelPlace place = placeOf(truth->geometry, map, map.texels[i]);
        for (const vec4 foot : {vec4(-0.8f, -0.5f, 0.35f, 0.35f), vec4(0.8f, 0.5f, 0.5f, 0.3f)}) {
            const float turn = glm::radians(foot.x < 0.0f ? 20.0f : -10.0f);
            const vec2 d(place.position.x - foot.x, place.position.z - foot.y);
            const vec2 local(std::cos(turn) * d.x - std::sin(turn) * d.y, std::sin(turn) * d.x + std::cos(turn) * d.y);
            const vec2 beyond = glm::max(glm::abs(local) - vec2(foot.z, foot.w), vec2(0.0f));
            if (place.position.y < 0.01f && glm::length(beyond) < 0.25f) contact[i] = 1;
        }
    }
    struct Errors {
        double all = 0.0;
        double contact = 0.0;
    };
    const auto errorsOf = [&](int samples, bool finished) -> std::optional<Errors> {
        settings.seed = 1;
        settings.samples = samples;
        settings.denoiser = finished ? Denoiser::BuiltIn : Denoiser::Off;
        const auto baked = bakeFile(file, settings);
        if (!baked) return std::nullopt;
        std::array<double, 2> squares{};
        std::array<double, 2> reference{};
        for (std::size_t i = 0; i < map.texels.size(); ++i) {
            const Texel& texel = map.texels[i];
            const double t = luminanceOf(truth->lightmaps[texel.page](texel.x, texel.y));
            const double difference = luminanceOf(baked->lightmaps[texel.page](texel.x, texel.y)) - t;
            for (std::size_t k = 0; k <= contact[i]; ++k) {
                reference[k] += t * t;
                squares[k] += difference * difference;
            }
        }
        return Errors{100.0 * std::sqrt(squares[0] / reference[0]), 100.0 * std::sqrt(squares[1] / reference[1])};
    };
    Figures figures;
    const std::string scene = "quality/contact.glb";
    // With few rays denoising has to help; with many it must not take away what they found.
    struct Case {
        int samples;
        double limitAll;
        double limitContact;
    };
    for (const Case c : {Case{32, 0.85, 0.9}, Case{128, 0.85, 1.1}}) {
        const std::optional<Errors> raw = errorsOf(c.samples, false);
        const std::optional<Errors> finished = errorsOf(c.samples, true);
        if (!raw || !finished) return failed("noise", scene, {ErrorCode::FileInvalid, "could not be baked"});
        const std::string rays = std::to_string(c.samples) + " rays";
        figures.push_back(
            {"noise", scene, "relative RMSE, " + rays + ", all texels traced, not denoised", raw->all, 100.0, "%"});
        figures.push_back({"noise", scene, "… as bakes are", finished->all, c.limitAll * raw->all, "%"});
        figures.push_back({"noise", scene, "within 25 cm of contact, " + rays + ", all traced, not denoised",
                           raw->contact, 100.0, "%"});
        figures.push_back({"noise", scene, "… as bakes are", finished->contact, c.limitContact * raw->contact, "%"});
    }
    return figures;
}

} // namespace halflight::quality
