// What paths read of the scene: GpuPaths::Tables of src/bake_gpu/gather/path_tables.cpp.
#ifndef HALFLIGHT_BAKE_PATH_TABLES_GLSL
#define HALFLIGHT_BAKE_PATH_TABLES_GLSL

#include "../mathematics.glsl"

#include "../gather.glsl"
#include "../surfaces.glsl"

#include "bake_gpu/gather/path_layout.h"
#include "halflight/shading/light_source.h"
#include "halflight/shading/light_tree.h"

layout(buffer_reference, scalar) buffer PathFaces { GpuPathFace at[]; };
layout(buffer_reference, scalar) buffer PathParts { GpuPathPart at[]; };
layout(buffer_reference, scalar) buffer PathMaterials { GpuPathMaterial at[]; };
layout(buffer_reference, scalar) buffer Emitters { GpuEmitter at[]; };
layout(buffer_reference, scalar) buffer LightSources { LightSource at[]; };
layout(buffer_reference, scalar) buffer LightTree { LightNode at[]; };
layout(buffer_reference, scalar) buffer Colors { vec4 at[]; };

// SceneLight::Chooser: the lights of a component.
struct LightChooser {
    Words always; // lights that are considered at each point
    LightTree tree; // the others
    Words lightOfItem;
    uint alwaysCount;
    uint nodes; // of the tree
    uint component;
};
layout(buffer_reference, scalar) buffer LightChoosers { LightChooser at[]; };

layout(buffer_reference, scalar) buffer PathTables
{
    PathFaces faces;         // by hit index
    PathParts parts;
    PathMaterials materials;
    SurfaceData surfaces;
    Colors colors;           // by stored vertex
    Pairs uv[kPathTextureSets];
    Pictures pictures;
    Words texels;            // of all pictures, four bytes each
    Floats linear;           // by byte in sRGB
    Vectors levels[kPathLevels]; // of the radiance cache, by patch
    Vectors componentLevels[kPathLevels]; // by patch, then by component
    LightSources lights;
    LightChoosers choosers;
    Emitters emitters;
    LightTree emitterTree;
    Words leafOfEmitter;
    Words brightAreas;       // of the sky's picture
    AliasBins brightBins;
    GpuPathConstants all;
};

PathTables paths()
{
    return PathTables(push.tables.paths);
}

LightNode lightNodeAt(LightTree tree, uint node)
{
    return tree.at[node];
}
#define Tree LightTree
#include "transport/sample/light_walk.h"
#undef Tree

#endif
