# Tests that scripts/test.sh leaves to --all, and `ctest --preset dev` to `ctest --preset all`: each takes more than about
# twenty seconds of a processor. What they prove has a quicker test too, or changes rarely. Regular expressions of whole
# names; of render tests, of whole suites.
set(HALFLIGHT_NIGHTLY
    # Every moment of an interruption, every farm that breaks, whole pictures against the path tracer.
    [[cli\.(InterruptAnywhere|Truth|View|ViewBake|Farm|FarmTrouble|Slurm|Parallel|Boards|Pictures|Sheets|Georeferenced|Chain)]]
    [[cli\.(FullDisk|Glass|TextureSets|Streams|Reach|AllLayouts)]]
    [[package\.(bare_root|clean_roots|demo|launcher|consumer|small_build)]]
    # Browsers draw on the processor: shadows, sky, area lights, light groups, WebGPU, the viewer page.
    [[web\.browser_(pictures|webgpu|surfaces|use|groups|viewer|viewer_rooms)]] [[web\.keeps_bake]]
    # Large worlds and high sample counts.
    [[.*HousesS14.*]]
    [[ProbeWorldsS14\.(Village|ProbesFollowSurfacesAndNotTheWorld)]]
    [[QualityS14\.ProbesDoNotSeeThroughWalls]]
    [[QualityS6\.(ClosedRoomsStayDark|DenoisingKeepsContactShadows)]]
    [[ProbesS14\.DenoisingComesCloserInLightAndDirection]]
    [[BakeSession\.EndsSoonWhenCancelledAtAHundredMoments]]
    [[InterruptedBake.*]]
    [[KeptAndNewLayoutsOfOneMesh\..*]]
    [[UnwrapLarge\..*]]
    [[Validator\.BakedSharedScenesHaveNoErrors]]
    [[ReferencePicture.*]]
    [[MixedPicture.*]]
    [[OnePlaneS6S7.*]]
    [[.*WholeBakesS6.*]]
    # A device that fails at every launch of a bake; coloured glass and light groups on a device.
    [[GpuFaults]] [[DeviceGlassS35]] [[DeviceGroupsS33]]
    # Light groups with a cache, a farm and in pictures; every filter of shadow maps.
    [[GroupCacheS33]] [[LightGroupPicturesS33]] [[ShadowFiltersS2]]
    [[ShowcaseS26.*]])
list(JOIN HALFLIGHT_NIGHTLY "|" HALFLIGHT_NIGHTLY)
set(HALFLIGHT_NIGHTLY "^(${HALFLIGHT_NIGHTLY})$")

# Labels a test by where it runs: nightly, else device (Vulkan, a browser), else fast.
function(halflight_time_label name labels result)
    if(name MATCHES "${HALFLIGHT_NIGHTLY}" OR ";${labels};" MATCHES ";nightly;")
        set(${result} nightly PARENT_SCOPE)
    elseif(";${labels};" MATCHES ";vulkan;" OR name MATCHES "^web\\.browser")
        set(${result} device PARENT_SCOPE)
    else()
        set(${result} fast PARENT_SCOPE)
    endif()
endfunction()
