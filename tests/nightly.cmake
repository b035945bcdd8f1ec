# Tests that scripts/test.sh leaves to --all, and `ctest --preset dev` to `ctest --preset all`: each takes more than about
# twenty seconds of a processor. What they prove has a quicker test too, or changes rarely. Regular expressions of whole
# names; of render tests, of whole suites.
set(HALFLIGHT_NIGHTLY
    # Every moment of an interruption, every farm that breaks, whole pictures against the path tracer.
    [[cli\.(InterruptAnywhere|Truth|View|ViewBake|Farm|FarmTrouble|Slurm|Parallel|Boards|Pictures|Sheets|Georeferenced|Chain)]]
    [[cli\.(FullDisk|Glass|TextureSets|Streams|Reach|AllLayouts|Identities|SharedSheets|Emission|Variants|ReflectionProbes)]]
    # Many small bakes and pictures: what is said of lights, groups and choices.
    [[cli\.(RenderReports|Choices|ChangingGroups)]]
    [[package\.(bare_root|clean_roots|demo|launcher|consumer|small_build|python_module)]]
    # Browsers draw on the processor: shadows, sky, area lights, light groups, WebGPU, the viewer page.
    [[web\.browser_(pictures|webgpu|surfaces|use|groups|viewer|viewer_rooms)]] [[web\.(keeps_bake|packages|gltf_transform)]]
    # Large worlds, large scenes and high sample counts.
    [[.*(SharedScenes|RoundTrip)\..*/(teapots_galore_instanced|dream_apartment_no_uv|sponza_crytek|grass_field_instanced)]]
    [[.*HousesS14.*]]
    [[ProbeWorldsS14\.(Village|ProbesFollowSurfacesAndNotTheWorld)]]
    [[QualityS14\.ProbesDoNotSeeThroughWalls]]
    [[QualityS6\.(ClosedRoomsStayDark|DenoisingKeepsContactShadows)]]
    [[ProbesS14\.DenoisingComesCloserInLightAndDirection]]
    [[BakeSession\.EndsSoonWhenCancelledAtAHundredMoments]]
    [[InterruptedBake.*]]
    [[KeptAndNewLayoutsOfOneMesh\..*]] [[.*SharedKeptLayouts\..*/lightmap_scales]]
    [[UnwrapLarge\..*]]
    [[Validator\.BakedSharedScenesHaveNoErrors]]
    [[ReferencePicture.*]]
    [[MixedPicture.*]]
    [[OnePlaneS6S7.*]]
    [[.*WholeBakesS6.*]]
    # A device that fails at every launch of a bake; coloured glass and light groups on a device.
    [[GpuFaults]] [[DeviceGlassS35]] [[DeviceGroupsS33]]
    # Light groups with a cache, a farm and in pictures.
    [[GroupCacheS33]] [[LightGroupPicturesS33]] [[LampStatesS33\..*]]
    # Every filter of shadow maps, and their creases, edges and penumbrae.
    [[(ShadowFilters|Creases|ShadowEdges|Penumbrae)S2]]
    [[ShowcaseS26.*]])

# Labels a test by where it runs: nightly, else device (Vulkan, a browser), else fast.
function(halflight_time_label name labels result)
    set(time fast)
    if(";${labels};" MATCHES ";vulkan;" OR name MATCHES "^web\\.browser")
        set(time device)
    endif()
    foreach(pattern IN LISTS HALFLIGHT_NIGHTLY) # joined, they would have more parentheses than CMake takes
        if(name MATCHES "^(${pattern})$")
            set(time nightly)
        endif()
    endforeach()
    if(";${labels};" MATCHES ";nightly;")
        set(time nightly)
    endif()
    set(${result} ${time} PARENT_SCOPE)
endfunction()
