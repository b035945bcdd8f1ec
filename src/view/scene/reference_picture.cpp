#include "view/scene/reference_picture.h"

#include "halflight/bake_cpu/embree_integrator.h"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <condition_variable>
#include <mutex>
#include <thread>
#include <utility>

namespace halflight::view {
namespace {

using Clock = std::chrono::steady_clock;

/// The first picture has so many times fewer pixels along each side.
constexpr int kFirstSmaller = 4;
/// Samples per pixel at which the picture is good: further ones show no more.
constexpr int kEnoughSamples = 4096;
/// Most samples of one pass, so that the picture gets better every now and then.
constexpr int kMostOfPass = 64;

} // namespace

struct ReferencePicture::Impl {
    struct View {
        std::shared_ptr<const Scene> scene;
        Camera camera;
        ivec2 size{0};
        bool specular = true;

        [[nodiscard]] bool sameAs(const View& other) const
        {
            const Camera& a = camera;
            const Camera& b = other.camera;
            return scene == other.scene && size == other.size && a.worldFromCamera == b.worldFromCamera &&
                   a.verticalFovRadians == b.verticalFovRadians && a.orthographic == b.orthographic &&
                   a.orthographicHeightMeters == b.orthographicHeightMeters && specular == other.specular;
        }
    };

    void run()
    {
        std::unique_lock lock(mutex);
        while (!ends) {
            if (!view.scene && built) {
                lock.unlock();
                renderer.reset();
                built.reset();
                lock.lock();
                continue;
            }
            if (!view.scene || done) {
                wake.wait(lock);
                continue;
            }
            if (const auto rested = changed + rest; Clock::now() < rested) {
                wake.wait_until(lock, rested);
                continue;
            }
            const View current = view;
            cancelled = false;
            lock.unlock();
            refine(current);
            lock.lock();
        }
    }

    /// Passes with more and more samples, until another view is wanted.
    void refine(const View& current)
    {
        if (built != current.scene) {
            renderer.reset();
            built = current.scene;
            prepares = true;
            Result<std::unique_ptr<ReferenceRenderer>> made = ReferenceRenderer::create(*built);
            prepares = false;
            if (made) renderer = std::move(*made);
        }
        const Progress progress{{}, &cancelled};
        ImageRgba32f mean;
        int samples = 0;
        for (uint32_t pass = 0; samples < kEnoughSamples; ++pass) {
            const bool small = pass == 0;
            ReferenceSettings settings;
            settings.samplesPerPixel = small ? 1 : std::clamp(samples, 1, kMostOfPass);
            settings.seed = pass + 1;
            settings.surfaces = referenceSurfaces(current.specular, true);
            const ivec2 size = small ? glm::max(current.size / kFirstSmaller, ivec2(1)) : current.size;
            const Result<ImageRgb32f> picture =
                renderer ? renderer->render(current.camera, size, settings, progress)
                         : Result<ImageRgb32f>(Error{ErrorCode::DeviceFailed, "no memory for the reference", ""});
            if (picture) {
                if (samples == 0) mean = ImageRgba32f(size.x, size.y, vec4(0, 0, 0, 1));
                const float share = float(settings.samplesPerPixel) / float(samples + settings.samplesPerPixel);
                for (std::size_t i = 0; i < mean.texelCount(); ++i)
                    mean.data()[i] = vec4(glm::mix(vec3(mean.data()[i]), picture->data()[i], share), 1.0f);
                if (!small) samples += settings.samplesPerPixel;
            }
            Picture next{mean, std::max(samples, 1)}; // before the lock, which the window waits for
            const std::lock_guard lock(mutex);
            if (!picture || cancelled || !view.sameAs(current)) {
                done = done || (!picture && !cancelled); // it fails again
                return;
            }
            result = std::move(next);
        }
        const std::lock_guard lock(mutex);
        done = view.sameAs(current);
    }

    explicit Impl(std::chrono::milliseconds restOf) : rest(restOf) {}

    const std::chrono::milliseconds rest;
    std::atomic<bool> cancelled = false;
    std::atomic<bool> prepares = false;
    std::mutex mutex; ///< guards what follows
    std::condition_variable wake;
    View view;
    Clock::time_point changed = Clock::now();
    bool done = false; ///< no more samples are needed
    bool ends = false;
    std::optional<Picture> result;
    std::shared_ptr<const Scene> built; ///< the thread's: what `renderer` shows
    std::unique_ptr<ReferenceRenderer> renderer;
    std::thread thread; ///< not guarded; the last to be made
};

ReferencePicture::ReferencePicture(std::chrono::milliseconds rest) : impl_(std::make_unique<Impl>(rest))
{
    impl_->thread = std::thread([impl = impl_.get()] { impl->run(); });
}

ReferencePicture::~ReferencePicture()
{
    stop();
}

bool ReferencePicture::follow(const std::shared_ptr<const Scene>& scene, const Camera& camera, ivec2 size,
                              bool specular)
{
    const std::lock_guard lock(impl_->mutex);
    Impl::View wanted{scene, camera, size, specular};
    if (impl_->view.sameAs(wanted)) return false;
    impl_->view = std::move(wanted);
    impl_->changed = Clock::now();
    impl_->done = false;
    impl_->result.reset();
    impl_->cancelled = true;
    impl_->wake.notify_one();
    return true;
}

void ReferencePicture::pause()
{
    (void)follow(nullptr, {}, ivec2(0), true);
}

bool ReferencePicture::works() const
{
    const std::lock_guard lock(impl_->mutex);
    return impl_->view.scene && !impl_->done;
}

bool ReferencePicture::prepares() const
{
    return impl_->prepares;
}

void ReferencePicture::stop()
{
    {
        const std::lock_guard lock(impl_->mutex);
        impl_->ends = true;
        impl_->cancelled = true;
        impl_->wake.notify_one();
    }
    if (impl_->thread.joinable()) impl_->thread.join();
}

std::optional<ReferencePicture::Picture> ReferencePicture::take()
{
    const std::lock_guard lock(impl_->mutex);
    return std::exchange(impl_->result, std::nullopt);
}

} // namespace halflight::view
