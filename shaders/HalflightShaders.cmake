# halflight_shaders(TARGET [VARIANT NAME] FILE…): compiles GLSL entry points of shaders/ to SPIR-V arrays that TARGET's sources include as
# "shaders/NAME.h", e.g. "shaders/lit.frag.h" with `const uint32_t lit_frag[]`, or bake/x.comp as "shaders/bake/x.comp.h" with `bake_x_comp`. Compiled again when any included file changes.
# VARIANT defines HALFLIGHT_NAME in the shaders; tinted ones are "shaders/bake/x.rgen.tinted.h" with `bake_x_rgen_tinted`.
set(HALFLIGHT_SHADER_DIR ${CMAKE_CURRENT_LIST_DIR})
function(halflight_shaders target)
    cmake_parse_arguments(PARSE_ARGV 1 arg "" VARIANT "")
    set(defines)
    set(suffix)
    if(arg_VARIANT)
        string(TOUPPER ${arg_VARIANT} define)
        set(defines -DHALFLIGHT_${define})
        set(suffix .${arg_VARIANT})
    endif()
    set(out_dir ${CMAKE_CURRENT_BINARY_DIR}/generated/shaders)
    set(outputs)
    foreach(shader ${arg_UNPARSED_ARGUMENTS})
        string(REGEX REPLACE "[./]" "_" variable ${shader}${suffix})
        set(output ${out_dir}/${shader}${suffix}.h)
        get_filename_component(folder ${output} DIRECTORY)
        file(MAKE_DIRECTORY ${folder})
        # Sizes of groups in SPIR-V 1.6 need maintenance4, which devices that draw need not have enabled.
        set(environment vulkan1.3)
        if(shader MATCHES "^[^/]*[.]comp$")
            set(environment vulkan1.2)
        endif()
        add_custom_command(OUTPUT ${output}
            COMMAND Vulkan::glslangValidator -V --target-env ${environment} --quiet --depfile ${output}.d --vn ${variable} ${defines}
                -I${PROJECT_SOURCE_DIR}/include -I${PROJECT_SOURCE_DIR}/src -I${HALFLIGHT_SHADER_DIR}
                -o ${output} ${HALFLIGHT_SHADER_DIR}/${shader}
            DEPENDS ${HALFLIGHT_SHADER_DIR}/${shader}
            DEPFILE ${output}.d
            COMMENT "Compiling shader ${shader}${suffix}"
            VERBATIM)
        list(APPEND outputs ${output})
    endforeach()
    target_sources(${target} PRIVATE ${outputs})
    target_include_directories(${target} PRIVATE ${CMAKE_CURRENT_BINARY_DIR}/generated)
endfunction()
